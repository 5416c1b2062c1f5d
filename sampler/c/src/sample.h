/* -- draws ----------------------------------------------------------------------------------------

   rbt_sample: states over V and a/V, in the frame of the impact, from impact angles, rad, and speeds,
   m/s. Rows of a call share nothing but the table and the seed. A single row is drawn by itself. On a
   processor several rows are drawn in blocks of RBTI_BLOCK; the codes of a block say which of its rows
   have an error and get NaN. */

/* What a call returns: the first error of its rows, and all their flags. */
typedef struct rbti_tally {
    int error, flags;
} rbti_tally;

/* Add the codes of a block, most of which are 0, to a tally. */
RBTI_INLINE RBT_DEVICE void rbti_count_codes(rbti_tally *tally, const int *codes, size_t count)
{
    int all = 0;
    for (size_t r = 0; r < count; r++)
        all |= codes[r]; /* negative if one of them is */
    if (all >= RBT_OK) {
        tally->flags |= all;
        return;
    }
    for (size_t r = 0; r < count; r++) {
        if (codes[r] >= RBT_OK)
            tally->flags |= codes[r];
        else if (tally->error == RBT_OK)
            tally->error = codes[r];
    }
}

RBTI_INLINE RBT_DEVICE int rbti_result(const rbti_tally *tally)
{
    return tally->error < RBT_OK ? tally->error : tally->flags;
}

/* Which law gives the state of a row. */
enum { RBTI_NODES, RBTI_SPIN_LAW, RBTI_SPHERE, RBTI_SIMULATION };

/* The law of a table for rows with a spin or a grain (`spins`), or without. */
RBTI_INLINE RBT_DEVICE int rbti_choose_law(const rbt_table *table, int spins)
{
#ifdef RBTI_DIRECT
    if (table->direct)
        return RBTI_SIMULATION;
#endif
    return table->spheres ? RBTI_SPHERE : spins ? RBTI_SPIN_LAW : RBTI_NODES;
}

/* One draw, from the spin law if `spins`, else from the law of first impacts. A NULL spin counts as
   zeros. Writes the first `variables` variables of the state, and the inertia after the rebound, unless
   `state` is NULL. Returns the code. */
RBTI_INLINE RBT_DEVICE int rbti_draw_one(const rbt_table *table, double alpha1, double speed,
                                         const double *spin, double inertia, uint64_t seed,
                                         const rbti_grains *grains, uint64_t index, uint32_t hit,
                                         int spins, int variables, double *state,
                                         double *inertia_after)
{
    const double zeros[3] = {0.0, 0.0, 0.0}, *spin_or_zeros = spin ? spin : zeros;
    const int law = rbti_choose_law(table, spins);
#ifdef RBTI_DIRECT
    if (law == RBTI_SIMULATION)
        return rbti_simulate_one(table, alpha1, speed, spin, inertia, seed, grains, index, hit, spins,
                                 variables, state, inertia_after);
#endif
    const int error =
        spins ? rbti_spin_error(table, alpha1, speed, spin_or_zeros, inertia, grains->prescribed)
              : rbti_error(alpha1, speed);
    if (error < RBT_OK)
        return error;
    if (law == RBTI_SPIN_LAW)
        return rbti_draw_spin(table, alpha1, speed, spin_or_zeros, inertia, seed, grains, index,
                              hit, variables, state, inertia_after);
    *inertia_after = spins ? RBTI_SPHERE_INERTIA : 0.0;
    if (state && law == RBTI_SPHERE)
        rbti_sphere_state(table, alpha1, speed, spin, variables, state);
    else if (state)
        rbti_draw_node(table, alpha1, speed, seed, index, hit, variables, state);
    return spins ? rbti_sphere_flags(table, alpha1, speed, spin_or_zeros, inertia)
                 : rbti_flags(table, alpha1, speed);
}

/* Draw row k by itself. A row with an error gets NaN. Returns its code. */
RBTI_INLINE RBT_DEVICE int rbti_draw_row(const rbt_table *table, const rbt_conditions *conditions,
                                         size_t k, uint64_t seed, uint64_t grain_seed, int variables,
                                         double *state)
{
    const rbti_grains grains = {rbti_vector_of(conditions->grain, k), grain_seed, conditions->fresh};
    const int spins = conditions->spin || conditions->grain;
    double inertia_after;
    const int code = rbti_draw_one(table, conditions->alpha1[k], conditions->speed[k],
                                   rbti_vector_of(conditions->spin, k),
                                   conditions->inertia ? conditions->inertia[k] : 0.0, seed, &grains,
                                   conditions->index[k], conditions->hit[k], spins, variables,
                                   state, &inertia_after);
    for (int c = 0; c < variables && state && code < RBT_OK; c++)
        state[c] = rbti_nan();
    if (conditions->inertia_after && state)
        conditions->inertia_after[k] = code < RBT_OK ? rbti_nan() : inertia_after;
    return code;
}

/* Fewest rows that are drawn faster in a block than one by one: a block takes the time of RBTI_BLOCK
   rows, however few it has. */
#define RBTI_FEWEST_IN_BLOCK 16

/* Draw `count` rows from `first` on, at most a block, and fill their codes. Grains are those of
   `grain_seed`: on a rough wall each bounce of a hit has a seed of its own. */
