#ifndef RBT_DEVICE_ONLY

/* -- batches of rebounds ------------------------------------------------------------------------- */

/* Impacts of a block of rows: with facets, where walls are rough. */
typedef struct rbti_rows {
    rbti_impact met[RBTI_BLOCK];
    rbti_cascade cascades[RBTI_BLOCK];
    int rough[RBTI_BLOCK];
    double alpha1[RBTI_BLOCK], speed[RBTI_BLOCK], spin[3 * RBTI_BLOCK], states[6 * RBTI_BLOCK];
} rbti_rows;

/* Grains of some impacts from row k on. */
RBTI_INLINE rbti_grains rbti_grains_of(const rbt_table *table, const rbt_impacts *impacts, size_t k,
                                       uint64_t seed)
{
    const rbti_grains grains = {impacts->grain ? impacts->grain + 3 * k : NULL, seed,
                                impacts->fresh_grains || table->spin.fresh_grains};
    return grains;
}

/* Impact of row k on the wall, or on the first facet, as row r of a block. */
static int rbti_meet_row(const rbt_impacts *impacts, size_t k, uint64_t seed, size_t r,
                         rbti_rows *rows)
{
    const double *velocity = impacts->velocity + 3 * k, *normal = impacts->normal + 3 * k;
    const double *wall = impacts->wall_velocity ? impacts->wall_velocity + 3 * k : NULL;
    const double *omega = impacts->omega ? impacts->omega + 3 * k : NULL;
    const double half_size = impacts->half_size[k];
    const double roughness = impacts->roughness ? impacts->roughness[k] : 0.0;
    const uint64_t index = impacts->index[k];
    const uint32_t hit = impacts->hit[k];
    rbti_impact *met = &rows->met[r];
    int code;
    rows->rough[r] = rbti_is_rough(roughness);
    if (rows->rough[r]) {
        rbti_cascade *c = &rows->cascades[r];
        double facet[3];
        code = rbti_begin(velocity, normal, half_size, wall, roughness, impacts->isotropic, omega, c);
        if (code == RBT_OK)
            code = rbti_meet_facet(c, seed, index, hit, facet);
        if (code == RBT_OK)
            code = rbti_meet(c->moving, facet, half_size, NULL, seed, index, hit, met);
    } else {
        code = rbti_meet(velocity, normal, half_size, wall, seed, index, hit, met);
    }
    for (int j = 0; j < 3; j++)
        rows->spin[3 * r + (size_t)j] = 0.0;
    if (code == RBT_OK && omega)
        code = rbti_to_spin(met, omega, rows->spin + 3 * r);
    if (code == RBT_OK) {
        rows->alpha1[r] = met->alpha1;
        rows->speed[r] = met->speed;
    }
    return code;
}

/* Flags of the first impact of a row that was drawn. */
static int rbti_row_status(const rbt_table *table, const rbti_rows *rows, int spins, size_t r)
{
    const double *spin = rows->spin + 3 * r;
    if (spins)
        return rbti_spin_status(table, rows->alpha1[r], rows->speed[r], spin[0], spin[1], spin[2]);
    return rbti_status(table, rows->alpha1[r], rows->speed[r]);
}

/* Write row r of a block as row k, after further bounces where it needs them. */
static int rbti_leave_row(const rbt_table *table, const rbt_impacts *impacts, size_t k,
                          uint64_t seed, size_t r, rbti_rows *rows, double *velocity,
                          double *omega)
{
    const double *state = rows->states + 6 * r;
    if (!rows->rough[r]) {
        rbti_leave(&rows->met[r], state, velocity, omega);
        return RBT_OK;
    }
    rbti_cascade *c = &rows->cascades[r];
    int code = RBT_OK;
    rbti_leave(&rows->met[r], state, c->moving, c->turning);
    if (!rbti_has_left(c)) {
        const rbti_grains grains = rbti_grains_of(table, impacts, k, seed);
        code = rbti_bounces(table, c, 1, table->spin.n_shapes == 0, seed, &grains,
                            impacts->index[k], impacts->hit[k]);
    }
    if (code >= RBT_OK)
        rbti_end(c, velocity, omega);
    return code;
}

