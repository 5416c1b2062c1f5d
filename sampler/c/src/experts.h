/* Eight numbers that one instruction takes, where compilers have them. */
#if defined(__GNUC__) && !defined(RBTI_GPU) && (defined(__clang__) || __GNUC__ >= 9)
#define RBTI_VECTORS 1
typedef int16_t rbti_shorts __attribute__((vector_size(16)));
typedef int32_t rbti_longs __attribute__((vector_size(32)));
typedef float rbti_singles __attribute__((vector_size(32)));
#endif

/* Sums of eight numbers side by side, times a factor, over `rows` of them; row k begins `stride` k
   numbers behind the first, less `shrink` k (k + 1) / 2. Its first `shrink` k sums are left as they
   are. As a loop over an array the sums would wait for memory in every row. */
RBTI_INLINE RBT_DEVICE void rbti_sum_eight(size_t m, size_t rows, const int16_t *numbers,
                                           size_t stride, size_t shrink, const float *factors,
                                           float *sums)
{
#ifdef RBTI_VECTORS
    static const float window[15] = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f,
                                     1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f};
    rbti_singles total;
    memcpy(&total, sums, sizeof total);
    for (size_t row = 0; row < rows; row++) {
        rbti_shorts raw;
        memcpy(&raw, numbers + (row * stride - shrink * (row * (row + 1) / 2)), sizeof raw);
        const rbti_longs wide = __builtin_convertvector(raw, rbti_longs);
        rbti_singles factor = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
        factor = factors[row * m] - factor;
        if (shrink > 0) {
            rbti_singles ones;
            memcpy(&ones, window + 7 - row, sizeof ones);
            factor *= ones;
        }
        total += __builtin_convertvector(wide, rbti_singles) * factor;
    }
    memcpy(sums, &total, sizeof total);
#else
    for (size_t row = 0; row < rows; row++)
        for (size_t k = shrink * row; k < 8; k++)
            sums[k] += factors[row * m] *
                       (float)numbers[row * stride - shrink * (row * (row + 1) / 2) + k];
#endif
}

/* Sums over the features of each draw times `count` coefficients that lie side by side. */
RBTI_INLINE RBT_DEVICE void rbti_fill_logits(size_t m, size_t count, const int16_t *gates,
                                             const int32_t *places, const float *features,
                                             float *logits)
{
    RBTI_EACH_DRAW(r) {
        const int16_t *gate = gates + RBTI_FEATURES * count * (size_t)places[r];
        float sums[RBTI_GROUP_SIZE] RBTI_ALIGNED;
        for (size_t k = 0; k < count; k++)
            sums[k] = 0.0f;
        for (size_t k = 0; k < count; k += 8)
            rbti_sum_eight(m, RBTI_FEATURES, gate + k, count, 0, features + r, sums + k);
        for (size_t k = 0; k < count; k++)
            logits[k * m + r] = sums[k];
    }
}

/* A number below `count` for each draw, by weights that are exponentials, from words. */
RBTI_INLINE RBT_DEVICE void rbti_choose(size_t m, size_t count, const int16_t *gates,
                                        const int32_t *places, const float *features,
                                        const uint32_t *words, int32_t *chosen)
{
    float weights[RBTI_GROUP_SIZE * RBTI_BLOCK] RBTI_ALIGNED;
    float most[RBTI_BLOCK] RBTI_ALIGNED, share[RBTI_BLOCK] RBTI_ALIGNED;
    rbti_fill_logits(m, count, gates, places, features, weights);
    RBTI_EACH_DRAW(r)
        most[r] = weights[r];
    for (size_t k = 1; k < count; k++) {
        RBTI_EACH_DRAW(r)
            most[r] = weights[k * m + r] > most[r] ? weights[k * m + r] : most[r];
    }
    for (size_t k = 0; k < count; k++) {
        RBTI_EACH_DRAW(r) {
            const float x = (weights[k * m + r] - most[r]) * RBTI_GATE_UNIT;
            weights[k * m + r] = rbti_least_power(x * RBTI_LOG2_E);
        }
        RBTI_EACH_DRAW(r)
            weights[k * m + r] = rbti_power_of_two(weights[k * m + r]);
    }
    for (size_t k = 1; k < count; k++) {
        RBTI_EACH_DRAW(r)
            weights[k * m + r] += weights[(k - 1) * m + r];
    }
    RBTI_EACH_DRAW(r) {
        share[r] = ((float)(int32_t)(words[r] >> 8) + 0.5f) * (1.0f / 16777216.0f);
        share[r] *= weights[(count - 1) * m + r];
        chosen[r] = 0;
    }
    for (size_t k = 0; k + 1 < count; k++) {
        RBTI_EACH_DRAW(r)
            chosen[r] += share[r] >= weights[k * m + r];
    }
}