RBTI_INLINE RBT_DEVICE void rbti_draw_rows(const rbt_table *table, const rbt_conditions *conditions,
                                           size_t first, size_t count, uint64_t seed,
                                           uint64_t grain_seed, int variables, double *states,
                                           int *codes)
{
    const size_t width = (size_t)variables;
#ifdef RBTI_BLOCKS
    const int spins = conditions->spin || conditions->grain;
    const int law = rbti_choose_law(table, spins), known = !spins || table->population.n_shapes > 0;
    double *inertia_after = states ? conditions->inertia_after : NULL;
    if (count >= RBTI_FEWEST_IN_BLOCK && law != RBTI_SPHERE && known && RBTI_DRAWS_BLOCKS()) {
        if (spins)
            rbti_draw_spins(table, conditions, first, count, seed, grain_seed, variables, states,
                            codes);
        else
            rbti_draw_nodes(table, conditions, first, count, seed, variables, states, codes);
        for (size_t r = 0; r < count && inertia_after && !spins; r++)
            inertia_after[first + r] = 0.0;
        for (size_t r = 0; r < count && states; r++) {
            for (size_t c = 0; c < width && codes[r] < RBT_OK; c++)
                states[width * r + c] = rbti_nan();
            if (inertia_after && codes[r] < RBT_OK)
                inertia_after[first + r] = rbti_nan();
        }
        return;
    }
#endif
    for (size_t r = 0; r < count; r++)
        codes[r] = rbti_draw_row(table, conditions, first + r, seed, grain_seed, variables,
                                 states ? states + width * r : NULL);
}

/* Copy the table's columns of a drawn row. */
RBTI_INLINE RBT_DEVICE void rbti_copy_variables(const rbt_table *table, const double *values,
                                                double *state)
{
    for (int c = 0; c < table->n_columns; c++)
        state[c] = values[table->columns[c]];
}

#ifdef RBTI_DIRECT

/* Simulate n rows, and write the table's columns, inertias and codes, each unless it is NULL. */
static int rbti_sample_direct(const rbt_table *table, size_t n, const rbt_conditions *conditions,
                              uint64_t seed, double *states, int *codes)
{
    rbti_tally tally = {RBT_OK, RBT_OK};
    for (size_t first = 0, count = 0; first < n; first += count) {
        double values[RBT_DIRECT_VALUES * RBT_DIRECT_ROWS];
        int row_codes[RBT_DIRECT_ROWS];
        count = n - first < RBT_DIRECT_ROWS ? n - first : RBT_DIRECT_ROWS;
        rbti_simulate_rows(table, conditions, first, count, seed, seed, states ? values : NULL,
                           row_codes);
        for (size_t r = 0; r < count && states; r++) {
            const double *row = values + RBT_DIRECT_VALUES * r;
            rbti_copy_variables(table, row, states + (size_t)table->n_columns * (first + r));
            if (conditions->inertia_after)
                conditions->inertia_after[first + r] = row[RBT_VALUES];
        }
        if (codes)
            memcpy(codes + first, row_codes, count * sizeof *row_codes);
        rbti_count_codes(&tally, row_codes, count);
    }
    return rbti_result(&tally);
}

#endif

RBT_API RBT_DEVICE int rbt_sample(const rbt_table *table, size_t n, const rbt_conditions *conditions,
                                  uint64_t seed, double *states, int *codes)
{
    if (!table || !conditions || !conditions->alpha1 || !conditions->speed ||
        !conditions->index || !conditions->hit)
        return RBT_ERR_MISSING;
#ifdef RBTI_DIRECT
    if (table->direct)
        return rbti_sample_direct(table, n, conditions, seed, states, codes);
#endif
    /* columns are u ... omega_z, as of most tables: draws write them in place */
    const int plain = table->plain || !states;
    if (n == 1 && plain) {
        const int code = rbti_draw_row(table, conditions, 0, seed, seed, 6, states);
        if (codes)
            *codes = code;
        return code;
    }
    rbti_tally tally = {RBT_OK, RBT_OK};
    for (size_t first = 0, count = 0; first < n; first += count) {
        double values[RBT_VALUES * RBTI_BLOCK] RBTI_ALIGNED;
        int block_codes[RBTI_BLOCK];
        count = n - first < RBTI_BLOCK ? n - first : RBTI_BLOCK;
        /* a block fills RBTI_BLOCK codes, so only a full one writes where the caller reads them */
        const int is_full = codes && count == RBTI_BLOCK;
        int *row_codes = is_full ? codes + first : block_codes;
        if (plain)
            rbti_draw_rows(table, conditions, first, count, seed, seed, 6,
                           states ? states + 6 * first : NULL, row_codes);
        else
            rbti_draw_rows(table, conditions, first, count, seed, seed, RBT_VALUES, values,
                           row_codes);
        for (size_t r = 0; r < count && !plain; r++)
            rbti_copy_variables(table, values + RBT_VALUES * r,
                                states + (size_t)table->n_columns * (first + r));
        if (codes && !is_full)
            memcpy(codes + first, block_codes, count * sizeof *block_codes);
        rbti_count_codes(&tally, row_codes, count);
    }
    return rbti_result(&tally);
}
