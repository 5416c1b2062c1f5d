/* -- the first-impact draw -----------------------------------------------------------------------

   The law of first impacts: states over V and a/V of particles that arrive without spin, from the impact
   angle, rad, and speed, m/s. A table has nodes of impact angle and speed, and a cell between each four
   of them. A node has a mixture of components, each of which belongs to one of the classes of rebounds.
   The arrays are those of tables/FORMAT.md, "Binary table", and the steps those of "A draw":

     words  rbti_fill_words        Philox4x32-10 of (seed, index, hit)
     1      rbti_locate            cell of the condition, weights of its nodes
     2      rbti_choose_node       one of the four nodes, by word 1
     3      rbti_choose_component  one of its components, by word 0, and the class of it
     4      rbti_fill_normals      words to normals n
            rbti_fill_variates     variates mean + L n, reflected or not, to places among knots
     5      rbti_fill_channel      quantiles at these places, averaged over the nodes
            rbti_to_states         channels to variables of the state */

/* The draws of a block, and what the steps leave for the steps behind them. */
typedef struct rbti_draws {
    double alpha1[RBTI_BLOCK], speed[RBTI_BLOCK];                /* rad, m/s */
    uint32_t words[12 * RBTI_BLOCK];                             /* random words */
    double alpha_weight[RBTI_BLOCK], speed_weight[RBTI_BLOCK];   /* of the upper nodes of the cell */
    float weights[4 * RBTI_BLOCK]; /* of the nodes of the cell */
    int32_t alpha_node[RBTI_BLOCK], speed_node[RBTI_BLOCK]; /* lower nodes of the cell */
    int32_t record[RBTI_BLOCK];    /* first number of the mixture component's record */
    int32_t functions[RBTI_BLOCK]; /* first quantile function of the cell and class */
    float values[RBTI_NAMES * RBTI_BLOCK];    /* normals, then fractions, by row of the factor */
    int32_t entries[RBTI_NAMES * RBTI_BLOCK]; /* quantiles at the knot below, by row */
    double channels[RBTI_CHANNELS * RBTI_BLOCK]; /* quantiles, by RBTI_OF_... */
} rbti_draws;

/* Flags of a condition, without branches. Both laws have one range. */
RBTI_INLINE RBT_DEVICE int rbti_flags(const rbt_table *table, double alpha1, double speed)
{
    const double *measured = table->valid_speed;
    return rbti_is_outside(alpha1, table->alpha.low, table->alpha.high) * RBT_ANGLE |
           rbti_is_outside(speed, table->speed.low, table->speed.high) * RBT_SPEED |
           rbti_is_outside(speed, measured[0], measured[1]) * RBT_EXTRAPOLATED;
}

#ifdef RBTI_BLOCKS
/* Whether a condition cannot be drawn, without branches; rbti_error says why. */
RBTI_INLINE RBT_DEVICE int rbti_cannot_be_drawn(double alpha1, double speed)
{
    const int steep = rbti_is_outside(alpha1, 0.0, RBTI_HALF_PI);
    const int bad = (alpha1 <= 0.0) | steep | (speed <= 0.0);
    return bad | (1 - rbti_finite(alpha1) * rbti_finite(speed));
}
#endif

/* Error of a condition, or RBT_OK. */
RBTI_INLINE RBT_DEVICE int rbti_error(double alpha1, double speed)
{
    if (!(rbti_finite(alpha1) && rbti_finite(speed)))
        return RBT_ERR_NOT_FINITE;
    if (alpha1 <= 0.0 || rbti_is_outside(alpha1, 0.0, RBTI_HALF_PI))
        return RBT_ERR_NOT_APPROACHING;
    return speed <= 0.0 ? RBT_ERR_SPEED_NOT_POSITIVE : RBT_OK;
}

