/* -- rebounds -------------------------------------------------------------------------------------

   A row meets the wall, or the first facet of a rough one, in the frame of the impact; its state is
   drawn, by itself or in a block; it leaves, after further bounces where it needs them. */

/* Impact of a row on a wall, or on the first facet of a rough one. The cascade of facets lies apart, to
   take no cache where walls are smooth. */
typedef struct rbti_hit {
    rbti_impact met;
    rbti_cascade *facets;
    int rough;
    double spin[3], inertia;
} rbti_hit;

/* Whether an impact is drawn from the spin law, and not from the law of first impacts. On a rough wall it
   is drawn from the spin law if the table has one, since all facets of a hit meet the same grain. */
RBTI_INLINE RBT_DEVICE int rbti_takes_spin_law(const rbt_table *table, const rbt_impacts *impacts,
                                               const rbti_hit *of)
{
    return !impacts->fresh || impacts->omega || impacts->grain ||
           (of->rough && table->spin.n_shapes > 0);
}

/* Whether works are wanted of a table that has none. */
RBTI_INLINE RBT_DEVICE int rbti_lacks_works(const rbt_table *table, int wanted)
{
    return wanted &&
           !(rbti_has_variable(table, RBT_WORK_NORMAL) && rbti_has_variable(table, RBT_WORK_SHEAR));
}

/* Impact of row k: RBT_OK or an error. */
RBTI_INLINE RBT_DEVICE int rbti_begin_row(const rbt_impacts *impacts, size_t k, uint64_t seed,
                                          rbti_hit *of)
{
    const double *velocity = impacts->velocity + 3 * k, *normal = impacts->normal + 3 * k;
    const double *wall = rbti_vector_of(impacts->wall_velocity, k);
    const double *omega = rbti_vector_of(impacts->omega, k);
    const double half_size = impacts->half_size[k];
    const double roughness = impacts->roughness ? impacts->roughness[k] : 0.0;
    const uint64_t index = impacts->index[k];
    const uint32_t hit = impacts->hit[k];
    int code;
    of->rough = !rbti_finite(roughness) || roughness != 0.0;
    if (of->rough) {
        code = rbti_begin_cascade(velocity, normal, half_size, wall, roughness, impacts->isotropic,
                                  of->facets);
        if (code == RBT_OK)
            code = rbti_meet_facet(of->facets, seed, index, hit, &of->met);
    } else {
        code = rbti_find_impact(velocity, normal, half_size, wall, seed, index, hit, &of->met);
    }
    of->spin[0] = of->spin[1] = of->spin[2] = 0.0;
    of->inertia = impacts->inertia ? impacts->inertia[k] : 0.0;
    return code == RBT_OK && omega ? rbti_to_spin(&of->met, omega, of->spin) : code;
}

/* Write n numbers of row k where they are wanted: what they are without an error, what they were where
   the particle does not approach the wall, or NaN. Those that are NULL were 0. */
RBTI_INLINE RBT_DEVICE void rbti_write_result(int code, size_t n, size_t k, const double *numbers,
                                              const double *before, double *to)
{
    for (size_t c = 0; c < n && to; c++)
        to[n * k + c] = code >= RBT_OK                     ? numbers[c]
                        : code != RBT_ERR_NOT_APPROACHING ? rbti_nan()
                        : before                          ? before[n * k + c]
                                                          : 0.0;
}

/* Results of row k from its drawn state, the inertia after and the code of that. */
RBTI_INLINE RBT_DEVICE int rbti_finish_row(const rbt_table *table, const rbt_impacts *impacts,
                                           size_t k, uint64_t seed, rbti_hit *of,
                                           const double *state, double inertia, int code,
                                           const rbt_rebounds *out)
{
    double velocity[3], omega[3], works[2] = {0.0, 0.0}, *work = out->works ? works : NULL;
    if (code >= RBT_OK) {
        rbti_to_lab_frame(&of->met, state, velocity, omega);
        rbti_add_works(&of->met, state, work);
    }
    if (code >= RBT_OK && of->rough) {
        rbti_cascade *c = of->facets;
        memcpy(c->moving, velocity, sizeof velocity);
        memcpy(c->turning, omega, sizeof omega);
        c->inertia = inertia;
        if (!rbti_has_left(c)) {
            const rbti_grains grains = {rbti_vector_of(impacts->grain, k), seed, impacts->fresh};
            const int on = rbti_bounce_on(table, c, seed, &grains, impacts->index[k],
                                          impacts->hit[k], work);
            code = on == RBT_ERR_NOT_APPROACHING ? RBT_ERR_CASCADE_NOT_ENDED
                   : on < RBT_OK                 ? on
                                                 : code | on;
        }
        rbti_store_rebound(c, velocity, omega);
        inertia = c->inertia;
    }
    rbti_write_result(code, 3, k, velocity, impacts->velocity, out->velocity);
    rbti_write_result(code, 3, k, omega, impacts->omega, out->omega);
    rbti_write_result(code, 1, k, &inertia, impacts->inertia, out->inertia);
    for (size_t c = 0; c < 2 && out->works; c++)
        out->works[2 * k + c] = code < RBT_OK ? rbti_nan() : works[c];
    return code;
}

