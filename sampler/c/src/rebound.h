/* -- rebounds -------------------------------------------------------------------------------------

   rbt_rebound: velocities in the lab frame, m/s, angular velocities, rad/s, and works, J/kg, of particles
   that meet a wall. Each row takes three steps:

   rbti_begin_row      the impact on the wall, or on the first facet of a rough wall (frame.h, rough.h)
   rbti_draw_one       its state, row by row, or rbti_draw_rows for a block of rows (sample.h)
   rbti_finish_row     back to the lab frame; on a rough wall further facets until the particle leaves */

/* Hit of a row: its impact on the wall, or on the first facet of a rough wall. The cascade of facets is
   stored apart, so that it takes no cache where walls are smooth. */
typedef struct rbti_wall_hit {
    rbti_impact impact;
    rbti_cascade *facets;
    int is_rough;
    double spin[3]; /* before the impact, a Omega / V, in the frame of the impact */
    double inertia; /* about it, over m a^2; 0: not known */
} rbti_wall_hit;

/* Whether an impact is drawn from the spin law; otherwise it is drawn from the law of first impacts. On a
   rough wall the spin law is taken whenever the table has one, because all facets of a hit meet the same
   grain, and a particle arrives at the second facet with a spin. */
RBTI_INLINE RBT_DEVICE int rbti_takes_spin_law(const rbt_table *table, const rbt_impacts *impacts,
                                               const rbti_wall_hit *wall_hit)
{
    return !impacts->fresh || impacts->omega || impacts->grain ||
           (wall_hit->is_rough && table->spin.n_shapes > 0);
}

/* Whether the caller asks for works, but the table has none. */
RBTI_INLINE RBT_DEVICE int rbti_lacks_works(const rbt_table *table, int asks_for_works)
{
    return asks_for_works &&
           !(rbti_has_variable(table, RBT_WORK_NORMAL) && rbti_has_variable(table, RBT_WORK_SHEAR));
}

/* Find the impact of row k. Returns RBT_OK or an error. */
RBTI_INLINE RBT_DEVICE int rbti_begin_row(const rbt_impacts *impacts, size_t k, uint64_t seed,
                                          rbti_wall_hit *wall_hit)
{
    const double *velocity = impacts->velocity + 3 * k, *normal = impacts->normal + 3 * k;
    const double *wall = rbti_vector_of(impacts->wall_velocity, k);
    const double *omega = rbti_vector_of(impacts->omega, k);
    const double half_size = impacts->half_size[k];
    const double roughness = impacts->roughness ? impacts->roughness[k] : 0.0;
    const uint64_t index = impacts->index[k];
    const uint32_t hit = impacts->hit[k];
    int code;
    wall_hit->is_rough = !rbti_finite(roughness) || roughness != 0.0;
    if (wall_hit->is_rough) {
        code = rbti_begin_cascade(velocity, normal, half_size, wall, roughness, impacts->isotropic,
                                  wall_hit->facets);
        if (code == RBT_OK)
            code = rbti_meet_facet(wall_hit->facets, seed, index, hit, &wall_hit->impact);
    } else {
        code = rbti_find_impact(velocity, normal, half_size, wall, seed, index, hit,
                                &wall_hit->impact);
    }
    wall_hit->spin[0] = wall_hit->spin[1] = wall_hit->spin[2] = 0.0;
    wall_hit->inertia = impacts->inertia ? impacts->inertia[k] : 0.0;
    return code == RBT_OK && omega ? rbti_to_spin(&wall_hit->impact, omega, wall_hit->spin) : code;
}

/* Write the n numbers of row k to an array of results, unless that is NULL. Without an error they are
   `numbers`. A particle that does not approach the wall keeps the numbers that it arrived with, which are
   0 if `before` is NULL. Other errors give NaN. */
RBTI_INLINE RBT_DEVICE void rbti_write_result(int code, size_t n, size_t k, const double *numbers,
                                              const double *before, double *results)
{
    for (size_t c = 0; c < n && results; c++)
        results[n * k + c] = code >= RBT_OK                     ? numbers[c]
                             : code != RBT_ERR_NOT_APPROACHING ? rbti_nan()
                             : before                          ? before[n * k + c]
                                                               : 0.0;
}

/* Write the results of row k from its drawn state, the inertia after it, and the code of the draw. On a
   rough wall the particle may meet further facets first. Returns the code of the row. */