/* Step 1: the lower nodes of the cells on an axis, and the weights of the upper nodes. */
RBTI_INLINE RBT_DEVICE void rbti_locate(size_t m, const rbt_axis *grid, const double *values,
                                        int32_t *nodes, double *weights)
{
    const rbt_axis axis = *grid; /* a copy, so that compilers keep it in registers */
    RBTI_EACH_DRAW(r) {
        const double value = rbti_bounded(values[r], axis.first, axis.last);
        const double position =
            rbti_bounded((value - axis.origin) * axis.scale, 0.0, axis.grid - 1.0);
        int32_t k = (int32_t)position;
        k = k < axis.grid - 2 ? k : axis.grid - 2;
        const double below = axis.coordinate[k];
        const double x = below + (position - k) * (axis.coordinate[k + 1] - below);
        /* on an axis of one node both neighbours are that node, with weight 0 for the upper one */
        int32_t lower = (int32_t)x - axis.offset;
        lower = lower < axis.nodes - 2 ? lower : axis.nodes - 2;
        lower = lower > 0 ? lower : 0;
        const double most = axis.nodes > 1 ? 1.0 : 0.0;
        double weight = x - (lower + axis.offset);
        weight = weight > 0.0 ? weight : 0.0;
        weights[r] = weight < most ? weight : most;
        nodes[r] = lower;
    }
}

/* Step 2: the weights of the four nodes of a cell, and one of the nodes, chosen with these weights by the
   upper 20 bits of word 1. Also the column of its alias table, and the place in that column in units of
   2^-16: these are the integer and the fractional part of word 0 times the number of columns over 2^32,
   computed in 32 bits. */
RBTI_INLINE RBT_DEVICE void rbti_choose_node(size_t m, const rbt_table *table, rbti_draws *d,
                                             int32_t *node, int32_t *column, uint32_t *fraction)
{
    const int32_t last_alpha = table->alpha.nodes - 1, last_speed = table->speed.nodes - 1;
    const uint32_t columns = (uint32_t)table->n_components;
    RBTI_EACH_DRAW(r) {
        const double t = d->alpha_weight[r], s = d->speed_weight[r];
        const double w0 = (1.0 - t) * (1.0 - s), w1 = (1.0 - t) * s, w2 = t * (1.0 - s);
        d->weights[r] = (float)w0;
        d->weights[m + r] = (float)w1;
        d->weights[2 * m + r] = (float)w2;
        d->weights[3 * m + r] = (float)(t * s);
        const double c = ((double)(int32_t)(d->words[m + r] >> 12) + 0.5) * (1.0 / 1048576.0);
        const double half = w0 + w1;
        const int32_t upper_alpha = c >= half;
        const double limit = upper_alpha ? half + w2 : w0;
        const int32_t upper_speed = c >= limit;
        const int32_t i = d->alpha_node[r] + upper_alpha, j = d->speed_node[r] + upper_speed;
        node[r] = (i < last_alpha ? i : last_alpha) * (last_speed + 1) +
                  (j < last_speed ? j : last_speed);
        const uint32_t word = d->words[r];
        const uint32_t product = (word >> 16) * columns + ((word & 0xffffu) * columns >> 16);
        fraction[r] = product & 0xffffu;
        column[r] = (int32_t)(product >> 16);
    }
}

/* Step 3: one component of the mixture of the node, by the alias method, and the class of the
   component. */
RBTI_INLINE RBT_DEVICE void rbti_choose_component(size_t m, const rbt_table *table, rbti_draws *d)
{
    const int32_t components = table->n_components, classes = table->n_classes;
    const int32_t cells_of_row = table->speed.nodes > 1 ? table->speed.nodes - 1 : 1;
    int32_t node[RBTI_BLOCK] RBTI_ALIGNED, column[RBTI_BLOCK] RBTI_ALIGNED;
    int32_t kind[RBTI_BLOCK] RBTI_ALIGNED, first[RBTI_BLOCK] RBTI_ALIGNED;
    uint32_t fraction[RBTI_BLOCK] RBTI_ALIGNED, entry[RBTI_BLOCK] RBTI_ALIGNED;
    rbti_choose_node(m, table, d, node, column, fraction);
    RBTI_EACH_DRAW(r)
        RBTI_PREFETCH(table->alias + node[r] * components + column[r]);
    RBTI_EACH_DRAW(r)
        entry[r] = table->alias[node[r] * components + column[r]];
    RBTI_EACH_DRAW(r) {
        const int32_t other = (int32_t)(entry[r] & 0xffffu);
        column[r] = fraction[r] >= entry[r] >> 16 ? other : column[r];
        kind[r] = 0;
    }
    for (int32_t k = 1; k < classes; k++) {
        RBTI_EACH_DRAW(r)
            first[r] = table->first_of_class[node[r] * classes + k];
        RBTI_EACH_DRAW(r)
            kind[r] = column[r] >= first[r] ? k : kind[r];
    }
    RBTI_EACH_DRAW(r) {
        const int32_t cell = d->alpha_node[r] * cells_of_row + d->speed_node[r];
        d->record[r] = (node[r] * components + column[r]) * table->stride;
        d->functions[r] = (cell * classes + kind[r]) * table->n_marginals;
    }
    RBTI_EACH_DRAW(r)
        RBTI_PREFETCH(table->components + d->record[r]);
}