/* Group of experts and expert of each draw, numbered through all leaves. */
RBTI_INLINE RBT_DEVICE void rbti_choose_expert(size_t m, size_t outcomes, const rbt_spin_law *law,
                                               rbti_spin_draws *d)
{
    const size_t numbers = RBTI_FEATURES * RBTI_GROUP_SIZE, stride = rbti_expert_stride(outcomes);
    rbti_choose(m, RBTI_GROUPS, law->group_gates, d->leaf, d->features, d->words, d->group);
    RBTI_EACH_DRAW(r) {
        d->group[r] += d->leaf[r] * RBTI_GROUPS;
        const int16_t *gates = law->gates + numbers * (size_t)d->group[r];
        for (size_t k = 0; k < numbers; k += RBTI_LINE)
            RBTI_PREFETCH(gates + k);
    }
    rbti_choose(m, RBTI_GROUP_SIZE, law->gates, d->group, d->features, d->words + m, d->expert);
    RBTI_EACH_DRAW(r) {
        d->expert[r] += d->group[r] * RBTI_GROUP_SIZE;
        const int16_t *record = law->experts + stride * (size_t)d->expert[r];
        for (size_t k = 0; k < stride; k += RBTI_LINE)
            RBTI_PREFETCH(record + k);
    }
}

/* Normals to scores: mean and factor of the expert. Eight rows are read, of which the outcomes count. */
RBTI_INLINE RBT_DEVICE void rbti_fill_scores(size_t m, size_t outcomes, const rbt_spin_law *law,
                                             rbti_spin_draws *d)
{
    const size_t stride = rbti_expert_stride(outcomes);
    for (size_t k = 0; k < outcomes; k++) {
        RBTI_EACH_DRAW(r)
            d->scores[k * m + r] *= RBTI_FACTOR_UNIT;
    }
    RBTI_EACH_DRAW(r) {
        const int16_t *record = law->experts + stride * (size_t)d->expert[r];
        const int16_t *factors = record + RBTI_FEATURES * outcomes;
        float sums[8] RBTI_ALIGNED;
        for (size_t k = 0; k < 8; k++)
            sums[k] = 0.0f;
        rbti_sum_eight(m, RBTI_FEATURES, record, outcomes, 0, d->features + r, sums);
        for (size_t k = 0; k < 8; k++)
            sums[k] *= RBTI_MEAN_UNIT;
        rbti_sum_eight(m, outcomes, factors, outcomes, 1, d->scores + r, sums);
        for (size_t k = 0; k < outcomes; k++)
            d->scores[k * m + r] = sums[k];
    }
}

/* Scores to places among the knots of the leaf's quantiles. */
RBTI_INLINE RBT_DEVICE void rbti_find_knots(size_t m, int32_t outcomes, const rbt_spin_law *law,
                                            rbti_spin_draws *d)
{
    const int32_t last = law->n_knots - 2, knots = law->n_knots;
    const float scale = (float)(law->n_knots - 1) / (RBTI_SCORE_MAX + RBTI_SCORE_MAX);
    for (int32_t row = 0; row < outcomes; row++) {
        float *scores = d->scores + (size_t)row * m;
        int32_t *entries = d->entries + (size_t)row * m;
        RBTI_EACH_DRAW(r) {
            const float z = scores[r];
            const float bounded = z / sqrtf(1.0f + z * z * RBTI_PER_SQUARE);
            float position = (bounded + RBTI_SCORE_MAX) * scale;
            /* above the first knot, so that v stays positive */
            position = position > 1.0f / 1048576.0f ? position : 1.0f / 1048576.0f;
            int32_t knot = (int32_t)position;
            knot = knot < last ? knot : last;
            position -= (float)knot;
            scores[r] = position < 1.0f ? position : 1.0f;
            entries[r] = (d->leaf[r] * outcomes + row) * knots + knot;
        }
        RBTI_EACH_DRAW(r)
            RBTI_PREFETCH(law->quantiles + entries[r]);
    }
}

/* Places among knots to outcomes. */
RBTI_INLINE RBT_DEVICE void rbti_fill_outcomes(size_t m, int32_t outcomes, const rbt_spin_law *law,
                                               rbti_spin_draws *d)
{
    for (int32_t row = 0; row < outcomes; row++) {
        const size_t at = (size_t)row * m;
        uint32_t pair[RBTI_BLOCK] RBTI_ALIGNED;
        float least[RBTI_BLOCK] RBTI_ALIGNED, step[RBTI_BLOCK] RBTI_ALIGNED;
        RBTI_EACH_DRAW(r) {
            const float *span = law->spans + 2 * (d->leaf[r] * outcomes + row);
            memcpy(pair + r, law->quantiles + d->entries[at + r], sizeof *pair);
            least[r] = span[0];
            step[r] = span[1];
        }
        RBTI_EACH_DRAW(r) {
            const float low = (float)(int32_t)(pair[r] & 0xffffu);
            const float high = (float)(int32_t)(pair[r] >> 16);
            d->outcomes[at + r] = least[r] + step[r] * (low + d->scores[at + r] * (high - low));
        }
    }
