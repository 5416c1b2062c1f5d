/* -- direct simulation ----------------------------------------------------------------------------

   States over V and a/V, in the frame of the impact, by a simulation of the rebound. The law
   (rbt_direct_law) takes conditions within its range, so angles, speeds and spins beyond it are brought to
   the nearest that it simulates, with a flag. A call simulates up to RBT_DIRECT_ROWS rows at once, since
   the law follows particles of one shape side by side. Arithmetic of particles that have left the wall goes
   on beside the others and may overflow or be invalid, so the program's traps of floating-point exceptions
   are off meanwhile. */

#ifdef RBTI_DIRECT

#ifndef RBT_DIRECT_ROWS
#define RBT_DIRECT_ROWS 512
#endif
#define RBTI_MOST_ROWS RBT_DIRECT_ROWS

/* Bring a condition into the range of the law. Without a spin the numbers of `spin` are 0. The law itself
   takes the nearest inertia that the grain can have. Returns the flags. */
static int rbti_enter_range(const rbt_direct_law *law, const double grain[3], double *alpha1,
                            double *speed, double spin[3], double inertia)
{
    const int32_t shape = rbti_row_of_shape(&law->population, grain[0]);
    const double *g = law->population.shape_inertia + 2 * shape;
    const double b = grain[1] * grain[1], square = rbti_square(spin[0], spin[1], spin[2]);
    const double least = g[1] * b * (1.0 + grain[2] * grain[2]), most = g[0] * (1.0 + b);
    const double size = sqrt(square), shorter = size > law->most_spin ? law->most_spin / size : 1.0;
    const double flattest = 2.0 * size * shorter / law->most_turned;
    const double known = inertia > 0.0 ? rbti_bounded(inertia, least, most) : 0.5 * (least + most);
    const double effective = *speed * sqrt(1.0 + known * square);
    const int turns_too_often = rbti_is_outside(*alpha1, flattest, RBTI_HALF_PI);
    const int angle = rbti_is_outside(*alpha1, law->alpha1[0], law->alpha1[1]) | turns_too_often;
    const int beyond = rbti_is_outside(size, 0.0, law->most_spin) |
                       rbti_inertia_is_beyond(inertia, square, least, most);
    const int flags =
        angle * RBT_ANGLE | rbti_is_outside(*speed, law->speed[0], law->speed[1]) * RBT_SPEED |
        beyond * RBT_SPIN |
        rbti_is_outside(effective, law->valid_speed[0], law->valid_speed[1]) * RBT_EXTRAPOLATED;
    *alpha1 = rbti_bounded(*alpha1, law->alpha1[0], law->alpha1[1]);
    *alpha1 = *alpha1 > flattest ? *alpha1 : flattest;
    *speed = rbti_bounded(*speed, law->speed[0], law->speed[1]);
    for (int k = 0; k < 3; k++)
        spin[k] *= shorter;
    return flags;
}

/* Fill the grains of at most RBTI_BLOCK rows, 3 numbers a row. */
static void rbti_fill_direct_grains(const rbt_population *population, const rbti_grains *grains,
                                    const uint64_t *index, const uint32_t *hit, size_t count,
                                    double *out)
{
    int32_t shapes[RBTI_BLOCK] RBTI_ALIGNED;
    double ratios[2 * RBTI_BLOCK] RBTI_ALIGNED;
    if (grains->prescribed)
        rbti_take_grains(RBTI_BLOCK, population, grains->prescribed, count, shapes, ratios);
    else
        rbti_fill_grains(RBTI_BLOCK, population, grains->seed, grains->fresh, index, hit, count,
                         shapes, ratios);
    for (size_t r = 0; r < count; r++) {
        out[3 * r] = (double)population->shape_codes[shapes[r]];
        out[3 * r + 1] = ratios[r];
        out[3 * r + 2] = ratios[RBTI_BLOCK + r];
    }
}

/* Simulate `count` rows from `first` on, at most RBT_DIRECT_ROWS. Rows without a spin are of any grain of
   the population, as those of a table's law of first impacts. Writes RBT_DIRECT_VALUES numbers a row, NaN
   after an error, unless `values` is NULL, and the codes. */
