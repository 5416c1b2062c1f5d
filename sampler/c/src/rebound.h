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
           (wall_hit->is_rough && table->population.n_shapes > 0);
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

/* A particle after the bounces of a hit so far, relative to a rough wall or in the lab frame. */
typedef struct rbti_rebounded {
    double velocity[3], omega[3]; /* m/s, rad/s */
    double inertia;               /* about omega, over m a^2 */
    double works[2];              /* of all bounces, J/kg */
    int code;                     /* an error, or the flags of all bounces */
} rbti_rebounded;

/* End bounce number `bounce` of a hit, whose state was drawn with a code. Returns whether the particle
   meets a further facet; if it does not, `after` has its rebound. */
RBTI_INLINE RBT_DEVICE int rbti_end_bounce(const rbti_wall_hit *wall_hit, uint32_t bounce, int code,
                                           const double *state, double inertia, int has_works,
                                           rbti_rebounded *after)
{
    if (code < RBT_OK) {
        const int lost = bounce > 0 && code == RBT_ERR_NOT_APPROACHING;
        after->code = lost ? RBT_ERR_CASCADE_NOT_ENDED : code;
        return 0;
    }
    rbti_to_lab_frame(&wall_hit->impact, state, after->velocity, after->omega);
    rbti_add_works(&wall_hit->impact, state, has_works ? after->works : NULL);
    after->inertia = inertia;
    after->code |= code;
    if (!wall_hit->is_rough)
        return 0;
    rbti_cascade *c = wall_hit->facets;
    memcpy(c->velocity, after->velocity, sizeof c->velocity);
    if (!rbti_has_left(c)) {
        if (bounce + 1 < RBTI_MAX_BOUNCES)
            return 1;
        after->code = RBT_ERR_CASCADE_NOT_ENDED;
    }
    for (int k = 0; k < 3; k++)
        after->velocity[k] += c->wall[k];
    return 0;
}

/* Seed of a bounce of a hit: each has random numbers of its own. */
RBTI_INLINE RBT_DEVICE uint64_t rbti_seed_of_bounce(uint64_t seed, uint32_t bounce)
{
    return seed ^ ((uint64_t)bounce * RBTI_BOUNCE_KEY);
}

/* Find the impact of bounce number `bounce`, above 0, on the next facet. The particle arrives with the
   spin and the inertia that the bounce before has given it. Returns RBT_OK or an error. */
RBTI_INLINE RBT_DEVICE int rbti_begin_bounce(const rbti_rebounded *after, uint64_t bounce_seed,
                                             uint64_t index, uint32_t hit, rbti_wall_hit *wall_hit)
{
    const int code =
        rbti_meet_facet(wall_hit->facets, bounce_seed, index, hit, &wall_hit->impact);
    wall_hit->inertia = after->inertia;
    return code == RBT_OK ? rbti_to_spin(&wall_hit->impact, after->omega, wall_hit->spin) : code;
}

/* Write the results of row k. */
RBTI_INLINE RBT_DEVICE void rbti_write_row(const rbt_impacts *impacts, size_t k,
                                           const rbti_rebounded *after, const rbt_rebounds *out)
{
    rbti_write_result(after->code, 3, k, after->velocity, impacts->velocity, out->velocity);
    rbti_write_result(after->code, 3, k, after->omega, impacts->omega, out->omega);
    rbti_write_result(after->code, 1, k, &after->inertia, impacts->inertia, out->inertia);
    for (size_t c = 0; c < 2 && out->works; c++)
        out->works[2 * k + c] = after->code < RBT_OK ? rbti_nan() : after->works[c];
}

/* Rebound row k by itself. Returns its code. */
RBTI_INLINE RBT_DEVICE int rbti_rebound_row(const rbt_table *table, const rbt_impacts *impacts,
                                            size_t k, uint64_t seed, const rbt_rebounds *out)
{
    const rbti_grains grains = {rbti_vector_of(impacts->grain, k), seed, impacts->fresh};
    const uint64_t index = impacts->index[k];
    const uint32_t hit = impacts->hit[k];
    const int variables = out->works ? RBT_VALUES : 6;
    rbti_cascade facets;
    rbti_wall_hit wall_hit;
    rbti_rebounded after;
    wall_hit.facets = &facets;
    memset(&after, 0, sizeof after);
    int code = rbti_begin_row(impacts, k, seed, &wall_hit);
    int spins = rbti_takes_spin_law(table, impacts, &wall_hit);
    for (uint32_t bounce = 0;; spins = table->population.n_shapes > 0) {
        const uint64_t bounce_seed = rbti_seed_of_bounce(seed, bounce);
        double state[RBT_VALUES], inertia = 0.0;
        if (bounce > 0)
            code = rbti_begin_bounce(&after, bounce_seed, index, hit, &wall_hit);
        if (code == RBT_OK)
            code = rbti_draw_one(table, wall_hit.impact.alpha1, wall_hit.impact.speed,
                                 spins ? wall_hit.spin : NULL, wall_hit.inertia, bounce_seed, &grains,
                                 index, hit, spins, variables, state, &inertia);
        if (!rbti_end_bounce(&wall_hit, bounce++, code, state, inertia, out->works != NULL, &after))
            break;
    }
    rbti_write_row(impacts, k, &after, out);
    return after.code;
}