/* Pairs of 16-bit numbers in the longest record, of 8 channels. */
#define RBTI_PAIRS 23

/* Read records number by number: factors[k m + r] becomes number k of the record of draw r. */
RBTI_INLINE RBT_DEVICE void rbti_fill_factors(size_t m, const rbt_table *table, int32_t n,
                                              const int32_t *records, float *factors)
{
    const int32_t pairs = (2 + n + n * (n + 1) / 2) / 2;
    uint32_t raw[RBTI_PAIRS * RBTI_BLOCK] RBTI_ALIGNED;
    RBTI_EACH_DRAW(r) {
        const int16_t *record = table->components + records[r];
        for (int32_t k = 0; k < pairs; k++)
            memcpy(raw + (size_t)k * m + r, record + 2 * k, sizeof *raw);
    }
    for (size_t k = 0; k < (size_t)pairs; k++) {
        RBTI_EACH_DRAW(r) {
            const uint32_t pair = raw[k * m + r];
            factors[2 * k * m + r] = (float)((int32_t)(pair << 16) >> 16);
            factors[(2 * k + 1) * m + r] = (float)((int32_t)pair >> 16);
        }
    }
}

/* Step 4: normal numbers n become variates mean + L n, reflected or not, and these become fractions
   between two knots. */
RBTI_INLINE RBT_DEVICE void rbti_fill_variates(size_t m, const rbt_table *table, int32_t n,
                                               rbti_draws *d)
{
    const float variate_max = (float)table->variate_max, scale = (float)table->variate_scale;
    const float last = (float)(table->n_knots - 1);
    const int32_t last_but_one = table->n_knots - 2, knots = table->n_knots;
    float factors[2 * RBTI_PAIRS * RBTI_BLOCK] RBTI_ALIGNED;
    float unit[2 * RBTI_BLOCK] RBTI_ALIGNED;
    rbti_fill_factors(m, table, n, d->record, factors);
    RBTI_EACH_DRAW(r) {
        const float limit = (float)(int32_t)(d->words[m + r] & 4095u);
        unit[r] = RBTI_UNIT;
        unit[m + r] = limit < factors[r] ? -RBTI_UNIT : RBTI_UNIT;
    }
    for (int32_t row = n - 1; row >= 0; row--) {
        /* from the last row upwards, so that each row still finds the normals it needs */
        const float *units = table->mirrored[row] ? unit + m : unit;
        const float *factor = factors + (size_t)(1 + row) * m;
        float *values = d->values + (size_t)row * m;
        int32_t *entries = d->entries + (size_t)row * m;
        float z[RBTI_BLOCK] RBTI_ALIGNED;
        RBTI_EACH_DRAW(r)
            z[r] = factor[r];
        factor += (size_t)n * m;
        for (int32_t column = 0; column <= row; column++) {
            RBTI_EACH_DRAW(r)
                z[r] += factor[r] * d->values[(size_t)column * m + r];
            factor += (size_t)(n - column - 1) * m;
        }
        RBTI_EACH_DRAW(r) {
            float position = (z[r] * units[r] + variate_max) * scale;
            position = position > 0.0f ? position : 0.0f;
            position = position < last ? position : last;
            int32_t k = (int32_t)position;
            k = k < last_but_one ? k : last_but_one;
            values[r] = position - (float)k;
            entries[r] = ((d->functions[r] + table->marginals[row]) * knots + k) * 4;
        }
        if (table->marginals[row] >= 0) {
            RBTI_EACH_DRAW(r)
                RBTI_PREFETCH(table->quantiles + entries[r]);
        }
    }
}

