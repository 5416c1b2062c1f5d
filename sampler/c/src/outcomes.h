/* -- spin draw, steps 6 and 7: outcomes, and states ------------------------------------------------

   From scores to states over V and a/V, as tables/FORMAT.md, "The spin law", steps 6 and 7. Outcomes move
   a point of a sphere, and divide an energy. So whatever they are, the energies after the impact add up to
   the energy E before it. */

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

/* Outcomes o become the part d of the motion after the impact, and what is left of the energy for the
   contact and the wall. The point before the impact is (pole, base), and the outcomes move it. */
RBTI_INLINE RBT_DEVICE void rbti_fill_rest(size_t m, const rbti_spin_draws *d, double *rest,
                                           double *left)
{
    RBTI_EACH_DRAW(r) {
        const float *outcome = d->outcomes + r;
        const double half = 0.5 * d->o_unit[r], side = half * d->side_unit[r];
        const double a = d->base[r], b = d->base[m + r], c = d->base[2 * m + r];
        const double pole = sqrt(1.0 - rbti_square(a, b, c));
        const double x = side * (double)outcome[RBTI_OUT_O_X * m];
        const double y = side * (double)outcome[RBTI_OUT_O_Y * m];
        const double z = half * (double)outcome[RBTI_OUT_O_Z * m];
        const double square = rbti_square(x, y, z), per = 2.0 / (1.0 + square);
        const double ahead = 0.5 * per * (1.0 - square), along = per * (a * x + b * y + c * z);
        const double back = ahead - along / (1.0 + pole), up = pole * ahead - along;
        const double other = up < 0.0 ? -up : up;
        const double above = other > RBTI_LEAST_LEFT ? other : RBTI_LEAST_LEFT;
        const double after_x = per * x + a * back, after_y = per * y + b * back;
        const double after_z = per * z + c * back;
        const double size = rbti_square(after_x, after_y, after_z) + above * above;
        const double scale = sqrt(d->energy[r] / size);
        rest[r] = scale * after_x;
        rest[m + r] = scale * after_y;
        rest[2 * m + r] = scale * after_z;
        left[r] = d->energy[r] / size * above * above;
    }
}

/* e^x, for x from -87 to 87; other numbers count as the nearest of these. */
RBTI_INLINE RBT_DEVICE double rbti_exponential(double x)
{
    const float y = (float)x * RBTI_LOG2_E;
    const double power = (double)rbti_power_of_two(rbti_least_power(y < 0.0f ? y : -y));
    return y < 0.0f ? power : 1.0 / power;
}

/* Outcomes p of a draw that count from a sphere become those of the draw by itself: beside the sphere's v,
   and beside the g with which the grain, whatever its spin, has the sphere's u and no w. */
RBTI_INLINE RBT_DEVICE void rbti_take_sphere(size_t m, size_t r, const rbti_spin_draws *d,
                                             const double *rest, const double *left, double *p)
{
    const double first = d->sphere[m + r] / sqrt(d->taken[r]), tan_f = d->sine[r] / d->cosine[r];
    const double x = 0.5 * d->p_unit[r] * (p[m + r] - 1.0 / p[m + r]), root = sqrt(x * x + first * first);
    const double p_v = x > 0.0 ? x + root : first * first / (root - x);
    const double most = d->taken[r] + d->sphere[m + r] * d->sphere[m + r];
    const double kept = 0.5 * (most < left[r] ? most : left[r]);
    double g_u = d->sphere[r] / d->cosine[r] + rest[2 * m + r] * tan_f, g_w = -rest[r] * tan_f;
    const double square = g_u * g_u + g_w * g_w;
    const double shorter = square > left[r] - kept ? sqrt((left[r] - kept) / square) : 1.0;
    const double rest_of_v = square > left[r] - kept ? kept : left[r] - square;
    const double per_p = sqrt((1.0 + p_v * p_v) / rest_of_v) * shorter;
    p[r] = per_p * g_u + d->p_unit[m + r] * p[r];
    p[m + r] = p_v;
    p[2 * m + r] = per_p * g_w + d->p_unit[m + r] * p[2 * m + r];
}

/* Outcomes become variables, inertia and works. The normal work is the share a^6 of both works. */
RBTI_INLINE RBT_DEVICE void rbti_fill_values(size_t m, size_t outcomes, const rbt_table *table,
                                             const rbti_spin_draws *d, double *values)
{
    double rest[3 * RBTI_BLOCK] RBTI_ALIGNED, left[RBTI_BLOCK] RBTI_ALIGNED;
    double p[3 * RBTI_BLOCK] RBTI_ALIGNED;
    rbti_fill_rest(m, d, rest, left);
    for (size_t k = 0; k < 3; k++) {
        RBTI_EACH_DRAW(r)
            p[k * m + r] = (double)d->outcomes[(RBTI_OUT_P_U + k) * m + r];
    }
    RBTI_EACH_DRAW(r) {
        p[m + r] *= d->rise[r];
        p[2 * m + r] = p[2 * m + r] * d->side_unit[r] + d->slide[r] * p[r];
    }
    for (size_t r = 0; r < m && table->laws; r++)
        if (d->by_sphere[r])
            rbti_take_sphere(m, r, d, rest, left, p);
    RBTI_EACH_DRAW(r) {
        const float *outcome = d->outcomes + r;
        const double p_u = p[r], p_v = p[m + r], p_w = p[2 * m + r], sign = d->sign[r];
        const double ratio = rbti_exponential(d->h_unit[r] * (double)outcome[RBTI_OUT_H * m]);
        const double first = ratio * d->odds[r], second = d->odds[m + r];
        const double after = rbti_inertia_at(first / (first + second), d->least[r], d->most[r]);
        const double loss = left[r] / (1.0 + rbti_square(p_u, p_v, p_w));
        const double per_p = sqrt(loss), per_y = 1.0 / sqrt(after);
        const double cosine = d->cosine[r], sine = d->sine[r];
        const double g_u = per_p * p_u, g_w = per_p * p_w;
        values[RBT_U * m + r] = g_u * cosine - rest[2 * m + r] * sine;
        values[RBT_V * m + r] = per_p * p_v;
        values[RBT_W * m + r] = sign * (g_w * cosine + rest[r] * sine);
        values[RBT_OMEGA_X * m + r] = sign * per_y * (rest[r] * cosine - g_w * sine);
        values[RBT_OMEGA_Y * m + r] = sign * per_y * rest[m + r];
        values[RBT_OMEGA_Z * m + r] = per_y * (g_u * sine + rest[2 * m + r] * cosine);
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
    rbti_fill_values(m, outcomes, table, d, values);
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