#ifdef RBTI_BLOCKS

/* Arrays for the rows of a block. */
typedef struct rbti_rebound_block {
    rbti_wall_hit *hits;
    rbti_cascade *facets;
    rbti_rebounded *after;
    size_t *rows; /* rows of the block that are under way, */
    int *goes_on; /* whether they meet a further facet, */
    int *codes;   /* the codes of their impacts, */
    double *alpha1, *speed, *spin, *inertia, *grain; /* their conditions and keys, */
    uint64_t *index;
    uint32_t *hit;
    double *states, *inertia_after; /* and what is drawn */
    int *draw_codes;
} rbti_rebound_block;

/* Draw the states of the first `count` conditions of a block, from the spin law or that of first
   impacts. Returns how many numbers of `states` a row has. */
static size_t rbti_draw_block(const rbt_table *table, const rbt_impacts *impacts,
                              const rbti_rebound_block *b, size_t count, int spins,
                              uint64_t bounce_seed, uint64_t seed, int variables)
{
    rbt_conditions conditions;
    memset(&conditions, 0, sizeof conditions);
    conditions.alpha1 = b->alpha1;
    conditions.speed = b->speed;
    conditions.spin = spins ? b->spin : NULL;
    conditions.inertia = b->inertia;
    conditions.grain = impacts->grain ? b->grain : NULL;
    conditions.index = b->index;
    conditions.hit = b->hit;
    conditions.inertia_after = b->inertia_after;
    conditions.fresh = impacts->fresh;
#ifdef RBTI_DIRECT
    if (table->direct) {
        rbti_simulate_rows(table, &conditions, 0, count, bounce_seed, seed, b->states,
                           b->draw_codes);
        for (size_t r = 0; r < count; r++)
            b->inertia_after[r] = b->states[RBT_DIRECT_VALUES * r + RBT_VALUES];
        return RBT_DIRECT_VALUES;
    }
#endif
    rbti_draw_rows(table, &conditions, 0, count, bounce_seed, seed, variables, b->states,
                   b->draw_codes);
    return (size_t)variables;
}

/* Begin bounce number `bounce` of the rows under way, and fill their conditions. A row with an error gets
   a condition that can be drawn, and its draw is not used. */
static void rbti_begin_block(const rbt_impacts *impacts, const rbti_rebound_block *b, size_t first,
                             size_t count, uint32_t bounce, uint64_t seed)
{
    const uint64_t bounce_seed = rbti_seed_of_bounce(seed, bounce);
    for (size_t r = 0; r < count; r++) {
        const size_t k = first + b->rows[r];
        rbti_wall_hit *wall_hit = b->hits + b->rows[r];
        b->index[r] = impacts->index[k];
        b->hit[r] = impacts->hit[k];
        if (impacts->grain)
            memcpy(b->grain + 3 * r, impacts->grain + 3 * k, 3 * sizeof *b->grain);
        b->codes[r] = bounce == 0 ? rbti_begin_row(impacts, k, seed, wall_hit)
                                  : rbti_begin_bounce(b->after + b->rows[r], bounce_seed,
                                                      b->index[r], b->hit[r], wall_hit);
        b->alpha1[r] = b->codes[r] == RBT_OK ? wall_hit->impact.alpha1 : RBTI_HALF_PI;
        b->speed[r] = b->codes[r] == RBT_OK ? wall_hit->impact.speed : 1.0;
        memcpy(b->spin + 3 * r, wall_hit->spin, sizeof wall_hit->spin);
        b->inertia[r] = wall_hit->inertia;
    }
}

/* Rebound `count` rows from `first` on, at most a block, and fill their codes. The rows under way make a
   bounce together, until all have left the wall. At the first bounce rows of one block may be drawn from
   two laws, since some walls may be rough; each law then draws all of them. */
