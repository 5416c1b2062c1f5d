}

/* Outcomes of a table with laws of contact are less those of a sphere, over 1 - c/a: add these. The
   sphere has the mean moment of inertia of the grain. */
RBTI_APART RBT_DEVICE void rbti_add_spheres(size_t m, const rbt_table *table, rbti_spin_draws *d)
{
    const rbt_spin_law *law = &table->spin;
    RBTI_EACH_DRAW(r) {
        const double *root = d->inputs + r, *ratios = d->inputs + RBTI_RATIO * m + r;
        const double b = ratios[0], c = b * ratios[m], radius = sqrt((1.0 + b * b + c * c) / 3.0);
        const double flat = rbti_bounded(1.0 - c, RBTI_LEAST_FLATNESS, 1.0);
        const double x = d->spin[r], y = d->spin[m + r], z = d->spin[2 * m + r];
        const double square = x * x + y * y + z * z, most = law->most_spin;
        /* a spin beyond the law is the largest, of less energy */
        const double held = square > most ? sqrt(most / square) : 1.0, size = radius * held;
        const double energy = 1.0 + held * held * (d->factor[r] * d->factor[r] - 1.0);
        const double spin[3] = {d->turn[r] * size * x, d->turn[r] * size * y, size * z};
        const double fast = d->speed[r] * rbti_spin_factor(x, y, z);
        const double speed = rbti_bounded(fast, law->speed_first, law->speed_last) /
                             rbti_spin_factor(held * x, held * y, held * z);
        double of[RBT_VALUES];
        rbti_sphere(table, root[0] * root[0], speed, spin, of);
        const double left = energy - (of[0] * of[0] + of[1] * of[1] + of[2] * of[2]);
        const double scale = 1.0 / sqrt(rbti_bounded(left, RBTI_LEAST_REST * energy, left));
        const double per_spin = radius * sqrt(energy);
        float *found = d->outcomes + r;
        const double raised = rbti_bounded(flat * (double)found[m], -RBTI_MOST_POWER, RBTI_MOST_POWER);
        found[0] = (float)(scale * of[0] + flat * (double)found[0]);
        found[m] = (float)(scale * of[1] * exp(raised));
        found[2 * m] = (float)(scale * of[2] + flat * (double)found[2 * m]);
        for (size_t k = 3; k < 6; k++)
            found[k * m] = (float)(of[k] / per_spin + flat * (double)found[k * m]);
    }
}

/* Outcomes to states of `count` draws, the first six variables or all. With E, the square of `factor`,
   the most energy that the grain can have before, E / (1 + |p|^2) is left for the rotation after: an
   angular velocity with more is shortened. The works are the share b of what both leave; of them the
   normal work has the share a^6. */
RBTI_INLINE RBT_DEVICE void rbti_to_spin_states(size_t m, size_t count, size_t outcomes,
                                                int variables, const rbt_table *table,
                                                const rbti_spin_draws *d, double *states)
{
    double values[RBTI_MOST_OUTCOMES * RBTI_BLOCK] RBTI_ALIGNED;
    RBTI_EACH_DRAW(r) {
        const float *found = d->outcomes + r;
        const double p = (double)found[0], q = (double)found[m];
        const double s = (double)found[2 * m], factor = d->factor[r], turn = d->turn[r];
        const double x = (double)found[3 * m], y = (double)found[4 * m];
        const double z = (double)found[5 * m], whole = 1.0 + (p * p + q * q + s * s);
        const double scale = factor / sqrt(whole);
        const double turns = d->smallest[r] * (x * x + y * y + z * z) * whole;
        const double turning = factor / sqrt(turns > 1.0 ? turns : 1.0);
        values[r] = p * scale;
        values[m + r] = q * scale;
        values[2 * m + r] = turn * s * scale;
        values[3 * m + r] = turn * turning * x;
        values[4 * m + r] = turn * turning * y;
        values[5 * m + r] = turning * z;
        if (outcomes == RBTI_MOST_OUTCOMES) {
            const double a = (double)found[6 * m], b = (double)found[7 * m], cube = a * a * a;
            const double left = scale * scale * (turns > 1.0 ? 0.0 : 1.0 - turns);
            const double sum = left * (b > 1.0 ? 1.0 : b < 0.0 ? 0.0 : b);
            const double normal = sum * (cube * cube > 1.0 ? 1.0 : cube * cube);
            values[6 * m + r] = normal;
            values[7 * m + r] = sum - normal;
        }
    }
    const size_t width = (size_t)variables;
    for (size_t k = 0; k < RBT_VALUES; k++) { /* a number that compilers know */
        if (k >= width)
            break;
        const int is_work = k >= RBT_WORK_NORMAL;
        const size_t row = is_work ? 6 + (k - RBT_WORK_NORMAL) : k;
        const int known = k <= RBT_OMEGA_Z || (is_work && outcomes == RBTI_MOST_OUTCOMES);
        const int held = known && rbti_has(table, (int)k);
        for (size_t r = 0; r < count; r++)
            states[width * r + k] = held ? values[row * m + r] : 0.0;
    }
}

