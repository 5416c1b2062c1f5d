/* -- draws ----------------------------------------------------------------------------------------

   Rows of a call share nothing but the table and the seed. One row is drawn by itself; on a processor
   more are drawn in blocks, whose codes tell which rows have an error and get NaN. */

/* Result of the rows of a call: the first error, and all flags. */
typedef struct rbti_tally {
    int error, flags;
} rbti_tally;

/* Count the codes of a block, most of which are 0. */
RBTI_INLINE RBT_DEVICE void rbti_count_codes(rbti_tally *tally, const int *codes, size_t count)
{
    int all = 0;
    for (size_t r = 0; r < count; r++)
        all |= codes[r]; /* negative if one is */
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

/* One draw from the spin law, if `spins`, else from that of first impacts: its code, and the first
   variables of its state, and the inertia after, unless `state` is NULL. A spin that is NULL is 0. */
RBTI_INLINE RBT_DEVICE int rbti_draw_one(const rbt_table *table, double alpha1, double speed,
                                         const double *spin, double inertia, uint64_t seed,
                                         const rbti_grains *grains, uint64_t index, uint32_t hit,
                                         int spins, int variables, double *state, double *after)
{
    const double none[3] = {0.0, 0.0, 0.0}, *of = spin ? spin : none;
    const int error = spins ? rbti_spin_error(table, alpha1, speed, of, inertia, grains->given)
                            : rbti_error(alpha1, speed);
    if (error < RBT_OK)
        return error;
    if (spins && !table->spheres)
        return rbti_draw_spin(table, alpha1, speed, of, inertia, seed, grains, index, hit,
                              variables, state, after);
    *after = spins ? RBTI_SPHERE_INERTIA : 0.0;
    if (state && table->spheres)
        rbti_sphere_state(table, alpha1, speed, spin, variables, state);
    else if (state)
        rbti_draw_node(table, alpha1, speed, seed, index, hit, variables, state);
    return spins ? rbti_sphere_flags(table, alpha1, speed, of, inertia)
                 : rbti_flags(table, alpha1, speed);
}

/* Draw row k, with NaN where it has an error: its code. */
RBTI_INLINE RBT_DEVICE int rbti_draw_row(const rbt_table *table, const rbt_conditions *given,
                                         size_t k, uint64_t seed, int variables, double *state)
{
    const rbti_grains grains = {rbti_vector_of(given->grain, k), seed, given->fresh};
    const int spins = given->spin || given->grain;
    double after;
    const int code = rbti_draw_one(table, given->alpha1[k], given->speed[k],
                                   rbti_vector_of(given->spin, k),
                                   given->inertia ? given->inertia[k] : 0.0, seed, &grains,
                                   given->index[k], given->hit[k], spins, variables, state, &after);
    for (int c = 0; c < variables && state && code < RBT_OK; c++)
        state[c] = rbti_nan();
    if (given->inertia_after && state)
        given->inertia_after[k] = code < RBT_OK ? rbti_nan() : after;
    return code;
}

/* Fewest rows that are cheaper in a block, which always takes the time of RBTI_BLOCK. */
#define RBTI_FEWEST 16

/* Draw `count` rows from `first` on, at most a block. */
RBTI_INLINE RBT_DEVICE void rbti_draw_rows(const rbt_table *table, const rbt_conditions *given,
                                           size_t first, size_t count, uint64_t seed, int variables,
                                           double *states, int *codes)
{
    const size_t width = (size_t)variables;
#ifdef RBTI_BLOCKS
    const int spins = given->spin || given->grain;
    double *after = states ? given->inertia_after : NULL;
    if (count >= RBTI_FEWEST && !table->spheres && (!spins || table->spin.n_shapes > 0)) {
        if (spins)
            rbti_draw_spins(table, given, first, count, seed, variables, states, codes);
        else
            rbti_draw_nodes(table, given, first, count, seed, variables, states, codes);
        for (size_t r = 0; r < count && after && !spins; r++)
            after[first + r] = 0.0;
        for (size_t r = 0; r < count && states; r++) {
            for (size_t c = 0; c < width && codes[r] < RBT_OK; c++)
                states[width * r + c] = rbti_nan();
            if (after && codes[r] < RBT_OK)
                after[first + r] = rbti_nan();
        }
        return;
    }
#endif
    for (size_t r = 0; r < count; r++)
        codes[r] = rbti_draw_row(table, given, first + r, seed, variables,
                                 states ? states + width * r : NULL);
}

/* Copy the table's columns of a drawn row. */
RBTI_INLINE RBT_DEVICE void rbti_copy_variables(const rbt_table *table, const double *values,
                                                double *state)
{
    for (int c = 0; c < table->n_columns; c++)
        state[c] = values[table->columns[c]];
}

RBT_API RBT_DEVICE int rbt_sample(const rbt_table *table, size_t n, const rbt_conditions *given,
                                  uint64_t seed, double *states, int *codes)
{
    if (!table || !given || !given->alpha1 || !given->speed || !given->index || !given->hit)
        return RBT_ERR_MISSING;
    const int plain = table->plain || !states;
    if (n == 1 && plain) {
        const int code = rbti_draw_row(table, given, 0, seed, 6, states);
        if (codes)
            *codes = code;
        return code;
    }
    rbti_tally tally = {RBT_OK, RBT_OK};
    for (size_t first = 0, count = 0; first < n; first += count) {
        double values[RBT_VALUES * RBTI_BLOCK] RBTI_ALIGNED;
        int block[RBTI_BLOCK];
        count = n - first < RBTI_BLOCK ? n - first : RBTI_BLOCK;
        const int whole = codes && count == RBTI_BLOCK; /* a block writes all of its codes */
        int *row_codes = whole ? codes + first : block;
        if (plain)
            rbti_draw_rows(table, given, first, count, seed, 6, states ? states + 6 * first : NULL,
                           row_codes);
        else
            rbti_draw_rows(table, given, first, count, seed, RBT_VALUES, values, row_codes);
        for (size_t r = 0; r < count && !plain; r++)
            rbti_copy_variables(table, values + RBT_VALUES * r,
                                states + (size_t)table->n_columns * (first + r));
        if (codes && !whole)
            memcpy(codes + first, block, count * sizeof *block);
        rbti_count_codes(&tally, row_codes, count);
    }
    return rbti_result(&tally);
}