/* Step 5: the quantile of one channel between two knots, averaged over the four nodes. */
RBTI_INLINE RBT_DEVICE void rbti_fill_channel(size_t m, const rbt_table *table, int32_t row,
                                              const rbti_draws *d, double *channel)
{
    uint32_t raw[4 * RBTI_BLOCK] RBTI_ALIGNED;
    const float *fractions = d->values + (size_t)row * m;
    const int32_t *entries = d->entries + (size_t)row * m;
    double least[RBTI_BLOCK] RBTI_ALIGNED, step[RBTI_BLOCK] RBTI_ALIGNED;
    RBTI_EACH_DRAW(r) {
        uint32_t eight[4];
        memcpy(eight, table->quantiles + entries[r], sizeof eight);
        raw[r] = eight[0];
        raw[m + r] = eight[1];
        raw[2 * m + r] = eight[2];
        raw[3 * m + r] = eight[3];
    }
    RBTI_EACH_DRAW(r) {
        const double *span = table->spans + 2 * (d->functions[r] + table->marginals[row]);
        least[r] = span[0];
        step[r] = span[1];
    }
    RBTI_EACH_DRAW(r) {
        const float f = fractions[r];
        float mean[2];
        for (size_t half = 0; half < 2; half++) {
            const uint32_t low = raw[half * m + r], high = raw[(2 + half) * m + r];
            const float *weights = d->weights + 2 * half * m + r;
            const float low0 = (float)(int32_t)(low & 0xffffu);
            const float low1 = (float)(int32_t)(low >> 16);
            const float high0 = (float)(int32_t)(high & 0xffffu);
            const float high1 = (float)(int32_t)(high >> 16);
            mean[half] = weights[0] * (low0 + f * (high0 - low0)) +
                         weights[m] * (low1 + f * (high1 - low1));
        }
        channel[r] = least[r] + step[r] * (double)(mean[0] + mean[1]);
    }
}

/* The same in its place among the channels. In registers, which a device has in place of memory, no
   place can be looked up. */
RBTI_INLINE RBT_DEVICE void rbti_place_channel(size_t m, const rbt_table *table, int32_t row,
                                               rbti_draws *d)
{
#if defined(RBTI_GPU)
    double channel;
    rbti_fill_channel(m, table, row, d, &channel);
    for (int k = 0; k < RBTI_CHANNELS; k++)
        d->channels[k] = k == table->channels[row] ? channel : d->channels[k];
#else
    rbti_fill_channel(m, table, row, d, d->channels + (size_t)table->channels[row] * m);
#endif
}

/* Whether the table has a variable, RBT_U to RBT_WORK_SHEAR. */
RBTI_INLINE RBT_DEVICE int rbti_has_variable(const rbt_table *table, int variable)
{
    return table->variable_bits >> variable & 1u;
}

/* Channels become variables of the state, as tables/FORMAT.md gives them: the first six or all ten
   variables of `count` draws. The name after_x is the share of the energy that is neither in x nor in
   what came before x. */
