/* -- spin draw, steps 6 and 7: outcomes, and states ------------------------------------------------

   From scores to states over V and a/V, as tables/FORMAT.md, "The spin law", steps 6 and 7. Outcomes are
   ratios of energies, so whatever they are, the energies after the impact add up to the energy E before
   it. */

/* Step 6: scores become places among the knots of the leaf's quantiles. */
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
            /* above the first knot, so that the particle leaves the wall: v stays positive */
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

/* Places among knots become outcomes. */
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
}

/* Rows of the values of step 7: the first six variables, then these. */
enum { RBTI_INERTIA_AFTER = 6, RBTI_NORMAL, RBTI_SHEAR, RBTI_STATE_ROWS };

/* Outcomes become variables, inertia and works. The normal work is the share a^6 of both works. */
RBTI_INLINE RBT_DEVICE void rbti_fill_values(size_t m, size_t outcomes, const rbti_spin_draws *d,
                                             double *values)
{
    RBTI_EACH_DRAW(r) {
        const float *outcome = d->outcomes + r;
        const double p_u = (double)outcome[RBTI_OUT_P_U * m], p_v = (double)outcome[RBTI_OUT_P_V * m];
        const double p_w = (double)outcome[RBTI_OUT_P_W * m], x = (double)outcome[RBTI_OUT_O_X * m];
        const double y = (double)outcome[RBTI_OUT_O_Y * m], z = (double)outcome[RBTI_OUT_O_Z * m];
        const double kappa = rbti_bounded((double)outcome[RBTI_OUT_KAPPA * m], 0.0, 1.0);
        const double after = rbti_inertia_at(kappa, d->least[r], d->most[r]);
        const double rotation_and_loss = d->energy[r] / (1.0 + rbti_square(p_u, p_v, p_w));
        const double loss = rotation_and_loss / (1.0 + rbti_square(x, y, z)), sign = d->sign[r];
        const double per_p = sqrt(rotation_and_loss), per_o = sqrt(loss / after);
        values[RBT_U * m + r] = p_u * per_p;
        values[RBT_V * m + r] = p_v * per_p;
        values[RBT_W * m + r] = sign * p_w * per_p;
        values[RBT_OMEGA_X * m + r] = sign * per_o * x;
        values[RBT_OMEGA_Y * m + r] = sign * per_o * y;
        values[RBT_OMEGA_Z * m + r] = per_o * z;
        values[RBTI_INERTIA_AFTER * m + r] = after;
        if (outcomes == RBTI_MOST_OUTCOMES) {
            const double a = rbti_bounded((double)outcome[RBTI_OUT_A * m], 0.0, 1.0), cube = a * a * a;
            values[RBTI_NORMAL * m + r] = cube * cube * loss;
            values[RBTI_SHEAR * m + r] = loss - cube * cube * loss;
        }
    }
}

/* Step 7: outcomes become states of `count` draws, the first six variables or all, and inertias. */
RBTI_INLINE RBT_DEVICE void rbti_to_spin_states(size_t m, size_t count, size_t outcomes,
                                                int variables, const rbt_table *table,
                                                const rbti_spin_draws *d, double *states,
                                                double *after)
{
    double values[RBTI_STATE_ROWS * RBTI_BLOCK] RBTI_ALIGNED;
    const size_t width = (size_t)variables;
    rbti_fill_values(m, outcomes, d, values);
    for (size_t k = 0; k < RBT_VALUES; k++) { /* compilers know this number, not `width` */
        if (k >= width)
            break;
        const int is_work = k == RBT_WORK_NORMAL || k == RBT_WORK_SHEAR;
        const size_t row = is_work ? RBTI_NORMAL + (k - RBT_WORK_NORMAL) : k;
        const int known = k <= RBT_OMEGA_Z || (is_work && outcomes == RBTI_MOST_OUTCOMES);
        const int is_stored = known && rbti_has_variable(table, (int)k);
        for (size_t r = 0; r < count; r++)
            states[width * r + k] = is_stored ? values[row * m + r] : 0.0;
    }
    for (size_t r = 0; r < count && after; r++)
        after[r] = values[RBTI_INERTIA_AFTER * m + r];
}
