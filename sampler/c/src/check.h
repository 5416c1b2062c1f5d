/* Size of what is known of a header: those of older versions are shorter, those of newer ones longer. */
static RBT_DEVICE size_t rbti_header_bytes(const rbti_header *header)
{
    return header->header_bytes < sizeof *header ? header->header_bytes : sizeof *header;
}

/* Header of an image, and what older ones do not say: any speed and any spin is valid. */
static RBT_DEVICE void rbti_read_header(const char *image, rbti_header *header)
{
    const double speeds[2] = {0.0, 1e300}, spins[2] = {RBTI_ANY_SPIN_BOUNDS};
    memset(header, 0, sizeof *header);
    memcpy(header, image, RBTI_FIRST_HEADER_BYTES);
    memcpy(header->valid_speed, speeds, sizeof speeds);
    memcpy(header->spin_size, spins, sizeof spins);
    memcpy(header, image, rbti_header_bytes(header));
}

#ifndef RBT_DEVICE_ONLY

static int rbti_check_start(const char *image, size_t size, rbti_header *header)
{
    const uint32_t one = 1;
    uint8_t least;
    memcpy(&least, &one, 1);
    RBTI_NEED(least == 1, RBT_ERR_BIG_ENDIAN);
    RBTI_NEED(size >= 8 && memcmp(image, RBTI_MAGIC, 8) == 0, RBT_ERR_FORMAT);
    RBTI_NEED(size >= RBTI_FIRST_HEADER_BYTES, RBT_ERR_SIZE);
    memcpy(header, image, RBTI_FIRST_HEADER_BYTES);
    RBTI_NEED(header->major == RBTI_MAJOR, RBT_ERR_VERSION);
    RBTI_NEED(header->header_bytes >= RBTI_FIRST_HEADER_BYTES && size >= header->header_bytes,
              RBT_ERR_SIZE);
    RBTI_NEED(header->file_bytes == size && size < RBTI_MOST_BYTES, RBT_ERR_SIZE);
    rbti_read_header(image, header);
    return RBT_OK;
}

static int rbti_check_sum(const char *image, size_t size, const rbti_header *header)
{
    const size_t at = offsetof(rbti_header, sha256);
    uint8_t digest[32];
    const uint8_t *bytes = (const uint8_t *)image;
    rbti_sha256(bytes, at, bytes + at + 32, size - at - 32, digest);
    return memcmp(digest, header->sha256, 32) == 0 ? RBT_OK : RBT_ERR_CHECKSUM;
}

static int rbti_check_dimensions(const rbti_header *h)
{
#define RBTI_DO(name, least, most)                                                                 \
    RBTI_NEED(h->name >= least && h->name <= most, RBT_ERR_DIMENSIONS);
    RBTI_DIMENSIONS(RBTI_DO)
    if (h->n_shapes > 0) {
        RBTI_SPIN_DIMENSIONS(RBTI_DO)
    }
#undef RBTI_DO
    const uint32_t needed = 1 + h->n_channels + h->n_channels * (h->n_channels + 1) / 2;
    uint32_t stride = 1;
    while (stride < needed)
        stride *= 2;
    RBTI_NEED(h->stride == stride, RBT_ERR_DIMENSIONS);
    return RBT_OK;
}

/* Whether the name of the pair ends in the header, and has no bytes that control a terminal. */
static int rbti_pair_holds(const rbti_header *h)
{
    unsigned before = 0;
    for (size_t k = 0; k < sizeof h->pair; k++) {
        const unsigned byte = (unsigned char)h->pair[k];
        if (byte == 0)
            return 1;
        if (byte < 0x20 || byte == 0x7f || (before == 0xc2 && byte < 0xa0))
            return 0;
        before = byte;
    }
    return 0;
}

