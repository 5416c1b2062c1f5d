#ifndef RBT_DEVICE_ONLY

/* Count the flags of a row. */
RBTI_INLINE void rbti_count_flags(int flags, size_t row, rbt_report *report)
{
    if ((flags & RBT_CLAMPED) && report->clamped++ == 0)
        report->clamped_row = row;
    if ((flags & RBT_EXTRAPOLATED) && report->extrapolated++ == 0)
        report->extrapolated_row = row;
}

/* As rbti_conditions; spin and given grains may be NULL. */
RBTI_INLINE size_t rbti_spin_conditions(const rbt_table *table, const rbt_conditions *given,
                                        size_t first, size_t most, rbti_spin_draws *d, int *code,
                                        rbt_report *report)
{
    const double *alpha1 = given->alpha1, *speed = given->speed, *grain = given->grain;
    const rbt_spin_law *law = &table->spin;
    const size_t m = RBTI_BLOCK;
    const double none[3] = {0.0, 0.0, 0.0};
    int outside = law->n_shapes == 0 || grain;
    RBTI_EACH_DRAW(r) {
        const size_t k = first + (r < most ? r : most - 1);
        const double a = alpha1[k], v = speed[k], *spin = given->spin ? given->spin + 3 * k : none;
        const double x = spin[0], y = spin[1], z = spin[2];
        const double effective = v * rbti_spin_factor(x, y, z);
        const int off_alpha = (a < law->alpha_low) + (a > law->alpha_high);
        const int off_speed = (effective < law->speed_low) + (effective > law->speed_high);
        const double square = x * x + y * y + z * z;
        const int off_spin = (square < law->least_spin) + (square > law->most_spin);
        outside |= off_alpha | off_speed | off_spin;
        outside |= 1 - rbti_finite(a) * rbti_finite(effective);
        d->alpha1[r] = a;
        d->speed[r] = v;
        d->spin[r] = x;
        d->spin[m + r] = y;
        d->spin[2 * m + r] = z;
    }
    for (size_t r = 0; r < most && outside; r++) {
        int status = rbti_spin_status(table, d->alpha1[r], d->speed[r], d->spin[r],
                                      d->spin[m + r], d->spin[2 * m + r]);
        if (status >= RBT_OK && grain && !rbti_grain_holds(law, grain + 3 * (first + r)))
            status = RBT_ERR_GRAIN_NOT_KNOWN;
        if (status < RBT_OK) {
            report->row = first + r;
            *code = status;
            for (size_t k = r; k < m; k++) {
                d->alpha1[k] = law->alpha_first;
                d->speed[k] = law->speed_first;
                d->spin[k] = d->spin[m + k] = d->spin[2 * m + k] = 0.0;
            }
            return r;
        }
        rbti_count_flags(status & RBT_CLAMPED, first + r, report);
    }
    return most;
}

#endif

/* One draw from the law of first impacts: of the nodes, or of the spin law where it stands for that. */
RBTI_INLINE RBT_DEVICE int rbti_first_draw(const rbt_table *table, double alpha1, double speed,
                                           uint64_t seed, uint64_t key, uint64_t index,
                                           uint32_t hit, int variables, double *state)
{
    const rbti_grains any = {NULL, key, 1};
    if (!table->spin.for_first)
        return rbti_draw(table, alpha1, speed, seed, index, hit, variables, state);
    return rbti_spin_draw(table, alpha1, speed, NULL, seed, &any, index, hit, variables, state);
}

/* One draw from the law of the spin or grain, or from that of first impacts. */
RBTI_INLINE RBT_DEVICE int rbti_any_draw(const rbt_table *table, double alpha1, double speed,
                                         const double *spin, const double *grain, uint64_t seed,
                                         uint64_t index, uint32_t hit, int variables, double *state)
{
    rbti_grains grains = rbti_own_grains(table, seed);
    grains.given = grain;
    if (spin || grain)
        return rbti_spin_draw(table, alpha1, speed, spin, seed, &grains, index, hit, variables,
                              state);
    return rbti_first_draw(table, alpha1, speed, seed, seed, index, hit, variables, state);
}