RBTI_NOT_INLINED void rbti_simulate_rows(const rbt_table *table, const rbt_conditions *conditions,
                                         size_t first, size_t count, uint64_t seed,
                                         uint64_t grain_seed, double *values, int *codes)
{
    const rbt_direct_law *law = table->direct;
    const int spins = conditions->spin || conditions->grain;
    double alpha1[RBT_DIRECT_ROWS], speed[RBT_DIRECT_ROWS], inertia[RBT_DIRECT_ROWS];
    double spin[3 * RBT_DIRECT_ROWS], grain[3 * RBT_DIRECT_ROWS];
    int32_t ends[RBT_DIRECT_ROWS];
    fenv_t traps;
    for (size_t r = 0; r < count; r += RBTI_BLOCK) {
        const size_t k = first + r;
        const rbti_grains grains = {rbti_vector_of(conditions->grain, k), grain_seed,
                                    !spins || conditions->fresh};
        rbti_fill_direct_grains(&table->population, &grains, conditions->index + k,
                                conditions->hit + k, count - r < RBTI_BLOCK ? count - r : RBTI_BLOCK,
                                grain + 3 * r);
    }
    for (size_t r = 0; r < count; r++) {
        const size_t k = first + r;
        for (size_t c = 0; c < 3; c++)
            spin[3 * r + c] = conditions->spin ? conditions->spin[3 * k + c] : 0.0;
        alpha1[r] = conditions->alpha1[k];
        speed[r] = conditions->speed[k];
        inertia[r] = conditions->inertia && conditions->spin ? conditions->inertia[k] : 0.0;
        codes[r] = spins ? rbti_spin_error(table, alpha1[r], speed[r], spin + 3 * r, inertia[r],
                                           rbti_vector_of(conditions->grain, k))
                         : rbti_error(alpha1[r], speed[r]);
        if (codes[r] < RBT_OK) { /* a condition that can be simulated, whose result is not used */
            alpha1[r] = law->alpha1[1];
            speed[r] = 1.0;
            spin[3 * r] = spin[3 * r + 1] = spin[3 * r + 2] = inertia[r] = 0.0;
        } else {
            codes[r] = rbti_enter_range(law, grain + 3 * r, alpha1 + r, speed + r, spin + 3 * r,
                                        inertia[r]);
        }
    }
    if (!values)
        return;
    feholdexcept(&traps);
    law->simulate(law->reals, law->integers, (int64_t)count, alpha1, speed, spin, inertia, grain,
                  conditions->index + first, conditions->hit + first, seed, values, ends);
    fesetenv(&traps);
    for (size_t r = 0; r < count; r++) {
        double *row = values + RBT_DIRECT_VALUES * r;
        codes[r] = codes[r] >= RBT_OK && ends[r] < RBT_OK ? ends[r] : codes[r];
        for (int c = 0; c < RBT_DIRECT_VALUES && codes[r] < RBT_OK; c++)
            row[c] = rbti_nan();
        if (!spins && codes[r] >= RBT_OK) /* a fresh grain, which nobody keeps */
            row[RBT_VALUES] = 0.0;
    }
}

/* Simulate one row, as rbti_draw_one draws it. */
RBTI_NOT_INLINED int rbti_simulate_one(const rbt_table *table, double alpha1, double speed,
                                       const double *spin, double inertia, uint64_t seed,
                                       const rbti_grains *grains, uint64_t index, uint32_t hit,
                                       int spins, int variables, double *state,
                                       double *inertia_after)
{
    const double zeros[3] = {0.0, 0.0, 0.0};
    double values[RBT_DIRECT_VALUES];
    rbt_conditions conditions;
    int code;
    memset(&conditions, 0, sizeof conditions);
    conditions.alpha1 = &alpha1;
    conditions.speed = &speed;
    conditions.spin = spins ? (spin ? spin : zeros) : NULL;
    conditions.inertia = &inertia;
    conditions.grain = spins ? grains->prescribed : NULL;
    conditions.index = &index;
    conditions.hit = &hit;
    conditions.fresh = grains->fresh;
    rbti_simulate_rows(table, &conditions, 0, 1, seed, grains->seed, state ? values : NULL, &code);
    if (state)
        memcpy(state, values, (size_t)variables * sizeof *state);
    *inertia_after = state ? values[RBT_VALUES] : 0.0;
    return code;
}

RBT_API int rbt_use_direct(rbt_table *table, const rbt_direct_law *law)
{
    if (!table || !law)
        return RBT_ERR_MISSING;
    if (law->version != RBT_DIRECT_VERSION)
        return RBT_ERR_DIRECT_VERSION;
    if (strcmp(table->pair, law->pair) != 0)
        return RBT_ERR_DIRECT_PAIR;
    for (int32_t k = 0; k < table->population.n_shapes; k++) {
        const double code = (double)table->population.shape_codes[k];
        if (rbti_row_of_shape(&law->population, code) == law->population.n_shapes)
            return RBT_ERR_DIRECT_PAIR;
    }
    table->direct = law;
    table->population = law->population;
    table->variable_bits = (1u << RBT_VALUES) - 1u;
    memcpy(table->valid_speed, law->valid_speed, sizeof table->valid_speed);
    table->alpha.low = table->spin.alpha_first = law->alpha1[0];
    table->alpha.high = table->spin.alpha_last = law->alpha1[1];
    table->speed.low = law->speed[0];
    table->speed.high = law->speed[1];
    table->spin.least_spin = 0.0;
    table->spin.most_spin = law->most_spin * law->most_spin;
    return RBT_OK;
}

#else
#define RBTI_MOST_ROWS RBTI_BLOCK
#endif
