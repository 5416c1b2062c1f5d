/* -- reading a binary table ------------------------------------------------------------------------

   A table (rbt_table) is made from the header of a file, and its arrays point into the image of the file:
   nothing is copied. */

/* Fill an axis from numbers of the header. */
static RBT_DEVICE void rbti_fill_axis(rbt_axis *axis, const double ends_origin_scale[4],
                                      int32_t offset, uint32_t nodes, uint32_t grid)
{
    axis->first = ends_origin_scale[0];
    axis->last = ends_origin_scale[1];
    axis->low = axis->first;
    axis->high = axis->last;
    axis->origin = ends_origin_scale[2];
    axis->scale = ends_origin_scale[3];
    axis->offset = offset;
    axis->nodes = (int32_t)nodes;
    axis->grid = (int32_t)grid;
}

/* Fill the numbers of the spin law. Without one they are 0. */
static RBT_DEVICE void rbti_fill_spin_law(rbt_spin_law *law, const rbti_header *h)
{
    law->n_nodes = (int32_t)h->n_nodes;
    law->n_leaves = (int32_t)h->n_leaves;
    law->n_knots = (int32_t)h->n_spin_knots;
    law->n_outcomes = (int32_t)h->n_outcomes;
    law->alpha_first = h->spin_alpha[0];
    law->alpha_last = h->spin_alpha[1];
    law->speed_first = law->speed_low = h->spin_speed[0];
    law->speed_last = law->speed_high = h->spin_speed[1];
    law->speed_scale = h->spin_coordinate[0];
    law->speed_exponent = h->spin_coordinate[1];
    law->least_spin = h->spin_size[0] * h->spin_size[0];
    law->most_spin = h->spin_size[1] * h->spin_size[1];
}

/* Fill the numbers of a table, whose fields are 0. */
static RBT_DEVICE void rbti_fill_table(rbt_table *table, const rbti_header *h)
{
    const double alpha[4] = {h->alpha_first, h->alpha_last, h->alpha_origin, h->alpha_scale};
    const double speed[4] = {h->speed_first, h->speed_last, h->speed_origin, h->speed_scale};
    rbti_fill_axis(&table->alpha, alpha, h->alpha_offset, h->n_alpha, h->n_alpha_grid);
    rbti_fill_axis(&table->speed, speed, h->speed_offset, h->n_speed, h->n_speed_grid);
    table->spheres = (h->flags & RBTI_SPHERES) != 0;
    table->n_law_parameters = (int32_t)h->n_law_parameters;
    table->variate_max = h->variate_max;
    if (!table->spheres)
        table->variate_scale = ((double)h->n_knots - 1.0) / (2.0 * h->variate_max);
    table->n_knots = (int32_t)h->n_knots;
    table->n_components = (int32_t)h->n_components;
    table->n_classes = (int32_t)h->n_classes;
    table->n_channels = (int32_t)h->n_channels;
    table->n_marginals = (int32_t)h->n_marginals;
    table->n_columns = (int32_t)h->n_columns;
    table->stride = (int32_t)h->stride;
    memcpy(table->channels, h->channels, sizeof table->channels);
    memcpy(table->marginals, h->marginals, sizeof table->marginals);
    memcpy(table->columns, h->columns, sizeof table->columns);
    table->plain = h->n_columns == 6;
    for (uint32_t k = 0; k < h->n_columns; k++) {
        table->variable_bits |= 1u << h->columns[k];
        table->plain = table->plain && h->columns[k] == (int)k;
    }
    memcpy(table->valid_speed, h->valid_speed, sizeof table->valid_speed);
    table->least_inertia = h->least_inertia;
    table->population.n_shapes = (int32_t)h->n_shapes;
    memcpy(table->population.aspect, h->aspect, sizeof h->aspect);
    rbti_fill_spin_law(&table->spin, h);
    if (table->spheres || h->flags & RBTI_SPEED_INDEPENDENT) { /* any speed that is positive and finite */
        table->speed.low = table->spin.speed_low = RBTI_LEAST_ANY_SPEED;
        table->speed.high = table->spin.speed_high = RBTI_MOST_ANY_SPEED;
    }
    if (table->spheres) { /* any angle and spin */
        table->alpha.low = table->spin.alpha_first = RBTI_LEAST_ANGLE;
        table->alpha.high = table->spin.alpha_last = RBTI_HALF_PI;
        table->spin.most_spin = RBTI_MOST_ANY_SPEED;
    }
    for (uint32_t row = 0; row < RBTI_NAMES; row++) {
        const int channel = h->channels[row];
        const int mirrored = channel >= RBTI_FIRST_MIRRORED && channel < RBTI_END_MIRRORED;
        table->mirrored[row] = (int8_t)mirrored;
    }
    memcpy(table->pair, h->pair, sizeof table->pair);
    table->pair[sizeof table->pair - 1] = 0;
}

/* Bind the arrays of a table to an image at some address. Arrays that the table lacks are NULL. */
static RBT_DEVICE void rbti_bind_arrays(rbt_table *table, const rbti_header *h, const char *image)
{
    table->image = image;
#define RBTI_DO(name, member, type, count, rows, numbers, extra)                                   \
    table->member = count == 0 ? NULL : (const type *)(const void *)(image + h->at_##name);
    RBTI_ARRAYS(RBTI_DO)
#undef RBTI_DO
}

RBT_API RBT_DEVICE rbt_table rbt_unchecked(const void *image, size_t size)
{
    rbti_header header;
    rbt_table table;
    memset(&table, 0, sizeof table);
    memcpy(&header, image, sizeof header);
    rbti_fill_table(&table, &header);
    rbti_bind_arrays(&table, &header, (const char *)image);
    table.image_size = size;
    return table;
}

#ifndef RBT_DEVICE_ONLY

/* Check an image, and its checksum if it has one, and fill a table from it. */
static int rbti_read(const char *image, size_t size, int has_checksum, rbt_table *table)
{
    rbti_header header;
    memset(table, 0, sizeof *table);
    RBTI_CHECK(rbti_check_start(image, size, &header));
    if (has_checksum)
        RBTI_CHECK(rbti_check_sum(image, size, &header));
    RBTI_CHECK(rbti_check_dimensions(&header));
    RBTI_CHECK(rbti_check_names(&header));
    RBTI_CHECK(rbti_check_offsets(&header));
    table->image_size = size;
    rbti_fill_table(table, &header);
    rbti_bind_arrays(table, &header, image);
    return rbti_check_indices(table, &header);
}

/* Make a table on the heap from an image. */
static int rbti_open(const void *image, size_t size, int has_checksum, rbt_table **table)
{
    RBTI_REQUIRE(table, RBT_ERR_MISSING);
    *table = NULL;
    RBTI_REQUIRE(image, RBT_ERR_MISSING);
    RBTI_REQUIRE((uintptr_t)image % 64 == 0, RBT_ERR_OFFSETS);
    rbt_table *opened = (rbt_table *)RBT_MALLOC(sizeof *opened);
    RBTI_REQUIRE(opened, RBT_ERR_NO_MEMORY);
    const int code = rbti_read((const char *)image, size, has_checksum, opened);
    if (code == RBT_OK)
        *table = opened;
    else
        RBT_FREE(opened);
    return code;
}

RBT_API int rbt_open_memory(const void *image, size_t size, rbt_table **table)
{
    return rbti_open(image, size, 1, table);
}
