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

/* The sphere with the mean moment of inertia of a grain, in the condition of the grain's draw: sizes over
   those of the grain, energies over m V^2 / 2. */
typedef struct rbti_equal_sphere {
    double radius, energy;     /* over a; before the impact */
    double values[RBT_VALUES]; /* its rebound, spins times its own radius */
} rbti_equal_sphere;

/* Rebound of the sphere for draw r. A spin beyond the law is the largest one, of less energy. */
RBTI_INLINE RBT_DEVICE void rbti_rebound_sphere(size_t m, size_t r, const rbt_table *table,
                                                const rbti_spin_draws *d, double b_a, double c_a,
                                                rbti_equal_sphere *sphere)
{
    const rbt_spin_law *law = &table->spin;
    const double radius = sqrt((1.0 + b_a * b_a + c_a * c_a) / 3.0);
    const double x = d->spin[r], y = d->spin[m + r], z = d->spin[2 * m + r];
    const double square = rbti_square(x, y, z), most = law->most_spin;
    const double covered = square > most ? sqrt(most / square) : 1.0, size = radius * covered;
    const double spin[3] = {d->sign[r] * size * x, d->sign[r] * size * y, size * z};
    const double effective = d->speed[r] * rbti_spin_factor(x, y, z);
    const double speed = rbti_bounded(effective, law->speed_first, law->speed_last) /
                         rbti_spin_factor(covered * x, covered * y, covered * z);
    const double root = d->inputs[RBTI_IN_ROOT_ANGLE * m + r];
    rbti_sphere(table, root * root, speed, spin, sphere->values);
    sphere->radius = radius;
    sphere->energy = 1.0 + covered * covered * (d->factor[r] * d->factor[r] - 1.0);
}

/* Outcomes of a table with laws of contact are less those of the sphere, over 1 - c/a: add these. */
RBTI_APART RBT_DEVICE void rbti_add_spheres(size_t m, const rbt_table *table, rbti_spin_draws *d)
{
    RBTI_EACH_DRAW(r) {
        const double b_a = d->inputs[RBTI_IN_B_A * m + r];
        const double c_a = b_a * d->inputs[RBTI_IN_C_B * m + r];
        const double flat = rbti_bounded(1.0 - c_a, RBTI_LEAST_FLATNESS, 1.0);
        rbti_equal_sphere sphere;
        rbti_rebound_sphere(m, r, table, d, b_a, c_a, &sphere);
        const double *of = sphere.values, energy = sphere.energy;
        const double rest = energy - rbti_square(of[RBT_U], of[RBT_V], of[RBT_W]);
        const double per_speed = 1.0 / sqrt(rbti_bounded(rest, RBTI_LEAST_REST * energy, rest));
        const double per_spin = sphere.radius * sqrt(energy);
        float *u = d->outcomes + RBTI_OUT_P_U * m + r, *v = d->outcomes + RBTI_OUT_P_V * m + r;
        float *w = d->outcomes + RBTI_OUT_P_W * m + r;
        const double raised = rbti_bounded(flat * (double)*v, -RBTI_MOST_POWER, RBTI_MOST_POWER);
        *u = (float)(per_speed * of[RBT_U] + flat * (double)*u);
        *v = (float)(per_speed * of[RBT_V] * exp(raised));
        *w = (float)(per_speed * of[RBT_W] + flat * (double)*w);
        for (size_t k = RBTI_OUT_OMEGA_X; k <= RBTI_OUT_OMEGA_Z; k++) {
            float *omega = d->outcomes + k * m + r;
            *omega = (float)(of[k] / per_spin + flat * (double)*omega);
        }
    }
}

/* Works of a rebound: the share b of the energy that is left, of which the normal one has a^6. */
RBTI_INLINE RBT_DEVICE void rbti_share_works(double left, double a, double b, double *normal,
                                             double *shear)
{
    const double cube = a * a * a, sum = left * (b > 1.0 ? 1.0 : b < 0.0 ? 0.0 : b);
    *normal = sum * (cube * cube > 1.0 ? 1.0 : cube * cube);
    *shear = sum - *normal;
}

/* Outcomes to variables, in the rows of the outcomes. With E the square of `factor`, E / (1 + |p|^2) is
   left for the rotation: an angular velocity with more is shortened, and what it leaves goes to works. */
RBTI_INLINE RBT_DEVICE void rbti_fill_values(size_t m, size_t outcomes, const rbti_spin_draws *d,
                                             double *values)
{
    RBTI_EACH_DRAW(r) {
        const float *of = d->outcomes + r;
        const double p_u = (double)of[RBTI_OUT_P_U * m], p_v = (double)of[RBTI_OUT_P_V * m];
        const double p_w = (double)of[RBTI_OUT_P_W * m], x = (double)of[RBTI_OUT_OMEGA_X * m];
        const double y = (double)of[RBTI_OUT_OMEGA_Y * m], z = (double)of[RBTI_OUT_OMEGA_Z * m];
        const double factor = d->factor[r], sign = d->sign[r];
        const double whole = 1.0 + rbti_square(p_u, p_v, p_w), per_p = factor / sqrt(whole);
        const double turning = d->smallest[r] * rbti_square(x, y, z) * whole; /* of what is left */
        const double per_omega = factor / sqrt(turning > 1.0 ? turning : 1.0);
        values[RBTI_OUT_P_U * m + r] = p_u * per_p;
        values[RBTI_OUT_P_V * m + r] = p_v * per_p;
        values[RBTI_OUT_P_W * m + r] = sign * p_w * per_p;
        values[RBTI_OUT_OMEGA_X * m + r] = sign * per_omega * x;
        values[RBTI_OUT_OMEGA_Y * m + r] = sign * per_omega * y;
        values[RBTI_OUT_OMEGA_Z * m + r] = per_omega * z;
        if (outcomes == RBTI_MOST_OUTCOMES)
            rbti_share_works(per_p * per_p * (turning > 1.0 ? 0.0 : 1.0 - turning),
                             (double)of[RBTI_OUT_A * m], (double)of[RBTI_OUT_B * m],
                             values + RBTI_OUT_A * m + r, values + RBTI_OUT_B * m + r);
    }
}

/* Step 7: outcomes to states of `count` draws, the first six variables or all. */
RBTI_INLINE RBT_DEVICE void rbti_to_spin_states(size_t m, size_t count, size_t outcomes,
                                                int variables, const rbt_table *table,
                                                const rbti_spin_draws *d, double *states)
{
    double values[RBTI_MOST_OUTCOMES * RBTI_BLOCK] RBTI_ALIGNED;
    const size_t width = (size_t)variables;
    rbti_fill_values(m, outcomes, d, values);
    for (size_t k = 0; k < RBT_VALUES; k++) { /* a number that compilers know */
        if (k >= width)
            break;
        const int is_work = k >= RBT_WORK_NORMAL;
        const size_t row = is_work ? RBTI_OUT_A + (k - RBT_WORK_NORMAL) : k;
        const int known = k <= RBT_OMEGA_Z || (is_work && outcomes == RBTI_MOST_OUTCOMES);
        const int held = known && rbti_has(table, (int)k);
        for (size_t r = 0; r < count; r++)
            states[width * r + k] = held ? values[row * m + r] : 0.0;
    }
}