/* Draws with conditions that may be drawn at. Word 8 belongs to no outcome. */
RBTI_INLINE RBT_DEVICE void rbti_spin_steps(size_t m, size_t outcomes, const rbt_table *table, uint64_t seed,
                                            const rbti_grains *grains, const uint64_t *index,
                                            const uint32_t *hit, size_t count, int variables,
                                            rbti_spin_draws *d, double *states)
{
    const rbt_spin_law *law = &table->spin;
    for (uint32_t block = 0; block < (outcomes > 6 ? 3u : 2u); block++)
        rbti_fill_words(m, block, seed, index, hit, count, d->words + 4 * block * m);
    if (grains->given)
        rbti_take_grains(m, law, grains->given, count, d->shape, d->inputs + RBTI_RATIO * m);
    else
        rbti_fill_grains(m, law, grains->seed, grains->fresh, index, hit, count, d->shape,
                         d->inputs + RBTI_RATIO * m);
    rbti_fill_inputs(m, law, d);
    rbti_find_leaves(m, law, d);
    rbti_fill_features(m, law, d);
    rbti_choose_expert(m, outcomes, law, d);
    for (size_t row = 0; row < outcomes; row++)
        rbti_fill_normals(m, table->normals, d->words + (row < 6 ? 2 + row : 3 + row) * m,
                          d->scores + row * m);
    if (outcomes == RBTI_OUTCOMES) /* as most laws have */
        rbti_fill_scores(m, RBTI_OUTCOMES, law, d);
    else
        rbti_fill_scores(m, RBTI_MOST_OUTCOMES, law, d);
    rbti_find_knots(m, (int32_t)outcomes, law, d);
    rbti_fill_outcomes(m, (int32_t)outcomes, law, d);
    if (table->n_laws > 0)
        rbti_add_spheres(m, table, d);
    rbti_to_spin_states(m, count, outcomes, variables, table, d, states);
}

/* One draw of the first six or of all variables. */
RBTI_CLONES RBT_DEVICE void rbti_draw_spin(const rbt_table *table, double alpha1, double speed,
                                           const double spin[3], uint64_t seed,
                                           const rbti_grains *grains, uint64_t index, uint32_t hit,
                                           int variables, double *state)
{
    rbti_spin_draws draws;
    draws.alpha1[0] = alpha1;
    draws.speed[0] = speed;
    memcpy(draws.spin, spin, 3 * sizeof *spin);
    if (table->spin.n_outcomes == RBTI_OUTCOMES) /* a number that the compiler knows */
        rbti_spin_steps(1, RBTI_OUTCOMES, table, seed, grains, &index, &hit, 1, variables, &draws,
                        state);
    else
        rbti_spin_steps(1, RBTI_MOST_OUTCOMES, table, seed, grains, &index, &hit, 1, variables,
                        &draws, state);
}

#ifdef RBTI_BLOCKS

/* As rbti_take_conditions; spin and given grains may be NULL. */
RBTI_INLINE void rbti_take_spin_conditions(const rbt_table *table, const rbt_conditions *given,
                                           size_t first, size_t count, rbti_spin_draws *d,
                                           int *codes)
{
    const size_t m = RBTI_BLOCK;
    const double none[3] = {0.0, 0.0, 0.0};
    double *x = d->spin, *y = x + m, *z = y + m;
    int bad = given->grain != NULL;
    RBTI_EACH_DRAW(r) {
        const size_t k = first + (r < count ? r : count - 1);
        const double *spin = given->spin ? given->spin + 3 * k : none;
        d->alpha1[r] = given->alpha1[k];
        d->speed[r] = given->speed[k];
        x[r] = spin[0];
        y[r] = spin[1];
        z[r] = spin[2];
    }
    RBTI_EACH_DRAW(r) {
        codes[r] = rbti_spin_flags(table, d->alpha1[r], d->speed[r], x[r], y[r], z[r]);
        bad |= rbti_spin_is_bad(d->alpha1[r], d->speed[r], x[r], y[r], z[r]);
    }
    for (size_t r = 0; r < m && bad; r++) {
        const size_t k = first + (r < count ? r : count - 1);
        const int error = rbti_spin_error(table, d->alpha1[r], d->speed[r], x[r], y[r], z[r],
                                          rbti_vector_of(given->grain, k));
        if (error < RBT_OK) {
            codes[r] = error;
            d->alpha1[r] = table->alpha.first;
            d->speed[r] = table->speed.first;
            x[r] = y[r] = z[r] = 0.0;
        }
    }
}

/* Draws of a block of rows, and their codes; without `states` the codes alone. */
RBTI_BATCH_CLONES
static void rbti_draw_spins(const rbt_table *table, const rbt_conditions *given, size_t first,
                            size_t count, uint64_t seed, int variables, double *states, int *codes)
{
    const rbti_grains grains = {rbti_vector_of(given->grain, first), seed, given->fresh};
    rbti_spin_draws draws RBTI_ALIGNED;
    rbti_take_spin_conditions(table, given, first, count, &draws, codes);
    if (states)
        rbti_spin_steps(RBTI_BLOCK, (size_t)table->spin.n_outcomes, table, seed, &grains,
                        given->index + first, given->hit + first, count, variables, &draws, states);
}

#endif

#if defined(__GNUC__) && !defined(__clang__) && !defined(RBTI_GPU)
#pragma GCC pop_options
#endif
