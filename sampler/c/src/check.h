/* -- checks of a binary table ----------------------------------------------------------------------

   Only the structure is checked: no draw from a table that is accepted reads outside its image. The
   numbers were checked by Python when it made the file. */

#ifndef RBT_DEVICE_ONLY

/* Check the beginning of a file and read its header: byte order, format, version, size. */
static int rbti_check_start(const char *image, size_t size, rbti_header *header)
{
    const uint32_t one = 1;
    uint8_t least;
    memcpy(&least, &one, 1);
    RBTI_REQUIRE(least == 1, RBT_ERR_BIG_ENDIAN);
    RBTI_REQUIRE(size >= 8 && memcmp(image, RBTI_MAGIC, 8) == 0, RBT_ERR_FORMAT);
    const size_t needed = offsetof(rbti_header, file_bytes);
    RBTI_REQUIRE(size >= needed, RBT_ERR_SIZE);
    memcpy(header, image, needed);
    RBTI_REQUIRE(header->major == RBTI_MAJOR, RBT_ERR_VERSION);
    RBTI_REQUIRE(size >= sizeof *header && size < RBTI_MOST_BYTES, RBT_ERR_SIZE);
    memcpy(header, image, sizeof *header);
    RBTI_REQUIRE(header->file_bytes == size, RBT_ERR_SIZE);
    RBTI_REQUIRE(header->header_bytes >= sizeof *header, RBT_ERR_VERSION);
    RBTI_REQUIRE(header->header_bytes <= size, RBT_ERR_SIZE);
    return RBT_OK;
}

/* Check the SHA-256 of a file, which covers everything but itself. */
static int rbti_check_sum(const char *image, size_t size, const rbti_header *header)
{
    const size_t at = offsetof(rbti_header, sha256);
    uint8_t digest[32];
    const uint8_t *bytes = (const uint8_t *)image;
    rbti_sha256(bytes, at, bytes + at + 32, size - at - 32, digest);
    return memcmp(digest, header->sha256, 32) == 0 ? RBT_OK : RBT_ERR_CHECKSUM;
}

/* Check the dimensions of arrays. A table has nodes, and may have a spin law; or it is one of spheres,
   with laws of contact, which a spin law may have too. The dimensions of what it lacks are 0. */
static int rbti_check_dimensions(const rbti_header *h)
{
    const int nodes = (h->flags & RBTI_SPHERES) == 0, law = h->n_leaves > 0;
    const int spheres = !nodes || h->n_law_parameters > 0, grains = law || !nodes;
#define RBTI_DO(there, name, least, most)                                                          \
    RBTI_REQUIRE(there ? h->name >= least && h->name <= most : h->name == 0, RBT_ERR_DIMENSIONS);
    RBTI_DIMENSIONS(RBTI_DO)
#undef RBTI_DO
    RBTI_REQUIRE(nodes ? law || !spheres : !law, RBT_ERR_DIMENSIONS);
    const uint32_t features = law ? RBTI_FEATURES : 0, experts = law ? RBTI_GROUPS * RBTI_GROUP_SIZE : 0;
    RBTI_REQUIRE(h->n_features == features && h->n_experts == experts, RBT_ERR_VERSION);
    const uint32_t needed = 1 + h->n_channels + h->n_channels * (h->n_channels + 1) / 2;
    uint32_t stride = 1;
    while (stride < needed)
        stride *= 2;
    RBTI_REQUIRE(!nodes || h->stride == stride, RBT_ERR_DIMENSIONS);
    return RBT_OK;
}

/* Whether n names are below a number and different, and followed by -1 only. */
static int rbti_names_are_valid(const int8_t names[RBTI_NAMES], uint32_t n, int known)
{
    int seen = 0, holds = 1;
    for (uint32_t k = 0; k < RBTI_NAMES; k++) {
        const int is_name = names[k] >= 0 && names[k] < known && !(seen >> names[k] & 1);
        holds &= k < n ? is_name : names[k] == -1;
        seen |= is_name ? 1 << names[k] : 0;
    }
    return holds;
}

static int rbti_check_names(const rbti_header *h)
{
    uint32_t marginals = 0;
    RBTI_REQUIRE(rbti_names_are_valid(h->channels, h->n_channels, RBTI_CHANNELS), RBT_ERR_NAMES);
    RBTI_REQUIRE(rbti_names_are_valid(h->columns, h->n_columns, RBT_VALUES), RBT_ERR_NAMES);
    for (uint32_t k = 0; k < RBTI_NAMES; k++)
        if (h->marginals[k] != -1) {
            RBTI_REQUIRE(k < h->n_channels && h->marginals[k] == (int)marginals, RBT_ERR_NAMES);
            marginals++;
        }
    RBTI_REQUIRE(marginals == h->n_marginals, RBT_ERR_NAMES);
    return RBT_OK;
}

/* Whether an array fits into the file: its offset is aligned, and its rows of numbers and the extra
   numbers behind them end within the file. Rows and numbers are below 2^38 each; the quotients are
   rounded down, so that no product overflows. */
static int rbti_array_fits(const rbti_header *h, uint64_t at, uint64_t rows, uint64_t numbers,
                           uint64_t extra, uint64_t bytes)
{
    if (at % 64 != 0 || at < h->header_bytes || at > h->file_bytes)
        return 0;
    const uint64_t room = (h->file_bytes - at) / bytes;
    return extra <= room && rows <= (room - extra) / numbers;
}

