/* -- spin draw, steps 4 and 5: an expert, and its scores -------------------------------------------

   From features to scores, in single precision, as tables/FORMAT.md, "The spin law", steps 4 and 5.
   Features choose one of 8 groups of a leaf and one of 8 experts of the group, by a softmax of linear
   forms; the scores are normal, with the means and the factor of the expert. */

/* Eight numbers that one instruction takes, if the compiler has such types. If the sums below were loops
   over an array, they would wait for memory in every row. */
#if defined(__GNUC__) && !defined(RBTI_GPU) && (defined(__clang__) || __GNUC__ >= 9)
#define RBTI_VECTORS 1
typedef int32_t rbti_longs __attribute__((vector_size(32)));
typedef float rbti_singles __attribute__((vector_size(32)));

RBTI_INLINE void rbti_load_eight(const int16_t *numbers, rbti_singles *eight)
{
    const rbti_longs longs = {numbers[0], numbers[1], numbers[2], numbers[3],
                              numbers[4], numbers[5], numbers[6], numbers[7]};
    *eight = __builtin_convertvector(longs, rbti_singles);
}
#endif

/* Make eight sums, a vector times a matrix. The matrix has `rows` rows of eight numbers, each of which
   begins `width` numbers behind the row before; factors[row m] is the number of the vector for a row.
   Every fourth row goes into the same part of a sum: so an addition need not wait for the one before. */
RBTI_INLINE RBT_DEVICE void rbti_sum_rows(size_t m, size_t rows, const int16_t *numbers,
                                          size_t width, const float *factors, float *sums)
{
#ifdef RBTI_VECTORS
    rbti_singles parts[4] = {{0.0f}}, eight;
    for (size_t first = 0; first < rows; first += 4)
        for (size_t k = 0; k < 4 && first + k < rows; k++) {
            rbti_load_eight(numbers + (first + k) * width, &eight);
            parts[k] += eight * factors[(first + k) * m];
        }
    parts[0] = (parts[0] + parts[1]) + (parts[2] + parts[3]);
    memcpy(sums, parts, sizeof *parts);
#else
    float parts[4][8] = {{0.0f}};
    for (size_t first = 0; first < rows; first += 4)
        for (size_t k = 0; k < 4 && first + k < rows; k++)
            for (size_t i = 0; i < 8; i++)
                parts[k][i] += factors[(first + k) * m] * (float)numbers[(first + k) * width + i];
    for (size_t i = 0; i < 8; i++)
        sums[i] = (parts[0][i] + parts[1][i]) + (parts[2][i] + parts[3][i]);
#endif
}

/* Add a vector times a triangular matrix to eight sums. Row k of the matrix has numbers for the sums from k
   to `rows`, and rows follow one another without gaps. */
RBTI_INLINE RBT_DEVICE void rbti_add_triangle(size_t m, size_t rows, const int16_t *numbers,
                                              const float *factors, float *sums)
{
#ifdef RBTI_VECTORS
    const rbti_longs places = {0, 1, 2, 3, 4, 5, 6, 7};
    rbti_singles total, eight;
    memcpy(&total, sums, sizeof total);
    for (size_t row = 0; row < rows; row++) {
        rbti_load_eight(numbers, &eight);
        eight *= factors[row * m];
        total += (rbti_singles)((rbti_longs)eight & (places >= (int32_t)row));
        numbers += rows - row - 1;
    }
    memcpy(sums, &total, sizeof total);
#else
    for (size_t row = 0; row < rows; row++) {
        for (size_t k = row; k < rows; k++)
            sums[k] += factors[row * m] * (float)numbers[k];
        numbers += rows - row - 1;
    }
#endif
}

/* Logits of eight choices for each draw: its features times the coefficients at its place among the
   gates. */
RBTI_INLINE RBT_DEVICE void rbti_fill_logits(size_t m, const int16_t *gates, const int32_t *places,
                                             const float *features, float *logits)
{
    RBTI_EACH_DRAW(r) {
        float sums[8] RBTI_ALIGNED;
        rbti_sum_rows(m, RBTI_FEATURES, gates + RBTI_FEATURES * 8 * (size_t)places[r], 8,
                      features + r, sums);
        for (size_t k = 0; k < 8; k++)
            logits[k * m + r] = sums[k];
    }
}

/* Turn logits into weights: their exponentials over the largest of them. */
RBTI_INLINE RBT_DEVICE void rbti_to_weights(size_t m, size_t count, float *logits)
{
    float most[RBTI_BLOCK] RBTI_ALIGNED;
    RBTI_EACH_DRAW(r)
        most[r] = logits[r];
    for (size_t k = 1; k < count; k++) {
        RBTI_EACH_DRAW(r)
            most[r] = logits[k * m + r] > most[r] ? logits[k * m + r] : most[r];
    }
    for (size_t k = 0; k < count; k++) {
        RBTI_EACH_DRAW(r) {
            const float x = (logits[k * m + r] - most[r]) * RBTI_GATE_UNIT;
            logits[k * m + r] = rbti_least_power(x * RBTI_LOG2_E);
        }
        RBTI_EACH_DRAW(r)
            logits[k * m + r] = rbti_power_of_two(logits[k * m + r]);
    }
}