/* Rebound row k by itself: its code. */
RBTI_INLINE RBT_DEVICE int rbti_rebound_row(const rbt_table *table, const rbt_impacts *impacts,
                                            size_t k, uint64_t seed, const rbt_rebounds *out)
{
    const rbti_grains grains = {rbti_vector_of(impacts->grain, k), seed, impacts->fresh};
    rbti_cascade facets;
    rbti_hit of;
    of.facets = &facets;
    double state[RBT_VALUES], after = 0.0;
    int code = rbti_begin_row(impacts, k, seed, &of);
    const int spins = rbti_takes_spin_law(table, impacts, &of);
    if (code == RBT_OK)
        code = rbti_draw_one(table, of.met.alpha1, of.met.speed, spins ? of.spin : NULL, of.inertia,
                             seed, &grains, impacts->index[k], impacts->hit[k], spins,
                             out->works ? RBT_VALUES : 6, state, &after);
    return rbti_finish_row(table, impacts, k, seed, &of, state, after, code, out);
}

#ifdef RBTI_BLOCKS

/* Rebound a block of rows from one on: their codes. */
static void rbti_rebound_rows(const rbt_table *table, const rbt_impacts *impacts, size_t first,
                              size_t count, uint64_t seed, const rbt_rebounds *out, int *codes)
{
    rbti_hit hits[RBTI_BLOCK];
    rbti_cascade facets[RBTI_BLOCK];
    double alpha1[RBTI_BLOCK], speed[RBTI_BLOCK], spin[3 * RBTI_BLOCK], inertia[RBTI_BLOCK];
    double states[2][RBT_VALUES * RBTI_BLOCK] RBTI_ALIGNED; /* of first impacts, of the spin law */
    double after[2][RBTI_BLOCK];
    int met[RBTI_BLOCK], drawn[2][RBTI_BLOCK], wanted[2] = {0, 0};
    const int variables = out->works ? RBT_VALUES : 6;
    rbt_conditions given;
    memset(&given, 0, sizeof given);
    given.alpha1 = alpha1;
    given.speed = speed;
    given.inertia = inertia;
    given.grain = rbti_vector_of(impacts->grain, first);
    given.index = impacts->index + first;
    given.hit = impacts->hit + first;
    given.fresh = impacts->fresh;
    for (size_t r = 0; r < count; r++) {
        hits[r].facets = &facets[r];
        met[r] = rbti_begin_row(impacts, first + r, seed, &hits[r]);
        alpha1[r] = met[r] == RBT_OK ? hits[r].met.alpha1 : RBTI_HALF_PI;
        speed[r] = met[r] == RBT_OK ? hits[r].met.speed : 1.0;
        memcpy(spin + 3 * r, hits[r].spin, sizeof hits[r].spin);
        inertia[r] = hits[r].inertia;
        wanted[rbti_takes_spin_law(table, impacts, &hits[r])] = 1;
    }
    for (int law = 0; law < 2; law++) {
        given.spin = law ? spin : NULL;
        given.inertia_after = after[law];
        if (wanted[law])
            rbti_draw_rows(table, &given, 0, count, seed, variables, states[law], drawn[law]);
    }
    for (size_t r = 0; r < count; r++) {
        const int law = rbti_takes_spin_law(table, impacts, &hits[r]);
        codes[r] = rbti_finish_row(table, impacts, first + r, seed, &hits[r],
                                   states[law] + (size_t)variables * r, after[law][r],
                                   met[r] < RBT_OK ? met[r] : drawn[law][r], out);
    }
}

#endif

/* Count a row in the results of a call. */
RBTI_INLINE RBT_DEVICE void rbti_count_row(int code, size_t row, rbt_rebounds *out)
{
    if (code < RBT_OK && out->bad++ == 0)
        out->first_bad = row;
    for (int k = 0; k < 4 && code > RBT_OK; k++)
        out->flagged[k] += (size_t)(code >> k & 1);
    if (out->codes)
        out->codes[row] = code;
}

RBT_API RBT_DEVICE int rbt_rebound(const rbt_table *table, size_t n, const rbt_impacts *impacts,
                                   uint64_t seed, rbt_rebounds *rebounds)
{
    const rbt_impacts *of = impacts;
    if (!table || !of || !rebounds || !of->velocity || !of->normal || !of->half_size ||
        !of->index || !of->hit)
        return RBT_ERR_MISSING;
    if (rbti_lacks_works(table, rebounds->works != NULL))
        return RBT_ERR_NO_WORKS;
    rbti_tally tally = {RBT_OK, RBT_OK};
    rebounds->bad = 0;
    rebounds->first_bad = n;
    memset(rebounds->flagged, 0, sizeof rebounds->flagged);
    for (size_t first = 0, count = 0; first < n; first += count) {
        int codes[RBTI_BLOCK];
        count = n - first < RBTI_BLOCK ? n - first : RBTI_BLOCK;
#ifdef RBTI_BLOCKS
        if (count >= RBTI_FEWEST)
            rbti_rebound_rows(table, of, first, count, seed, rebounds, codes);
        else
#endif
            for (size_t r = 0; r < count; r++)
                codes[r] = rbti_rebound_row(table, of, first + r, seed, rebounds);
        for (size_t r = 0; r < count; r++)
            rbti_count_row(codes[r], first + r, rebounds);
        rbti_count_codes(&tally, codes, count);
    }
    return rbti_result(&tally);
}