/* Bits of n names, all below a number and different, followed by -1 only; 0 if they are not. */
static unsigned rbti_name_bits(const int8_t names[RBTI_NAMES], uint32_t n, int known)
{
    unsigned bits = 0;
    for (uint32_t k = 0; k < RBTI_NAMES; k++) {
        if (k >= n) {
            if (names[k] != -1)
                return 0;
            continue;
        }
        if (names[k] < 0 || names[k] >= known || (bits >> names[k] & 1u))
            return 0;
        bits |= 1u << names[k];
    }
    return bits;
}

static int rbti_check_names(const rbti_header *h)
{
    static const unsigned needs[RBT_VALUES] = RBTI_NEEDS;
    RBTI_NEED(rbti_pair_holds(h), RBT_ERR_NAMES);
    RBTI_NEED(rbti_name_bits(h->channels, h->n_channels, RBTI_CHANNELS), RBT_ERR_NAMES);
    RBTI_NEED(rbti_name_bits(h->columns, h->n_columns, RBT_VALUES), RBT_ERR_NAMES);
    unsigned needed = 0, held = 0;
    uint32_t marginals = 0;
    for (uint32_t k = 0; k < RBTI_NAMES; k++) {
        if (h->marginals[k] != -1) {
            RBTI_NEED(k < h->n_channels && h->marginals[k] == (int)marginals, RBT_ERR_NAMES);
            marginals++;
            held |= 1u << h->channels[k];
        }
        if (k < h->n_columns)
            needed |= needs[h->columns[k]];
    }
    /* a table that lost its works still gives out u and w after them */
    RBTI_NEED(held == needed || held == (needed | RBTI_NORMAL_HAT), RBT_ERR_NAMES);
    RBTI_NEED(marginals == h->n_marginals, RBT_ERR_NAMES);
    return RBT_OK;
}

/* Whether rows of numbers, and extra numbers behind them, lie in the file at an aligned offset.
   Rows and numbers are below 2^38 each, and a quotient rounded down cannot mislead. */
static int rbti_lies(const rbti_header *h, uint64_t at, uint64_t rows, uint64_t numbers,
                     uint64_t extra, uint64_t bytes)
{
    if (at % 64 != 0 || at < rbti_header_bytes(h) || at > h->file_bytes)
        return 0;
    const uint64_t room = (h->file_bytes - at) / bytes;
    return extra <= room && rows <= (room - extra) / numbers;
}

