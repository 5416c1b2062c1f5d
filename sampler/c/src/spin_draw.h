/* -- spin draw, all steps --------------------------------------------------------------------------

   The steps of spin.h in their order, for one draw and for a block of rows. */

/* All steps, for conditions that can be drawn. If `states` is NULL only the flags are written. `after`
   gets inertias, or is NULL. */
RBTI_INLINE RBT_DEVICE void rbti_spin_steps(size_t m, size_t outcomes, const rbt_table *table,
                                            uint64_t seed, const rbti_grains *grains,
                                            const uint64_t *index, const uint32_t *hit,
                                            size_t count, int variables, rbti_spin_draws *d,
                                            int *flags, double *states, double *after)
{
    const rbt_spin_law *law = &table->spin;
    double *ratios = d->inputs + RBTI_IN_B_A * m;
    for (uint32_t block = 0; block < 3; block++)
        rbti_fill_words(m, block, seed, index, hit, count, d->words + 4 * block * m);
    if (grains->prescribed)
        rbti_take_grains(m, &table->population, grains->prescribed, count, d->shape, ratios);
    else
        rbti_fill_grains(m, &table->population, grains->seed, grains->fresh, index, hit, count,
                         d->shape, ratios);
    rbti_fill_inputs(m, table, d, flags);
    if (!states)
        return;
    rbti_find_leaves(m, law, d);
    rbti_fill_features(m, law, d);
    rbti_choose_expert(m, outcomes, law, d);
    for (size_t row = 0; row < outcomes; row++)
        rbti_fill_normals(m, table->normals, d->words + rbti_word_of_normal(row) * m,
                          d->scores + row * m);
    rbti_fill_scores(m, outcomes, law, d);
    rbti_find_knots(m, (int32_t)outcomes, law, d);
    rbti_fill_outcomes(m, (int32_t)outcomes, law, d);
    rbti_to_spin_states(m, count, outcomes, variables, table, d, states, after);
}

/* One draw of the first six or of all variables, and of the inertia. If `state` is NULL nothing is
   written. Returns the flags. */
RBTI_CLONES RBT_DEVICE int rbti_draw_spin(const rbt_table *table, double alpha1, double speed,
                                          const double spin[3], double inertia, uint64_t seed,
                                          const rbti_grains *grains, uint64_t index, uint32_t hit,
                                          int variables, double *state, double *after)
{
    rbti_spin_draws draws;
    int flags;
    draws.alpha1[0] = alpha1;
    draws.speed[0] = speed;
    draws.inertia[0] = inertia;
    memcpy(draws.spin, spin, 3 * sizeof *spin);
    rbti_spin_steps(1, (size_t)table->spin.n_outcomes, table, seed, grains, &index, &hit, 1, variables,
                    &draws, &flags, state, after);
    return flags;
}

#ifdef RBTI_BLOCKS

/* Take the conditions of a block of rows, as rbti_take_conditions does; spin, inertia and grain may be
   NULL. If a row may have an error, fills `errors` and returns 1. */
RBTI_INLINE int rbti_take_spin_conditions(const rbt_table *table, const rbt_conditions *conditions,
                                          size_t first, size_t count, rbti_spin_draws *d,
                                          int *errors)
{
    const size_t m = RBTI_BLOCK;
    const double zeros[3] = {0.0, 0.0, 0.0};
    double *x = d->spin, *y = x + m, *z = y + m;
    int bad = conditions->grain != NULL;
    RBTI_EACH_DRAW(r) {
        const size_t k = first + (r < count ? r : count - 1);
        const double *spin = conditions->spin ? conditions->spin + 3 * k : zeros;
        d->alpha1[r] = conditions->alpha1[k];
        d->speed[r] = conditions->speed[k];
        d->inertia[r] = conditions->inertia ? conditions->inertia[k] : 0.0;
        x[r] = spin[0];
        y[r] = spin[1];
        z[r] = spin[2];
    }
    RBTI_EACH_DRAW(r) {
        bad |= rbti_cannot_be_drawn(d->alpha1[r], d->speed[r]);
        bad |= 1 - rbti_has_energy(d->speed[r], x[r], y[r], z[r], d->inertia[r]);
    }
    for (size_t r = 0; r < m && bad; r++) {
        const size_t k = first + (r < count ? r : count - 1);
        const double spin[3] = {x[r], y[r], z[r]};
        errors[r] = rbti_spin_error(table, d->alpha1[r], d->speed[r], spin, d->inertia[r],
                                    rbti_vector_of(conditions->grain, k));
        if (errors[r] < RBT_OK) {
            d->alpha1[r] = table->alpha.first;
            d->speed[r] = table->speed.first;
            x[r] = y[r] = z[r] = d->inertia[r] = 0.0;
        }
    }
    return bad;
}

/* Draw a block of rows and fill their codes. If `states` is NULL only the codes are written. */
RBTI_INLINE void rbti_draw_spins_body(const rbt_table *table, const rbt_conditions *conditions,
                                      size_t first, size_t count, uint64_t seed,
                                      uint64_t grain_seed, int variables, double *states,
                                      int *codes)
{
    const rbti_grains grains = {rbti_vector_of(conditions->grain, first), grain_seed,
                                conditions->fresh};
    rbti_spin_draws draws RBTI_ALIGNED;
    int errors[RBTI_BLOCK] RBTI_ALIGNED, flags[RBTI_BLOCK] RBTI_ALIGNED;
    const int bad = rbti_take_spin_conditions(table, conditions, first, count, &draws, errors);
    rbti_spin_steps(RBTI_BLOCK, (size_t)table->spin.n_outcomes, table, seed, &grains,
                    conditions->index + first, conditions->hit + first, count, variables, &draws, flags,
                    states, conditions->inertia_after ? conditions->inertia_after + first : NULL);
    for (size_t r = 0; r < count; r++)
        codes[r] = bad && errors[r] < RBT_OK ? errors[r] : flags[r];
}

RBTI_BLOCK_VERSION(rbti_draw_spins, , "avx2",
                   (const rbt_table *table, const rbt_conditions *conditions, size_t first,
                    size_t count, uint64_t seed, uint64_t grain_seed, int variables, double *states,
                    int *codes),
                   (table, conditions, first, count, seed, grain_seed, variables, states, codes))

#endif

#if defined(__GNUC__) && !defined(__clang__) && !defined(RBTI_GPU)
#pragma GCC pop_options
#endif