RBTI_INLINE RBT_DEVICE int rbti_finish_row(const rbt_table *table, const rbt_impacts *impacts,
                                           size_t k, uint64_t seed, rbti_wall_hit *wall_hit,
                                           const double *state, double inertia, int code,
                                           const rbt_rebounds *out)
{
    double velocity[3], omega[3], works[2] = {0.0, 0.0}, *work = out->works ? works : NULL;
    if (code >= RBT_OK) {
        rbti_to_lab_frame(&wall_hit->impact, state, velocity, omega);
        rbti_add_works(&wall_hit->impact, state, work);
    }
    if (code >= RBT_OK && wall_hit->is_rough) {
        rbti_cascade *c = wall_hit->facets;
        memcpy(c->velocity, velocity, sizeof velocity);
        memcpy(c->angular_velocity, omega, sizeof omega);
        c->inertia = inertia;
        if (!rbti_has_left(c)) {
            const rbti_grains grains = {rbti_vector_of(impacts->grain, k), seed, impacts->fresh};
            const int further = rbti_meet_further_facets(table, c, seed, &grains,
                                                         impacts->index[k], impacts->hit[k], work);
            code = further == RBT_ERR_NOT_APPROACHING ? RBT_ERR_CASCADE_NOT_ENDED
                   : further < RBT_OK                 ? further
                                                      : code | further;
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

/* Rebound row k by itself. Returns its code. */
RBTI_INLINE RBT_DEVICE int rbti_rebound_row(const rbt_table *table, const rbt_impacts *impacts,
                                            size_t k, uint64_t seed, const rbt_rebounds *out)
{
    const rbti_grains grains = {rbti_vector_of(impacts->grain, k), seed, impacts->fresh};
    rbti_cascade facets;
    rbti_wall_hit wall_hit;
    wall_hit.facets = &facets;
    double state[RBT_VALUES], inertia_after = 0.0;
    int code = rbti_begin_row(impacts, k, seed, &wall_hit);
    const int spins = rbti_takes_spin_law(table, impacts, &wall_hit);
    if (code == RBT_OK)
        code = rbti_draw_one(table, wall_hit.impact.alpha1, wall_hit.impact.speed,
                             spins ? wall_hit.spin : NULL, wall_hit.inertia, seed, &grains,
                             impacts->index[k], impacts->hit[k], spins,
                             out->works ? RBT_VALUES : 6, state, &inertia_after);
    return rbti_finish_row(table, impacts, k, seed, &wall_hit, state, inertia_after, code, out);
}

#ifdef RBTI_BLOCKS

/* Rebound `count` rows from `first` on, at most a block, and fill their codes. Rows of one block may be
   drawn from two laws, since some walls may be rough; each law then draws the whole block. */
static void rbti_rebound_rows(const rbt_table *table, const rbt_impacts *impacts, size_t first,
                              size_t count, uint64_t seed, const rbt_rebounds *out, int *codes)
{
    rbti_wall_hit hits[RBTI_BLOCK];
    rbti_cascade facets[RBTI_BLOCK];
    double alpha1[RBTI_BLOCK], speed[RBTI_BLOCK], spin[3 * RBTI_BLOCK], inertia[RBTI_BLOCK];
    double states[2][RBT_VALUES * RBTI_BLOCK] RBTI_ALIGNED; /* by law: of first impacts, of spins */
    double inertia_after[2][RBTI_BLOCK];
    int impact_codes[RBTI_BLOCK], draw_codes[2][RBTI_BLOCK], is_needed[2] = {0, 0};
    const int variables = out->works ? RBT_VALUES : 6;
    rbt_conditions conditions;
    memset(&conditions, 0, sizeof conditions);
    conditions.alpha1 = alpha1;
    conditions.speed = speed;
    conditions.inertia = inertia;
    conditions.grain = rbti_vector_of(impacts->grain, first);
    conditions.index = impacts->index + first;
    conditions.hit = impacts->hit + first;
    conditions.fresh = impacts->fresh;
    for (size_t r = 0; r < count; r++) {
        hits[r].facets = &facets[r];
        impact_codes[r] = rbti_begin_row(impacts, first + r, seed, &hits[r]);
        /* a row with an error gets a condition that can be drawn, and its draw is not used */
        alpha1[r] = impact_codes[r] == RBT_OK ? hits[r].impact.alpha1 : RBTI_HALF_PI;
        speed[r] = impact_codes[r] == RBT_OK ? hits[r].impact.speed : 1.0;
        memcpy(spin + 3 * r, hits[r].spin, sizeof hits[r].spin);
        inertia[r] = hits[r].inertia;
        is_needed[rbti_takes_spin_law(table, impacts, &hits[r])] = 1;
    }
    for (int law = 0; law < 2; law++) {
        conditions.spin = law ? spin : NULL;
        conditions.inertia_after = inertia_after[law];
        if (is_needed[law])
            rbti_draw_rows(table, &conditions, 0, count, seed, variables, states[law],
                           draw_codes[law]);
    }
    for (size_t r = 0; r < count; r++) {
        const int law = rbti_takes_spin_law(table, impacts, &hits[r]);
        codes[r] = rbti_finish_row(table, impacts, first + r, seed, &hits[r],
                                   states[law] + (size_t)variables * r, inertia_after[law][r],
                                   impact_codes[r] < RBT_OK ? impact_codes[r] : draw_codes[law][r],
                                   out);
    }
}

#endif

/* Count a row in the results of a call. */
RBTI_INLINE RBT_DEVICE void rbti_count_row(int code, size_t row, rbt_rebounds *out)
{
    if (code < RBT_OK && out->bad++ == 0)
        out->first_bad = row;
    for (int k = 0; k < 8 && code > RBT_OK; k++)
        out->flagged[k] += (size_t)(code >> k & 1);
    if (out->codes)
        out->codes[row] = code;
}

RBT_API RBT_DEVICE int rbt_rebound(const rbt_table *table, size_t n, const rbt_impacts *impacts,
                                   uint64_t seed, rbt_rebounds *rebounds)
{
    if (!table || !impacts || !rebounds || !impacts->velocity || !impacts->normal ||
        !impacts->half_size || !impacts->index || !impacts->hit)
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
        if (count >= RBTI_FEWEST_IN_BLOCK)
            rbti_rebound_rows(table, impacts, first, count, seed, rebounds, codes);
        else
#endif
            for (size_t r = 0; r < count; r++)
                codes[r] = rbti_rebound_row(table, impacts, first + r, seed, rebounds);
        for (size_t r = 0; r < count; r++)
            rbti_count_row(codes[r], first + r, rebounds);
        rbti_count_codes(&tally, codes, count);
    }
    return rbti_result(&tally);
}