RBT_API RBT_DEVICE int rbt_draw(const rbt_table *table, double alpha1, double speed,
                                const double *spin, uint64_t seed, uint64_t index, uint32_t hit,
                                double state[6])
{
    return rbti_any_draw(table, alpha1, speed, spin, NULL, seed, index, hit, 6, state);
}

RBT_API RBT_DEVICE int rbt_draw_all(const rbt_table *table, double alpha1, double speed,
                                    const double *spin, const double *grain, uint64_t seed,
                                    uint64_t index, uint32_t hit, double values[RBT_VALUES])
{
    return rbti_any_draw(table, alpha1, speed, spin, grain, seed, index, hit, RBT_VALUES, values);
}

#ifndef RBT_DEVICE_ONLY

/* Copy the conditions of a block; how many rows come before the first error, whose code is given.
   Where no row is left a condition of the table stands, so that all of the block can be drawn. */
RBTI_INLINE size_t rbti_conditions(const rbt_table *table, const double *alpha1,
                                   const double *speed, size_t first, size_t most, rbti_draws *d,
                                   int *code, rbt_report *report)
{
    const rbt_axis alpha = table->alpha, velocity = table->speed;
    const size_t m = RBTI_BLOCK;
    int outside = 0;
    RBTI_EACH_DRAW(r) {
        const size_t k = first + (r < most ? r : most - 1);
        const double a = alpha1[k], v = speed[k];
        const int off_alpha = (a < alpha.low) + (a > alpha.high);
        const int off_speed = (v < velocity.low) + (v > velocity.high);
        outside |= off_alpha | off_speed | (1 - rbti_finite(a) * rbti_finite(v));
        d->alpha1[r] = a;
        d->speed[r] = v;
    }
    for (size_t r = 0; r < most && outside; r++) {
        const int status = rbti_status(table, d->alpha1[r], d->speed[r]);
        if (status < RBT_OK) {
            report->row = first + r;
            *code = status;
            for (size_t k = r; k < m; k++) {
                d->alpha1[k] = alpha.first;
                d->speed[k] = velocity.first;
            }
            return r;
        }
        rbti_count_flags(status & RBT_CLAMPED, first + r, report);
    }
    return most;
}

/* What a batch returns: the code of its error, else the flags of its rows. */
RBTI_INLINE int rbti_batch_code(int code, const rbt_report *found)
{
    return code < RBT_OK ? code
                         : (found->clamped > 0) * RBT_CLAMPED |
                               (found->extrapolated > 0) * RBT_EXTRAPOLATED;
}

/* Rows that a batch writes: the first six variables, or columns of the table, in one precision. */
typedef struct rbti_output {
    double *states;
    float *singles;
    const int8_t *columns; /* NULL: the first six variables, in double precision */
    int width, variables;  /* numbers of a row; 6 or all variables that are drawn */
} rbti_output;

RBTI_INLINE rbti_output rbti_output_of(const rbt_table *table, double *states, float *singles)
{
    rbti_output out = {states, singles, table->columns, table->n_columns, 6};
    int plain = states && table->n_columns == 6;
    for (int k = 0; k < table->n_columns; k++) {
        plain = plain && table->columns[k] == k;
        out.variables = table->columns[k] >= 6 ? RBT_VALUES : out.variables;
    }
    if (plain)
        out.columns = NULL;
    return out;
}

/* Copy the columns of `count` drawn rows to their place from row `first` on. */
RBTI_INLINE void rbti_put(const rbti_output *out, size_t first, size_t count, int given,
                          const double *values)
{
    for (size_t r = 0; r < count; r++) {
        const double *row = values + (size_t)given * r;
        const size_t at = (first + r) * (size_t)out->width;
        for (int k = 0; k < out->width && out->states; k++)
            out->states[at + (size_t)k] = row[out->columns[k]];
        for (int k = 0; k < out->width && out->singles; k++)
            out->singles[at + (size_t)k] = (float)row[out->columns[k]];
    }
}