/* Check that every array lies within the file. */
static int rbti_check_offsets(const rbti_header *h)
{
#define RBTI_DO(name, member, type, count, rows, numbers, extra)                                   \
    RBTI_REQUIRE(count == 0 ||                                                                     \
                     rbti_array_fits(h, h->at_##name, rows, numbers, extra, sizeof(type)),         \
                 RBT_ERR_OFFSETS);
    RBTI_ARRAYS(RBTI_DO)
#undef RBTI_DO
    return RBT_OK;
}

/* Whether the coordinates of an axis are numbers of nodes. */
static int rbti_axis_is_valid(const rbt_axis *axis)
{
    int holds = axis->offset >= 0 && axis->offset <= (int32_t)RBTI_MOST_NUMBER;
    for (int32_t k = 0; k < axis->grid; k++)
        holds &= axis->coordinate[k] >= 0.0 && axis->coordinate[k] <= RBTI_MOST_NUMBER;
    return holds;
}

/* Whether the alias tables name components that exist, and classes begin at such. */
static int rbti_components_are_valid(const rbt_table *table, uint64_t nodes)
{
    const uint64_t components = (uint64_t)table->n_components, classes = (uint64_t)table->n_classes;
    int holds = 1;
    for (uint64_t k = 0; k < nodes * components; k++)
        holds &= (table->alias[k] & 0xffffu) < components;
    for (uint64_t k = 0; k < nodes * classes; k++)
        holds &= table->first_of_class[k] <= components;
    return holds;
}

/* Whether every path through a tree ends in a leaf: it does if children come after their parents. */
static int rbti_trees_are_valid(const rbt_spin_law *law, int32_t n_shapes)
{
    int holds = 1;
    for (int32_t k = 0; k < n_shapes && law->roots; k++)
        holds &= law->roots[k] >= 0 && law->roots[k] < law->n_nodes;
    for (int32_t k = 0; k < 2 * law->n_nodes; k++) {
        const int32_t child = law->node_child[k];
        holds &= law->node_axis[k / 2] >= 0 && law->node_axis[k / 2] < RBTI_IN_ROWS;
        holds &= child >= 0 ? child > k / 2 && child < law->n_nodes : child >= -law->n_leaves;
    }
    return holds;
}

/* Whether numbers are a table over angles and at most `speeds` speeds, as sphere.h reads it. */
static int rbti_is_table(const double *numbers, int32_t count, double speeds)
{
    const double n = count < 2 ? 0.0 : numbers[0], m = count < 2 ? 0.0 : numbers[1];
    return n >= 1.0 && m >= 1.0 && m <= speeds && floor(n) == n && floor(m) == m &&
           (double)count == 2.0 + n + m + n * m;
}

/* Whether the laws of contact of spheres are known laws, and their tables are whole. */
static int rbti_laws_are_valid(const double *law, int32_t count)
{
    if (!(law[RBTI_RESTITUTION] >= 0.0 && law[RBTI_RESTITUTION] < (double)RBTI_RESTITUTION_LAWS &&
          law[RBTI_RESISTANCE] >= 0.0 && law[RBTI_RESISTANCE] < (double)RBTI_RESISTANCE_LAWS &&
          law[RBTI_LENGTH] >= 0.0 && law[RBTI_LENGTH] <= (double)(count - RBTI_NUMBERS)))
        return 0;
    const int length = (int)law[RBTI_LENGTH];
    const int n_behind = count - RBTI_NUMBERS - length;
    const int needed = (int)law[RBTI_RESISTANCE] == RBTI_RESISTANCE_TABULATED ||
                       n_behind > 0;
    return ((int)law[RBTI_RESTITUTION] != RBTI_RESTITUTION_TABULATED ||
            rbti_is_table(law + RBTI_NUMBERS, length, (double)length)) &&
           (!needed || rbti_is_table(law + RBTI_NUMBERS + length, n_behind, 1.0));
}

/* Whether both laws are tables, as those are by which ellipsoids are drawn. */
static int rbti_laws_are_tables(const double *law)
{
    return (int)law[RBTI_RESTITUTION] == RBTI_RESTITUTION_TABULATED &&
           (int)law[RBTI_RESISTANCE] == RBTI_RESISTANCE_TABULATED;
}

/* Check everything that a draw uses as an index. */
static int rbti_check_indices(const rbt_table *table, const rbti_header *h)
{
    RBTI_REQUIRE(rbti_axis_is_valid(&table->alpha) && rbti_axis_is_valid(&table->speed),
                 RBT_ERR_INDICES);
    RBTI_REQUIRE(rbti_components_are_valid(table, rbti_nodes(h)), RBT_ERR_INDICES);
    RBTI_REQUIRE(rbti_trees_are_valid(&table->spin, table->population.n_shapes), RBT_ERR_INDICES);
    RBTI_REQUIRE(!table->laws || rbti_laws_are_valid(table->laws, table->n_law_parameters),
                 RBT_ERR_INDICES);
    RBTI_REQUIRE(!table->laws || table->spheres || rbti_laws_are_tables(table->laws),
                 RBT_ERR_INDICES);
    return RBT_OK;
}

#endif