static int rbti_check_offsets(const rbti_header *h)
{
#define RBTI_DO(name, member, type, rows, numbers, extra)                                          \
    RBTI_NEED(rbti_lies(h, h->at_##name, rows, numbers, extra, sizeof(type)), RBT_ERR_OFFSETS);
    RBTI_ARRAYS(RBTI_DO)
    if (h->n_shapes > 0) {
        RBTI_SPIN_ARRAYS(RBTI_DO)
        if (h->at_shape_inertia > 0)
            RBTI_INERTIA_ARRAYS(RBTI_DO)
        if (h->n_laws > 0)
            RBTI_LAW_ARRAYS(RBTI_DO)
    }
#undef RBTI_DO
    return RBT_OK;
}

/* Whether a number is finite and within bounds. */
static int rbti_within(double x, double least, double most)
{
    return rbti_finite(x) && least <= x && x <= most;
}

static int rbti_range_holds(double first, double last, double least, double largest)
{
    return rbti_within(first, least, largest) && rbti_within(last, first, largest);
}

static int rbti_axis_holds(const rbt_axis *a, double least, double largest)
{
    const int one = a->first == a->last;
    return rbti_range_holds(a->first, a->last, least, largest) &&
           rbti_within(a->origin, 0.0, a->first) && rbti_finite(a->scale) && a->scale >= 0.0 &&
           (a->nodes == 1) == one &&
           (a->scale > 0.0 || (one && a->origin == a->first && a->offset == 0)) &&
           (a->last - a->origin) * a->scale <= (a->grid - 1.0) * (1.0 + 1e-9);
}

static int rbti_check_axes(const rbt_table *table)
{
    const double variate[2] = {RBTI_VARIATE_BOUNDS};
    RBTI_NEED(rbti_axis_holds(&table->alpha, RBTI_ALPHA_BOUNDS), RBT_ERR_INDICES);
    RBTI_NEED(rbti_axis_holds(&table->speed, RBTI_SPEED_BOUNDS), RBT_ERR_INDICES);
    RBTI_NEED(rbti_within(table->variate_max, variate[0], variate[1]), RBT_ERR_INDICES);
    RBTI_NEED(rbti_range_holds(table->valid_speed[0], table->valid_speed[1], 0.0, 1e300),
              RBT_ERR_INDICES);
    RBTI_NEED(rbti_within(table->least_inertia, 0.0, RBTI_INERTIA), RBT_ERR_INDICES);
    return RBT_OK;
}

/* Ranges of the spin law. */
static int rbti_check_spin_axes(const rbt_spin_law *law)
{
    const double bounds[2] = {RBTI_SPEED_COORDINATE_BOUNDS};
    RBTI_NEED(rbti_range_holds(law->alpha_first, law->alpha_last, RBTI_ALPHA_BOUNDS),
              RBT_ERR_INDICES);
    RBTI_NEED(rbti_range_holds(law->speed_first, law->speed_last, RBTI_SPIN_SPEED_BOUNDS),
              RBT_ERR_INDICES);
    RBTI_NEED(rbti_range_holds(law->least_spin, law->most_spin, 0.0, 1.1e300), RBT_ERR_INDICES);
    RBTI_NEED(rbti_within(law->speed_scale, 0.0, RBTI_MOST_SPEED_SCALE) &&
                  rbti_within(law->speed_exponent, bounds[0], bounds[1]),
              RBT_ERR_INDICES);
    return RBT_OK;
}

/* Whether the coordinate at a value of the axis is a certain whole number, but for rounding. */
static int rbti_number_holds(const rbt_axis *axis, double value, double number)
{
    const double last = axis->grid - 1.0;
    double position = (value - axis->origin) * axis->scale;
    position = position < last ? position : last;
    const int32_t k = (int32_t)position < axis->grid - 2 ? (int32_t)position : axis->grid - 2;
    const double below = axis->coordinate[k];
    const double found = below + (position - k) * (axis->coordinate[k + 1] - below);
    return fabs(found - number) <= RBTI_NUMBER_ROUNDING;
}

static int rbti_coordinate_holds(const rbt_axis *axis)
{
    const double *values = axis->coordinate;
    int holds = 1;
    for (int32_t k = 0; k < axis->grid && holds; k++) {
        holds = rbti_within(values[k], 0.0, RBTI_MOST_NUMBER);
        if (axis->scale > 0.0)
            holds = holds && (k == 0 || values[k] > values[k - 1]);
        else
            holds = holds && values[k] == 0.0;
    }
    const double first = axis->offset, last = first + axis->nodes - 1.0;
    return holds && (axis->scale == 0.0 || (rbti_number_holds(axis, axis->first, first) &&
                                            rbti_number_holds(axis, axis->last, last)));
}

static int rbti_check_normals(const float *normals)
{
    for (int row = 0; row < 257; row++) {
        double sum = 0.0;
        for (int k = 0; k < 4; k++) {
            const double number = (double)normals[4 * row + k];
            RBTI_NEED(rbti_finite(number), RBT_ERR_INDICES);
            sum += fabs(number);
        }
        RBTI_NEED(sum <= 16.0, RBT_ERR_INDICES);
    }
    return RBT_OK;
}

static int rbti_check_classes(const rbt_table *table, size_t nodes)
{
    const size_t classes = (size_t)table->n_classes;
    for (size_t node = 0; node < nodes; node++) {
        const uint16_t *first = table->first_of_class + node * classes;
        RBTI_NEED(first[0] == 0, RBT_ERR_INDICES);
        for (size_t k = 0; k < classes; k++)
            RBTI_NEED(first[k] <= table->n_components && (k == 0 || first[k] >= first[k - 1]),
                      RBT_ERR_INDICES);
    }
    return RBT_OK;
}

static int rbti_check_components(const rbt_table *table, size_t components)
{
    for (size_t k = 0; k < components; k++) {
        const int16_t *record = table->components + k * (size_t)table->stride;
        RBTI_NEED(record[0] >= 0 && record[0] <= 4096, RBT_ERR_INDICES);
        const int16_t *diagonal = record + 1 + table->n_channels;
        for (int32_t left = table->n_channels; left > 0; left--) {
            RBTI_NEED(*diagonal > 0, RBT_ERR_INDICES);
            diagonal += left;
        }
    }
    return RBT_OK;
}

/* Every quantile within its bounds, which for v and the shares _hat are those of physics. */
static int rbti_check_spans(const rbt_table *table, size_t groups)
{
    static const double low[RBTI_CHANNELS] = RBTI_LEAST_QUANTILES;
    static const double high[RBTI_CHANNELS] = RBTI_MOST_QUANTILES;
    for (int32_t row = 0; row < table->n_channels; row++) {
        const int channel = table->channels[row];
        if (table->marginals[row] < 0)
            continue;
        for (size_t k = 0; k < groups; k++) {
            const double *span =
                table->spans + 2 * (k * (size_t)table->n_marginals + (size_t)table->marginals[row]);
            const double least = span[0], most = span[0] + span[1] * (65535.0 * (1.0 + 1e-6));
            RBTI_NEED(rbti_finite(least) && rbti_finite(span[1]) && rbti_finite(most) &&
                          span[1] >= 0.0 && low[channel] < least && most < high[channel],
                      RBT_ERR_INDICES);
        }
    }
    return RBT_OK;
}

static int rbti_check_quantiles(const rbt_table *table, size_t functions)
{
    const size_t numbers = 4 * (size_t)table->n_knots;
    for (size_t k = 0; k < functions; k++) {
        const uint16_t *steps = table->quantiles + k * numbers;
        unsigned falls = 0;
        for (size_t m = 4; m < numbers; m++)
            falls |= steps[m] < steps[m - 4];
        RBTI_NEED(!falls, RBT_ERR_INDICES);
    }
    return RBT_OK;
}

/* Shapes and laws of the ratios; a draw keeps ratios within their ends whatever the laws are. */
static int rbti_check_grains(const rbt_spin_law *law)
{
    double share = 0.0;
    for (int32_t k = 0; k < law->n_shapes; k++) {
        const double *ratios = law->shape_ratios + 2 * k;
        RBTI_NEED(law->shape_codes[k] >= 0, RBT_ERR_INDICES);
        RBTI_NEED(rbti_within(law->shape_shares[k], share, 1.0), RBT_ERR_INDICES);
        share = law->shape_shares[k];
        RBTI_NEED((ratios[0] == 0.0 && ratios[1] == 0.0) ||
                      (rbti_within(ratios[0], RBTI_LEAST_RATIO, 1.0) &&
                       rbti_within(ratios[1], RBTI_LEAST_RATIO, 1.0)),
                  RBT_ERR_INDICES);
    }
    for (int32_t k = 0; k < 2 * law->n_shapes && law->shape_inertia; k++)
        RBTI_NEED(law->shape_inertia[k] > 0.0 && law->shape_inertia[k] <= 1.0, RBT_ERR_INDICES);
    RBTI_NEED(share == 1.0, RBT_ERR_INDICES);
    for (int k = 0; k < 8; k += 4) {
        const double *of = law->aspect + k;
        RBTI_NEED(rbti_within(of[0], -100.0, 100.0) && rbti_within(of[1], 0.0, 100.0) &&
                      rbti_within(of[2], 0.0, 1.0) && rbti_within(of[3], of[2], 1.0),
                  RBT_ERR_INDICES);
    }
    return RBT_OK;
}

/* Every path through a tree goes on to later nodes, and so ends, in a leaf. */
static int rbti_check_trees(const rbt_spin_law *law)
{
    for (int32_t k = 0; k < law->n_shapes; k++)
        RBTI_NEED(law->roots[k] >= 0 && law->roots[k] < law->n_nodes, RBT_ERR_INDICES);
    for (int32_t k = 0; k < law->n_nodes; k++) {
        RBTI_NEED(law->node_axis[k] >= 0 && law->node_axis[k] <= RBTI_SQUARE, RBT_ERR_INDICES);
        RBTI_NEED(rbti_within(law->node_cut[k], -RBTI_MOST_CUT, RBTI_MOST_CUT), RBT_ERR_INDICES);
        for (int side = 0; side < 2; side++) {
            const int32_t child = law->node_child[2 * k + side];
            RBTI_NEED(child >= 0 ? child > k && child < law->n_nodes : child >= -law->n_leaves,
                      RBT_ERR_INDICES);
        }
    }
    return RBT_OK;
}

static int rbti_check_leaves(const rbt_spin_law *law)
{
    const size_t leaves = (size_t)law->n_leaves, outcomes = (size_t)law->n_outcomes;
    const size_t experts = leaves * RBTI_GROUPS * RBTI_GROUP_SIZE;
    for (size_t k = 0; k < leaves * RBTI_INPUTS; k++) {
        const float *of = law->inputs + k / RBTI_INPUTS * (2 * RBTI_INPUTS) + k % RBTI_INPUTS;
        RBTI_NEED(rbti_within((double)of[0], -RBTI_MOST_MIDDLE, RBTI_MOST_MIDDLE), RBT_ERR_INDICES);
        RBTI_NEED(rbti_within((double)of[RBTI_INPUTS], 0.0, RBTI_MOST_SCALE), RBT_ERR_INDICES);
    }
    for (size_t k = 0; k < experts; k++) {
        const int16_t *diagonal =
            law->experts + k * rbti_expert_stride(outcomes) + RBTI_FEATURES * outcomes;
        for (int left = law->n_outcomes; left > 0; left--) {
            RBTI_NEED(*diagonal > 0, RBT_ERR_INDICES);
            diagonal += left;
        }
    }
    return RBT_OK;
}

/* Every outcome within bounds; that of v is not negative, and from the second knot on so far above 0
   that no draw of v is rounded to it. */
static int rbti_check_outcomes(const rbt_spin_law *law, int less_spheres)
{
    const double bounds[2] = {RBTI_OUTCOME_BOUNDS}, slack = 1.0 + 1e-6;
    const size_t knots = (size_t)law->n_knots, outcomes = (size_t)law->n_outcomes;
    const size_t functions = (size_t)law->n_leaves * outcomes;
    for (size_t k = 0; k < functions; k++) {
        const double least = (double)law->spans[2 * k], step = (double)law->spans[2 * k + 1];
        const uint16_t *steps = law->quantiles + k * knots;
        const int of_v = !less_spheres && k % outcomes == 1;
        unsigned falls = 0;
        RBTI_NEED(rbti_within(least, of_v ? 0.0 : bounds[0], bounds[1]) &&
                      rbti_within(step, 0.0, bounds[1]) && least + step * 65535.0 <= bounds[1] * slack,
                  RBT_ERR_INDICES);
        RBTI_NEED(!of_v || least + step * (double)steps[1] >= RBTI_LEAST_V, RBT_ERR_INDICES);
        for (size_t m = 1; m < knots; m++)
            falls |= steps[m] < steps[m - 1];
        RBTI_NEED(!falls, RBT_ERR_INDICES);
    }
    return RBT_OK;
}

/* Whether numbers are a table over angles and at most so many speeds. */
static int rbti_is_table(const double *numbers, int count, double speeds)
{
    const double n = count < 2 ? 0.0 : numbers[0], m = count < 2 ? 0.0 : numbers[1];
    int holds = n >= 1.0 && m >= 1.0 && m <= speeds && floor(n) == n && floor(m) == m &&
                (double)count == 2.0 + n + m + n * m;
    for (int k = 3; holds && k < 2 + (int)n + (int)m; k++)
        holds = k == 2 + (int)n || numbers[k] > numbers[k - 1];
    return holds;
}

/* Laws of contact, of finite numbers. */
static int rbti_check_laws(const rbt_table *table)
{
    const double *law = table->laws;
    const int32_t count = table->n_laws;
    RBTI_NEED(count >= RBTI_NUMBERS, RBT_ERR_DIMENSIONS);
    for (int32_t k = 0; k < count; k++)
        RBTI_NEED(rbti_finite(law[k]), RBT_ERR_DIMENSIONS);
    RBTI_NEED(law[RBTI_RESOLUTION] > 0.0 && law[RBTI_RESOLUTION] <= RBTI_GRAZING &&
                  rbti_within(law[RBTI_RESTITUTION], RBTI_EXPONENTIAL, RBTI_TABULATED) &&
                  rbti_within(law[RBTI_RESISTANCE], RBTI_ORIENTATION, RBTI_COULOMB) &&
                  rbti_within(law[RBTI_LENGTH], 0.0, (double)(count - RBTI_NUMBERS)),
              RBT_ERR_DIMENSIONS);
    const int length = (int)law[RBTI_LENGTH], left = count - RBTI_NUMBERS - length;
    const int needed = (int)law[RBTI_RESISTANCE] == RBTI_TABULATED_RESISTANCE || left > 0;
    RBTI_NEED(((int)law[RBTI_RESTITUTION] != RBTI_TABULATED ||
               rbti_is_table(law + RBTI_NUMBERS, length, (double)length)) &&
                  (!needed || rbti_is_table(law + RBTI_NUMBERS + length, left, 1.0)),
              RBT_ERR_DIMENSIONS);
    return RBT_OK;
}

static int rbti_check_spin_law(const rbt_table *table)
{
    const rbt_spin_law *law = &table->spin;
    if (table->n_laws > 0)
        RBTI_CHECK(rbti_check_laws(table));
    RBTI_CHECK(rbti_check_spin_axes(law));
    RBTI_CHECK(rbti_check_grains(law));
    RBTI_CHECK(rbti_check_trees(law));
    RBTI_CHECK(rbti_check_leaves(law));
    return rbti_check_outcomes(law, table->n_laws > 0);
}

static int rbti_check_values(const rbt_table *table, const rbti_header *header)
{
    const size_t nodes = (size_t)rbti_nodes(header);
    const size_t components = nodes * header->n_components;
    const size_t groups = (size_t)rbti_cells(header) * header->n_classes;
    RBTI_NEED(rbti_coordinate_holds(&table->alpha), RBT_ERR_INDICES);
    RBTI_NEED(rbti_coordinate_holds(&table->speed), RBT_ERR_INDICES);
    RBTI_CHECK(rbti_check_normals(table->normals));
    for (size_t k = 0; k < components; k++)
        RBTI_NEED((table->alias[k] & 0xffffu) < header->n_components, RBT_ERR_INDICES);
    RBTI_CHECK(rbti_check_classes(table, nodes));
    RBTI_CHECK(rbti_check_components(table, components));
    RBTI_CHECK(rbti_check_spans(table, groups));
    RBTI_CHECK(rbti_check_quantiles(table, groups * header->n_marginals));
    return header->n_shapes > 0 ? rbti_check_spin_law(table) : RBT_OK;
}

#endif