RBTI_INLINE RBT_DEVICE void rbti_to_states(size_t m, size_t count, int variables,
                                           const rbt_table *table, const rbti_draws *d,
                                           double *states)
{
    const double least = table->least_inertia;
    const double *v = d->channels + RBTI_OF_V * m, *u_hat = d->channels + RBTI_OF_U_HAT * m;
    const double *w_hat = d->channels + RBTI_OF_W_HAT * m;
    const double *omega_x = d->channels + RBTI_OF_OMEGA_X * m;
    const double *omega_y = d->channels + RBTI_OF_OMEGA_Y * m;
    const double *omega_z = d->channels + RBTI_OF_OMEGA_Z * m;
    const double *energy_hat = d->channels + RBTI_OF_ENERGY_HAT * m;
    const double *collisions = d->channels + RBTI_OF_COLLISIONS * m;
    const double *normal_hat = d->channels + RBTI_OF_NORMAL_HAT * m;
    double u[RBTI_BLOCK] RBTI_ALIGNED, w[RBTI_BLOCK] RBTI_ALIGNED, after_u[RBTI_BLOCK] RBTI_ALIGNED;
    double normal[RBTI_BLOCK] RBTI_ALIGNED, after_w[RBTI_BLOCK] RBTI_ALIGNED;
    double shorter[RBTI_BLOCK] RBTI_ALIGNED;
    RBTI_EACH_DRAW(r) {
        const double n = normal_hat[r], square = n * n, fourth = square * square;
        const double x = omega_x[r], y = omega_y[r], z = omega_z[r];
        const double after_v = (1.0 - v[r]) * (1.0 + v[r]);
        /* if the table has no works, this factor is exactly 1 */
        const double after_n = after_v * ((1.0 - n) * (1.0 + n) * (1.0 + square + fourth));
        normal[r] = fourth * square * after_v;
        after_u[r] = after_n * ((1.0 - u_hat[r]) * (1.0 + u_hat[r]));
        u[r] = u_hat[r] * sqrt(after_n);
        w[r] = w_hat[r] * sqrt(after_u[r]);
        after_w[r] = after_u[r] * ((1.0 - w_hat[r]) * (1.0 + w_hat[r]));
        /* a rotation has no more energy than is there, whatever the quantiles are; mostly exactly 1 */
        const double energy = after_w[r] + normal[r], turns = least * (x * x + y * y + z * z);
        shorter[r] = sqrt(energy / (turns > energy ? turns : energy));
    }
    for (size_t r = 0; r < count; r++) {
        double *state = states + (size_t)variables * r;
        state[RBT_U] = u[r];
        state[RBT_V] = v[r];
        state[RBT_W] = w[r];
        state[RBT_OMEGA_X] = omega_x[r] * shorter[r];
        state[RBT_OMEGA_Y] = omega_y[r] * shorter[r];
        state[RBT_OMEGA_Z] = omega_z[r] * shorter[r];
        if (variables > 6) {
            state[RBT_ROTATIONAL_ENERGY] = energy_hat[r] * after_w[r];
            state[RBT_COLLISIONS] = floor(collisions[r]);
            state[RBT_WORK_NORMAL] = rbti_has_variable(table, RBT_WORK_NORMAL) ? normal[r] : 0.0;
            state[RBT_WORK_SHEAR] =
                rbti_has_variable(table, RBT_WORK_SHEAR) ? (1.0 - energy_hat[r]) * after_w[r] : 0.0;
        }
    }
}

/* Draw the states of conditions that can be drawn, by all steps. n is the number of channels. */
RBTI_INLINE RBT_DEVICE void rbti_fill_states(size_t m, const rbt_table *table, int32_t n,
                                            uint64_t seed, const uint64_t *index,
                                            const uint32_t *hit, size_t count, int variables,
                                            rbti_draws *d, double *states)
{
    const uint32_t blocks = n <= 2 ? 1 : n <= 6 ? 2 : 3;
    for (uint32_t block = 0; block < blocks; block++)
        rbti_fill_words(m, block, seed, index, hit, count, d->words + 4 * block * m);
    rbti_locate(m, &table->alpha, d->alpha1, d->alpha_node, d->alpha_weight);
    rbti_locate(m, &table->speed, d->speed, d->speed_node, d->speed_weight);
    rbti_choose_component(m, table, d);
    for (int32_t row = 0; row < n; row++)
        rbti_fill_normals(m, table->normals, d->words + rbti_word_of_normal((size_t)row) * m,
                          d->values + (size_t)row * m);
    if (n == 6) /* as most tables have: the compiler unrolls the triangle of factors */
        rbti_fill_variates(m, table, 6, d);
    else
        rbti_fill_variates(m, table, n, d);
    memset(d->channels, 0, RBTI_CHANNELS * m * sizeof *d->channels);
    for (int32_t row = 0; row < n; row++)
        if (table->marginals[row] >= 0)
            rbti_place_channel(m, table, row, d);
    rbti_to_states(m, count, variables, table, d, states);
}

/* One draw from a table with any number of channels. */
RBTI_NOT_INLINED RBT_DEVICE void rbti_draw_channels(const rbt_table *table, double alpha1,
                                                    double speed, uint64_t seed, uint64_t index,
                                                    uint32_t hit, int variables, double *state)
{
    rbti_draws draws;
    draws.alpha1[0] = alpha1;
    draws.speed[0] = speed;
    rbti_fill_states(1, table, table->n_channels, seed, &index, &hit, 1, variables, &draws, state);
}

/* One draw of the first six or of all variables. If the number of channels is known, a device needs only
   registers. */