/* Make a choice for each draw, by its weights and the upper 24 bits of a random word. The weights become
   running sums. */
RBTI_INLINE RBT_DEVICE void rbti_pick(size_t m, size_t count, float *weights,
                                      const uint32_t *words, int32_t *picked)
{
    float share[RBTI_BLOCK] RBTI_ALIGNED;
    for (size_t k = 1; k < count; k++) {
        RBTI_EACH_DRAW(r)
            weights[k * m + r] += weights[(k - 1) * m + r];
    }
    RBTI_EACH_DRAW(r) {
        share[r] = ((float)(int32_t)(words[r] >> 8) + 0.5f) * (1.0f / 16777216.0f);
        share[r] *= weights[(count - 1) * m + r];
        picked[r] = 0;
    }
    for (size_t k = 0; k + 1 < count; k++) {
        RBTI_EACH_DRAW(r)
            picked[r] += share[r] >= weights[k * m + r];
    }
}

/* Step 4: the group of experts and the expert of each draw, numbered through all leaves. */
RBTI_INLINE RBT_DEVICE void rbti_choose_expert(size_t m, size_t outcomes, const rbt_spin_law *law,
                                               rbti_spin_draws *d)
{
    const size_t numbers = RBTI_FEATURES * RBTI_GROUP_SIZE, stride = rbti_expert_stride(outcomes);
    float weights[RBTI_GROUPS * RBTI_BLOCK] RBTI_ALIGNED;
    rbti_fill_logits(m, law->group_gates, d->leaf, d->features, weights);
    rbti_to_weights(m, RBTI_GROUPS, weights);
    rbti_pick(m, RBTI_GROUPS, weights, d->words, d->group);
    RBTI_EACH_DRAW(r) {
        d->group[r] += d->leaf[r] * RBTI_GROUPS;
        rbti_prefetch(law->gates + numbers * (size_t)d->group[r], numbers);
    }
    rbti_fill_logits(m, law->gates, d->group, d->features, weights);
    rbti_to_weights(m, RBTI_GROUP_SIZE, weights);
    rbti_pick(m, RBTI_GROUP_SIZE, weights, d->words + m, d->expert);
    RBTI_EACH_DRAW(r) {
        d->expert[r] += d->group[r] * RBTI_GROUP_SIZE;
        rbti_prefetch(law->experts + stride * (size_t)d->expert[r], stride);
    }
}

/* The normal number of p_v of the slowest rebounds: its law is the lower tail of a normal law, with the
   mean 0 and the variance 1. */
RBTI_INLINE RBT_DEVICE float rbti_slowest_normal(float n)
{
    const float x = n - 1.0f, above = sqrtf(x * x + RBTI_SLOW_TAIL_CORE) - x;
    return RBTI_SLOW_TAIL_SHIFT - sqrtf(RBTI_SLOW_TAIL_SQUARE + RBTI_SLOW_TAIL_FACTOR * above * above);
}

/* Step 5: normal numbers become scores, by the means and the factor of the expert. Eight sums are always
   made; only those of outcomes are used. */
RBTI_INLINE RBT_DEVICE void rbti_fill_scores(size_t m, size_t outcomes, const rbt_spin_law *law,
                                             rbti_spin_draws *d)
{
    const size_t stride = rbti_expert_stride(outcomes);
    float *normals = d->scores + RBTI_OUT_P_V * m;
    RBTI_EACH_DRAW(r)
        normals[r] = d->group[r] % RBTI_GROUPS ? normals[r] : rbti_slowest_normal(normals[r]);
    for (size_t k = 0; k < outcomes; k++) {
        RBTI_EACH_DRAW(r)
            d->scores[k * m + r] *= RBTI_FACTOR_UNIT;
    }
    RBTI_EACH_DRAW(r) {
        const int16_t *means = law->experts + stride * (size_t)d->expert[r];
        const int16_t *factor = means + RBTI_FEATURES * outcomes;
        float sums[8] RBTI_ALIGNED;
        rbti_sum_rows(m, RBTI_FEATURES, means, outcomes, d->features + r, sums);
        for (size_t k = 0; k < 8; k++)
            sums[k] *= RBTI_MEAN_UNIT;
        rbti_add_triangle(m, outcomes, factor, d->scores + r, sums);
        for (size_t k = 0; k < outcomes; k++)
            d->scores[k * m + r] = sums[k];
    }
}