/* Draws from the spin law of a block of rows: how many come before the first error. */
RBTI_INLINE size_t rbti_sample_spins(const rbt_table *table, const rbt_conditions *given,
                                     size_t first, size_t most, uint64_t seed, int variables,
                                     double *states, int *code, rbt_report *report)
{
    const int any = given->fresh_grains || table->spin.fresh_grains || !given->spin;
    const rbti_grains grains = {given->grain ? given->grain + 3 * first : NULL, seed, any};
    rbti_spin_draws draws RBTI_ALIGNED;
    const size_t count = rbti_spin_conditions(table, given, first, most, &draws, code, report);
    for (size_t r = 0; r < count && table->spheres; r++)
        rbti_sphere_state(table, draws.alpha1[r], draws.speed[r],
                          given->spin ? given->spin + 3 * (first + r) : NULL, variables,
                          states + (size_t)variables * r);
    if (count > 0 && !table->spheres)
        rbti_spin_block(RBTI_BLOCK, table, seed, &grains, given->index + first,
                        given->hit + first, count, variables, &draws, states);
    return count;
}

/* The same from the law of particles that arrive without spin. */
RBTI_INLINE size_t rbti_sample_nodes(const rbt_table *table, const rbt_conditions *given,
                                     size_t first, size_t most, uint64_t seed, int variables,
                                     double *states, int *code, rbt_report *report)
{
    rbti_draws draws RBTI_ALIGNED;
    const size_t count = rbti_conditions(table, given->alpha1, given->speed, first, most, &draws,
                                         code, report);
    for (size_t r = 0; r < count && table->spheres; r++)
        rbti_sphere_state(table, draws.alpha1[r], draws.speed[r], NULL, variables,
                          states + (size_t)variables * r);
    if (count > 0 && !table->spheres)
        rbti_draw_block(RBTI_BLOCK, table, seed, given->index + first, given->hit + first, count,
                        variables, &draws, states);
    return count;
}

/* All batches of draws. */
RBTI_CLONES
static int rbti_sample_rows(const rbt_table *table, size_t n, const rbt_conditions *given,
                            uint64_t seed, const rbti_output *out, rbt_report *report)
{
    rbt_report found = {n, n, 0, 0, n};
    int code = RBT_OK;
    const int spins = given->spin || given->grain || table->spin.for_first;
    for (size_t first = 0; first < n && code == RBT_OK; first += RBTI_BLOCK) {
        const size_t most = n - first < RBTI_BLOCK ? n - first : RBTI_BLOCK;
        double values[RBT_VALUES * RBTI_BLOCK] RBTI_ALIGNED;
        double *states = out->columns ? values : out->states + 6 * first;
        size_t count;
        if (spins)
            count = rbti_sample_spins(table, given, first, most, seed, out->variables, states,
                                      &code, &found);
        else
            count = rbti_sample_nodes(table, given, first, most, seed, out->variables, states,
                                      &code, &found);
        if (out->columns)
            rbti_put(out, first, count, out->variables, values);
        for (size_t k = first; k < first + count; k++)
            rbti_count_flags(rbti_extrapolates(table, given->speed[k]), k, &found);
    }
    if (report)
        *report = found;
    return rbti_batch_code(code, &found);
}

RBT_API int rbt_draw_batch(const rbt_table *table, size_t n, const double *alpha1,
                           const double *speed, const double *spin, uint64_t seed,
                           const uint64_t *index, const uint32_t *hit, double *states,
                           rbt_report *report)
{
    const rbt_conditions given = {alpha1, speed, spin, NULL, index, hit, 0};
    const rbti_output out = {states, NULL, NULL, 6, 6};
    return rbti_sample_rows(table, n, &given, seed, &out, report);
}

RBT_API int rbt_sample_batch(const rbt_table *table, size_t n, const rbt_conditions *conditions,
                             uint64_t seed, double *states, float *singles, rbt_report *report)
{
    const rbti_output out = rbti_output_of(table, states, singles);
    return rbti_sample_rows(table, n, conditions, seed, &out, report);
}

#endif