RBTI_INLINE RBT_DEVICE void rbti_draw_node(const rbt_table *table, double alpha1, double speed,
                                           uint64_t seed, uint64_t index, uint32_t hit,
                                           int variables, double *state)
{
#ifdef RBTI_BLOCKS
    rbti_draw_channels(table, alpha1, speed, seed, index, hit, variables, state);
#else
    if (table->n_channels != 6) {
        double values[RBT_VALUES]; /* not `state`, so that this stays in registers */
        rbti_draw_channels(table, alpha1, speed, seed, index, hit, variables, values);
        for (int k = 0; k < variables; k++)
            state[k] = values[k];
        return;
    }
    rbti_draws draws;
    draws.alpha1[0] = alpha1;
    draws.speed[0] = speed;
    rbti_fill_states(1, table, 6, seed, &index, &hit, 1, variables, &draws, state);
#endif
}

#ifdef RBTI_BLOCKS

/* Take the conditions of a block of rows from `first` on, and fill their codes. A row with an error takes
   a condition of the table, so that the whole block can be drawn. */
RBTI_INLINE void rbti_take_conditions(const rbt_table *table, const rbt_conditions *conditions,
                                      size_t first, size_t count, rbti_draws *d, int *codes)
{
    const size_t m = RBTI_BLOCK;
    int bad = 0;
    RBTI_EACH_DRAW(r) {
        const size_t k = first + (r < count ? r : count - 1);
        d->alpha1[r] = conditions->alpha1[k];
        d->speed[r] = conditions->speed[k];
    }
    RBTI_EACH_DRAW(r) {
        codes[r] = rbti_flags(table, d->alpha1[r], d->speed[r]);
        bad |= rbti_cannot_be_drawn(d->alpha1[r], d->speed[r]);
    }
    for (size_t r = 0; r < m && bad; r++) {
        const int error = rbti_error(d->alpha1[r], d->speed[r]);
        if (error < RBT_OK) {
            codes[r] = error;
            d->alpha1[r] = table->alpha.first;
            d->speed[r] = table->speed.first;
        }
    }
}

/* Draw a block of rows and fill their codes. If `states` is NULL only the codes are written. */
RBTI_INLINE void rbti_draw_nodes_body(const rbt_table *table, const rbt_conditions *conditions,
                                      size_t first, size_t count, uint64_t seed, int variables,
                                      double *states, int *codes)
{
    rbti_draws draws RBTI_ALIGNED;
    const uint64_t *index = conditions->index + first;
    const uint32_t *hit = conditions->hit + first;
    rbti_take_conditions(table, conditions, first, count, &draws, codes);
    if (!states)
        return;
    rbti_fill_states(RBTI_BLOCK, table, table->n_channels, seed, index, hit, count, variables, &draws,
                    states);
}

#define RBTI_NODES_PARAMETERS                                                                      \
    (const rbt_table *table, const rbt_conditions *conditions, size_t first, size_t count,         \
     uint64_t seed, int variables, double *states, int *codes)
#define RBTI_NODES_ARGUMENTS (table, conditions, first, count, seed, variables, states, codes)
#ifdef RBTI_NO_VERSIONS
RBTI_BLOCK_VERSION(rbti_draw_nodes, , "", RBTI_NODES_PARAMETERS, RBTI_NODES_ARGUMENTS)
#else
RBTI_BLOCK_VERSION(rbti_draw_nodes, _avx2, "avx2", RBTI_NODES_PARAMETERS, RBTI_NODES_ARGUMENTS)
/* what x86-64-v4 adds, feature by feature: `arch=` would take back those that -march=native has given */
RBTI_BLOCK_VERSION(rbti_draw_nodes, _avx512,
                   "avx512f,avx512bw,avx512cd,avx512dq,avx512vl,bmi,bmi2,f16c,fma,lzcnt,movbe",
                   RBTI_NODES_PARAMETERS, RBTI_NODES_ARGUMENTS)
RBTI_INLINE void rbti_draw_nodes RBTI_NODES_PARAMETERS
{
    if (__builtin_cpu_supports("x86-64-v4"))
        rbti_draw_nodes_avx512 RBTI_NODES_ARGUMENTS;
    else
        rbti_draw_nodes_avx2 RBTI_NODES_ARGUMENTS;
}
#endif

#endif
