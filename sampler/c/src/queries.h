/* -- queries ----------------------------------------------------------------------------------- */

RBT_API RBT_DEVICE void rbt_alpha_range(const rbt_table *table, double range[2])
{
    range[0] = table->alpha.first;
    range[1] = table->alpha.last;
}

RBT_API RBT_DEVICE void rbt_speed_range(const rbt_table *table, double range[2])
{
    range[0] = table->speed.first;
    range[1] = table->speed.last;
}

RBT_API RBT_DEVICE void rbt_valid_speed(const rbt_table *table, double range[2])
{
    range[0] = table->valid_speed[0];
    range[1] = table->valid_speed[1];
}

RBT_API RBT_DEVICE int rbt_has_spin_law(const rbt_table *table)
{
    return table->spin.n_shapes > 0;
}

RBT_API RBT_DEVICE void rbt_keep_grains(rbt_table *table, int kept)
{
    table->spin.fresh_grains = !kept;
}

RBT_API RBT_DEVICE int rbt_components(const rbt_table *table, int columns[RBT_VALUES])
{
    for (int k = 0; k < RBT_VALUES && columns; k++)
        columns[k] = k < RBTI_NAMES ? table->columns[k] : -1;
    return table->n_columns;
}

RBT_API RBT_DEVICE const char *rbt_pair(const rbt_table *table)
{
    return table->pair;
}

RBT_API RBT_DEVICE const void *rbt_image(const rbt_table *table, size_t *size)
{
    *size = table->image_size;
    return table->image;
}

RBT_API RBT_DEVICE rbt_table rbt_moved(const rbt_table *table, const void *copy)
{
    rbti_header header;
    rbt_table moved = *table;
    rbti_read_header(table->image, &header);
    rbti_point(&moved, &header, (const char *)copy);
    moved.to_free = moved.to_unmap = NULL;
    return moved;
}
