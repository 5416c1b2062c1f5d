/* -- spin draw, steps 6 and 7: outcomes, and states -------------------------------------------- */

/* Step 6: scores to places among the knots of the leaf's quantiles. */
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
}

/* Outcomes of a table with laws of contact are less those of the sphere with the mean moment of inertia
   of the grain, in the condition of the draw, over 1 - c/a: add these. */
RBTI_NOT_INLINED RBT_DEVICE void rbti_add_spheres(size_t m, const rbt_table *table,
                                                  rbti_spin_draws *d)
{
    RBTI_EACH_DRAW(r) {
        const double b_a = d->inputs[RBTI_IN_B_A * m + r];
        const double c_a = b_a * d->inputs[RBTI_IN_C_B * m + r];
        const double flat = rbti_bounded(1.0 - c_a, RBTI_LEAST_FLATNESS, 1.0);
        const double radius = sqrt((1.0 + b_a * b_a + c_a * c_a) / 3.0); /* over that of the grain */
        const double root = d->inputs[RBTI_IN_ROOT_ANGLE * m + r], j = RBTI_SPHERE_INERTIA;
        double spin[3], of[RBT_VALUES];
        for (size_t k = 0; k < 3; k++)
            spin[k] = radius * d->spin[k * m + r];
        rbti_sphere(table, root * root, d->speed[r], spin, of);
        const double energy = 1.0 + j * rbti_square(spin[0], spin[1], spin[2]);
        const double least = RBTI_LEAST_REST * energy;
        const double left = energy - rbti_square(of[RBT_U], of[RBT_V], of[RBT_W]);
        const double loss = left - j * rbti_square(of[RBT_OMEGA_X], of[RBT_OMEGA_Y],
                                                   of[RBT_OMEGA_Z]);
        const double per_speed = 1.0 / sqrt(left > least ? left : least);
        const double per_spin = sqrt(j / (loss > least ? loss : least));
        for (size_t k = RBTI_OUT_P_U; k <= RBTI_OUT_O_Z; k++) {
            float *outcome = d->outcomes + k * m + r;
            const double own = of[k] * (k <= RBTI_OUT_P_W ? per_speed : per_spin);
            const double scatter = flat * (double)*outcome;
            *outcome = (float)(k == RBTI_OUT_P_V ? own * exp(rbti_bounded(scatter, -RBTI_MOST_POWER,
                                                                          RBTI_MOST_POWER))
                                                 : own + scatter);
        }
    }
}

/* Rows of what step 7 makes: the first six variables, then these. */
enum { RBTI_INERTIA_AFTER = 6, RBTI_NORMAL, RBTI_SHEAR, RBTI_STATE_ROWS };

/* Outcomes to variables, inertia and works, of which the normal one has the share a^6. */
RBTI_INLINE RBT_DEVICE void rbti_fill_values(size_t m, size_t outcomes, const rbti_spin_draws *d,
                                             double *values)
{
    RBTI_EACH_DRAW(r) {
        const float *of = d->outcomes + r;
        const double p_u = (double)of[RBTI_OUT_P_U * m], p_v = (double)of[RBTI_OUT_P_V * m];
        const double p_w = (double)of[RBTI_OUT_P_W * m], x = (double)of[RBTI_OUT_O_X * m];
        const double y = (double)of[RBTI_OUT_O_Y * m], z = (double)of[RBTI_OUT_O_Z * m];
        const double kappa = rbti_bounded((double)of[RBTI_OUT_KAPPA * m], 0.0, 1.0);
        const double after = rbti_inertia_at(kappa, d->least[r], d->most[r]);
        const double left = d->energy[r] / (1.0 + rbti_square(p_u, p_v, p_w));
        const double loss = left / (1.0 + rbti_square(x, y, z)), sign = d->sign[r];
        const double per_p = sqrt(left), per_o = sqrt(loss / after);
        values[RBT_U * m + r] = p_u * per_p;
        values[RBT_V * m + r] = p_v * per_p;
        values[RBT_W * m + r] = sign * p_w * per_p;
        values[RBT_OMEGA_X * m + r] = sign * per_o * x;
        values[RBT_OMEGA_Y * m + r] = sign * per_o * y;
        values[RBT_OMEGA_Z * m + r] = per_o * z;
        values[RBTI_INERTIA_AFTER * m + r] = after;
        if (outcomes == RBTI_MOST_OUTCOMES) {
            const double a = rbti_bounded((double)of[RBTI_OUT_A * m], 0.0, 1.0), cube = a * a * a;
            values[RBTI_NORMAL * m + r] = cube * cube * loss;
            values[RBTI_SHEAR * m + r] = loss - cube * cube * loss;
        }
    }
}

/* Step 7: outcomes to states of `count` draws, the first six variables or all, and to inertias. */
RBTI_INLINE RBT_DEVICE void rbti_to_spin_states(size_t m, size_t count, size_t outcomes,
                                                int variables, const rbt_table *table,
                                                const rbti_spin_draws *d, double *states,
                                                double *after)
{
    double values[RBTI_STATE_ROWS * RBTI_BLOCK] RBTI_ALIGNED;
    const size_t width = (size_t)variables;
    rbti_fill_values(m, outcomes, d, values);
    for (size_t k = 0; k < RBT_VALUES; k++) { /* a number that compilers know */
        if (k >= width)
            break;
        const int is_work = k >= RBT_WORK_NORMAL;
        const size_t row = is_work ? RBTI_NORMAL + (k - RBT_WORK_NORMAL) : k;
        const int known = k <= RBT_OMEGA_Z || (is_work && outcomes == RBTI_MOST_OUTCOMES);
        const int is_stored = known && rbti_has_variable(table, (int)k);
        for (size_t r = 0; r < count; r++)
            states[width * r + k] = is_stored ? values[row * m + r] : 0.0;
    }
    for (size_t r = 0; r < count && after; r++)
        after[r] = values[RBTI_INERTIA_AFTER * m + r];
}