static void rbti_rebound_rows(const rbt_table *table, const rbt_impacts *impacts, size_t first,
                              size_t count, uint64_t seed, const rbt_rebounds *out, int *codes,
                              const rbti_rebound_block *b)
{
    const int variables = out->works ? RBT_VALUES : 6;
    for (size_t r = 0; r < count; r++) {
        b->hits[r].facets = b->facets + r;
        b->rows[r] = r;
    }
    memset(b->after, 0, count * sizeof *b->after);
    size_t under_way = count;
    for (uint32_t bounce = 0; under_way > 0; bounce++) {
        const uint64_t bounce_seed = rbti_seed_of_bounce(seed, bounce);
        size_t going_on = 0;
        rbti_begin_block(impacts, b, first, under_way, bounce, seed);
        for (int spins = 0; spins < 2; spins++) {
            size_t stride = 0;
            for (size_t r = 0; r < under_way; r++) {
                const size_t row = b->rows[r];
                const int takes = bounce > 0 ? table->population.n_shapes > 0
                                             : rbti_takes_spin_law(table, impacts, b->hits + row);
                if (takes != spins)
                    continue;
                if (stride == 0)
                    stride = rbti_draw_block(table, impacts, b, under_way, spins, bounce_seed, seed,
                                             variables);
                const int code = b->codes[r] < RBT_OK ? b->codes[r] : b->draw_codes[r];
                b->goes_on[r] = rbti_end_bounce(b->hits + row, bounce, code, b->states + stride * r,
                                                b->inertia_after[r], out->works != NULL,
                                                b->after + row);
                if (b->goes_on[r])
                    continue;
                rbti_write_row(impacts, first + row, b->after + row, out);
                codes[row] = b->after[row].code;
            }
        }
        for (size_t r = 0; r < under_way; r++)
            if (b->goes_on[r])
                b->rows[going_on++] = b->rows[r];
        under_way = going_on;
    }
}

/* The arrays of a block of some rows, on the stack. */
#define RBTI_REBOUND_BLOCK(block, size)                                                            \
    rbti_wall_hit hits_[size];                                                                     \
    rbti_cascade facets_[size];                                                                    \
    rbti_rebounded after_[size];                                                                   \
    size_t rows_[size];                                                                            \
    int goes_on_[size], codes_[size], draw_codes_[size];                                           \
    double alpha1_[size], speed_[size], spin_[3 * (size)], inertia_[size], grain_[3 * (size)];     \
    uint64_t index_[size];                                                                         \
    uint32_t hit_[size];                                                                           \
    double states_[(RBT_VALUES + 2) * (size)] RBTI_ALIGNED, inertia_after_[size];                  \
    const rbti_rebound_block block = {hits_,    facets_,  after_,     rows_,     goes_on_,         \
                                      codes_,   alpha1_,  speed_,     spin_,     inertia_,         \
                                      grain_,   index_,   hit_,       states_,   inertia_after_,   \
                                      draw_codes_}

#ifdef RBTI_DIRECT

/* Rebound rows by direct simulation, in larger blocks. Returns how many rows were rebounded. */
RBTI_NOT_INLINED size_t rbti_rebound_direct(const rbt_table *table, const rbt_impacts *impacts,
                                            size_t first, size_t count, uint64_t seed,
                                            const rbt_rebounds *out, int *codes)
{
    RBTI_REBOUND_BLOCK(block, RBT_DIRECT_ROWS);
    rbti_rebound_rows(table, impacts, first, count, seed, out, codes, &block);
    return count;
}

#endif
#endif

/* Rebound the next of n rows from `first` on, at most RBTI_MOST_ROWS, and fill their codes. Returns how
   many. */
RBTI_INLINE RBT_DEVICE size_t rbti_rebound_next_rows(const rbt_table *table, const rbt_impacts *impacts,
                                                size_t first, size_t n, uint64_t seed,
                                                const rbt_rebounds *out, int *codes)
{
    const size_t count = n < RBTI_BLOCK ? n : RBTI_BLOCK;
#ifdef RBTI_DIRECT
    if (table->direct && n > 1)
        return rbti_rebound_direct(table, impacts, first, n < RBT_DIRECT_ROWS ? n : RBT_DIRECT_ROWS,
                                   seed, out, codes);
#endif
#ifdef RBTI_BLOCKS
    if (count >= RBTI_FEWEST_IN_BLOCK) {
        RBTI_REBOUND_BLOCK(block, RBTI_BLOCK);
        rbti_rebound_rows(table, impacts, first, count, seed, out, codes, &block);
        return count;
    }
#endif
    for (size_t r = 0; r < count; r++)
        codes[r] = rbti_rebound_row(table, impacts, first + r, seed, out);
    return count;
}

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
        int codes[RBTI_MOST_ROWS];
        count = rbti_rebound_next_rows(table, impacts, first, n - first, seed, rebounds, codes);
        for (size_t r = 0; r < count; r++)
            rbti_count_row(codes[r], first + r, rebounds);
        rbti_count_codes(&tally, codes, count);
    }
    return rbti_result(&tally);
}
