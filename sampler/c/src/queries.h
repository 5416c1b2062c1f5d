/* -- what a table has and covers ------------------------------------------------------------------

   Speeds are in m/s, angles in rad, spins in V/a. */

RBT_API RBT_DEVICE int rbt_covered(const rbt_table *table, rbt_range *range)
{
    if (!table || !range)
        return RBT_ERR_MISSING;
    memset(range, 0, sizeof *range);
    range->alpha1[0] = table->alpha.low;
    range->alpha1[1] = table->alpha.high;
    range->speed[0] = table->speed.low;
    range->speed[1] = table->speed.high;
    if (table->population.n_shapes > 0) {
        range->spin[0] = sqrt(table->spin.least_spin);
        range->spin[1] = sqrt(table->spin.most_spin);
    }
    memcpy(range->measured, table->valid_speed, sizeof range->measured);
    return RBT_OK;
}

RBT_API RBT_DEVICE double rbt_highest_speed(const rbt_table *table)
{
    return table && table->speed.high < RBTI_MOST_ANY_SPEED ? table->speed.high : 0.0;
}

RBT_API RBT_DEVICE int rbt_has_spin_law(const rbt_table *table)
{
    return table && table->population.n_shapes > 0;
}

RBT_API RBT_DEVICE int rbt_variables(const rbt_table *table, int columns[RBT_VALUES])
{
    for (int k = 0; k < RBT_VALUES && columns && table; k++)
        columns[k] = k < RBTI_NAMES ? table->columns[k] : -1;
    return table ? table->n_columns : 0;
}

RBT_API RBT_DEVICE int rbt_has_variable(const rbt_table *table, int variable)
{
    return table && variable >= 0 && variable < RBT_VALUES && rbti_has_variable(table, variable);
}

RBT_API RBT_DEVICE const char *rbt_pair(const rbt_table *table)
{
    return table ? table->pair : "";
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
    memcpy(&header, table->image, sizeof header);
    rbti_bind_arrays(&moved, &header, (const char *)copy);
    moved.to_free = moved.to_unmap = NULL;
    return moved;
}