/* Rebounds of a block of rows from one on: how many, and the code of the one behind them. */
static size_t rbti_rebound_block(const rbt_table *table, size_t first, size_t most,
                                 const rbt_impacts *impacts, uint64_t seed, rbti_rows *rows,
                                 double *new_velocity, double *new_omega, int *code,
                                 rbt_report *report)
{
    const rbti_grains grains = rbti_grains_of(table, impacts, first, seed);
    const int spins = impacts->omega || !rbti_is_first(table, &grains);
    const rbti_output out = {rows->states, NULL, NULL, 6, 6};
    const rbt_conditions drawn_at = {rows->alpha1,
                                     rows->speed,
                                     spins ? rows->spin : NULL,
                                     impacts->grain ? impacts->grain + 3 * first : NULL,
                                     impacts->index + first,
                                     impacts->hit + first,
                                     impacts->fresh_grains};
    rbt_report part;
    size_t count = 0, r = 0;
    while (count < most && *code == RBT_OK) {
        *code = rbti_meet_row(impacts, first + count, seed, count, rows);
        count += *code == RBT_OK;
    }
    const int drawn = rbti_sample_rows(table, count, &drawn_at, seed, &out, &part);
    *code = drawn < RBT_OK ? drawn : *code;
    for (; r < part.row; r++) {
        const size_t k = first + r;
        const int status = part.clamped + part.extrapolated > 0
                               ? rbti_row_status(table, rows, spins || table->spin.for_first, r)
                               : RBT_OK;
        const int left = rbti_leave_row(table, impacts, k, seed, r, rows, new_velocity + 3 * k,
                                        new_omega + 3 * k);
        if (left < RBT_OK) {
            *code = left;
            break;
        }
        rbti_count_flags(status | left, k, report);
    }
    return r;
}

/* A batch of one, which many trackers have: no block is filled for it. */
static int rbti_rebound_row(const rbt_table *table, const rbt_impacts *impacts, uint64_t seed,
                            double *new_velocity, double *new_omega, rbt_report *report)
{
    const rbti_grains grains = rbti_grains_of(table, impacts, 0, seed);
    const int code = rbti_any_rebound(table, impacts->velocity, impacts->normal,
                                      impacts->half_size[0], impacts->wall_velocity,
                                      impacts->roughness ? impacts->roughness[0] : 0.0,
                                      impacts->isotropic, impacts->omega, seed, &grains,
                                      impacts->index[0], impacts->hit[0], new_velocity, new_omega);
    if (report) {
        const rbt_report none = {code >= RBT_OK, 1, 0, 0, 1};
        *report = none;
        rbti_count_flags(code < RBT_OK ? RBT_OK : code, 0, report);
    }
    return code;
}

RBT_API int rbt_rebound_batch(const rbt_table *table, size_t n, const rbt_impacts *impacts,
                              uint64_t seed, double *new_velocity, double *new_omega,
                              rbt_report *report)
{
    rbti_rows rows;
    rbt_report found = {n, n, 0, 0, n};
    int code = RBT_OK;
    if (n == 1)
        return rbti_rebound_row(table, impacts, seed, new_velocity, new_omega, report);
    for (size_t first = 0; first < n && code == RBT_OK; first += RBTI_BLOCK) {
        const size_t most = n - first < RBTI_BLOCK ? n - first : RBTI_BLOCK;
        const size_t done = rbti_rebound_block(table, first, most, impacts, seed, &rows,
                                               new_velocity, new_omega, &code, &found);
        if (code != RBT_OK)
            found.row = first + done;
    }
    if (report)
        *report = found;
    return rbti_batch_code(code, &found);
}
