/* -- the layout of a binary table ------------------------------------------------------------------

   The header of the file, its limits, and its arrays; tables/FORMAT.md describes them, and
   sampler/formats/binary_layout.py defines them. All numbers are little-endian. */

/* The header of the file. */
/* begin header */
typedef struct rbti_header {
    char magic[8];
    uint16_t major, minor;
    uint32_t header_bytes;
    uint64_t file_bytes;
    uint8_t sha256[32], content_sha256[32];
    char pair[128];
    uint32_t n_alpha, n_speed, n_alpha_grid, n_speed_grid, n_knots, n_components, n_classes,
        n_channels, n_marginals, stride, n_columns, n_shapes, n_nodes, n_leaves, n_spin_knots,
        n_outcomes, n_features, n_experts, n_law_parameters, flags;
    int8_t channels[8], marginals[8], columns[8];
    int32_t alpha_offset, speed_offset;
    double alpha_first, alpha_last, alpha_origin, alpha_scale, speed_first, speed_last,
        speed_origin, speed_scale, valid_speed[2], least_inertia, variate_max, spin_alpha[2],
        spin_speed[2], spin_size[2], spin_coordinate[2], aspect[8];
    uint64_t at_alpha_coordinate, at_speed_coordinate, at_normals, at_alias, at_first_of_class,
        at_components, at_spans, at_quantiles, at_shape_codes, at_shape_shares, at_shape_ratios,
        at_ratio_range, at_shape_geometry, at_shape_inertia, at_kappa_quantiles, at_roots,
        at_node_axis, at_node_cut, at_node_child, at_inputs, at_spin_spans, at_spin_quantiles,
        at_group_gates, at_gates, at_experts, at_laws;
} rbti_header;
/* end header */

/* begin checks */
#define RBTI_MAGIC "\211\122\102\124\015\012\032\012"
#define RBTI_MAJOR 1
#define RBTI_MOST_BYTES 0x80000000u
#define RBTI_SPEED_INDEPENDENT 1u
#define RBTI_SPHERES 2u
#define RBTI_FIRST_MIRRORED 3
#define RBTI_END_MIRRORED 6
#define RBTI_LEAST_ANY_SPEED 1e-300
#define RBTI_MOST_ANY_SPEED 1e+300
#define RBTI_MOST_NUMBER 1000000.0 /* of a node */
/* DO(what has it, dimension, least, most) */
#define RBTI_DIMENSIONS(DO)                                                                        \
    DO(nodes, n_alpha, 1, 65536)                                                                   \
    DO(nodes, n_speed, 1, 65536)                                                                   \
    DO(nodes, n_alpha_grid, 2, 16777216)                                                           \
    DO(nodes, n_speed_grid, 2, 16777216)                                                           \
    DO(nodes, n_knots, 2, 65536)                                                                   \
    DO(nodes, n_components, 1, 65536)                                                              \
    DO(nodes, n_classes, 1, 65536)                                                                 \
    DO(nodes, n_channels, 1, 8)                                                                    \
    DO(nodes, n_marginals, 1, 8)                                                                   \
    DO(grains, n_shapes, 1, 1024)                                                                  \
    DO(law, n_nodes, 1, 1048576)                                                                   \
    DO(law, n_leaves, 1, 1048576)                                                                  \
    DO(law, n_spin_knots, 2, 4096)                                                                 \
    DO(law, n_outcomes, 7, 8)                                                                      \
    DO(spheres, n_law_parameters, 8, 1048576)                                                      \
    DO(1, n_columns, 1, 8)
/* DO(array, member of rbt_table, type, count that is 0 without it, rows, numbers of a
   row, extra numbers) */
#define RBTI_ARRAYS(DO)                                                                            \
    DO(alpha_coordinate, alpha.coordinate, double, h->n_alpha, h->n_alpha_grid, 1, 0)              \
    DO(speed_coordinate, speed.coordinate, double, h->n_alpha, h->n_speed_grid, 1, 0)              \
    DO(normals, normals, float, h->n_alpha, 257, (uint64_t)4, 0)                                   \
    DO(alias, alias, uint32_t, h->n_alpha, rbti_nodes(h), (uint64_t)h->n_components, 0)            \
    DO(first_of_class, first_of_class, uint16_t, h->n_alpha, rbti_nodes(h),                        \
       (uint64_t)h->n_classes, 0)                                                                  \
    DO(components, components, int16_t, h->n_alpha, rbti_nodes(h), (uint64_t)h->n_components *     \
       h->stride, 8)                                                                               \
    DO(spans, spans, double, h->n_alpha, rbti_cells(h), (uint64_t)h->n_classes * h->n_marginals *  \
       2, 0)                                                                                       \
    DO(quantiles, quantiles, uint16_t, h->n_alpha, rbti_cells(h), (uint64_t)h->n_classes *         \
       h->n_marginals * h->n_knots * 4, 0)                                                         \
    DO(shape_codes, population.shape_codes, int32_t, h->n_shapes, h->n_shapes, 1, 0)               \
    DO(shape_shares, population.shape_shares, double, h->n_shapes, h->n_shapes, 1, 0)              \
    DO(shape_ratios, population.shape_ratios, double, h->n_shapes, h->n_shapes, (uint64_t)2, 0)    \
    DO(ratio_range, population.ratio_range, double, h->n_shapes, h->n_shapes, (uint64_t)2 * 2, 0)  \
    DO(shape_geometry, population.shape_geometry, double, h->n_shapes, h->n_shapes, (uint64_t)4,   \
       0)                                                                                          \
    DO(shape_inertia, population.shape_inertia, double, h->n_leaves, h->n_shapes, (uint64_t)2, 0)  \
    DO(kappa_quantiles, spin.kappa_quantiles, double, h->n_leaves, h->n_shapes, (uint64_t)33, 0)   \
    DO(roots, spin.roots, int32_t, h->n_leaves, h->n_shapes, 1, 0)                                 \
    DO(node_axis, spin.node_axis, int8_t, h->n_leaves, h->n_nodes, 1, 0)                           \
    DO(node_cut, spin.node_cut, double, h->n_leaves, h->n_nodes, 1, 0)                             \
    DO(node_child, spin.node_child, int32_t, h->n_leaves, h->n_nodes, (uint64_t)2, 0)              \
    DO(inputs, spin.inputs, float, h->n_leaves, h->n_leaves, (uint64_t)18, 0)                      \
    DO(spin_spans, spin.spans, float, h->n_leaves, h->n_leaves, (uint64_t)h->n_outcomes * 2, 0)    \
    DO(spin_quantiles, spin.quantiles, uint16_t, h->n_leaves, h->n_leaves, (uint64_t)h->n_outcomes \
       * h->n_spin_knots, 0)                                                                       \
    DO(group_gates, spin.group_gates, int16_t, h->n_leaves, h->n_leaves, (uint64_t)59 * 8, 0)      \
    DO(gates, spin.gates, int16_t, h->n_leaves, h->n_leaves, (uint64_t)8 * 59 * 8, 0)              \
    DO(experts, spin.experts, int16_t, h->n_leaves, h->n_leaves, (uint64_t)64 *                    \
       rbti_expert_stride(h->n_outcomes), 8)                                                       \
    DO(laws, laws, double, h->n_law_parameters, h->n_law_parameters, 1, 0)
/* end checks */

/* Return a code from a function if something does not hold. */
#define RBTI_REQUIRE(holds, code)                                                                     \
    do {                                                                                           \
        if (!(holds))                                                                              \
            return (code);                                                                         \
    } while (0)

/* Return the code of a check that fails. */
#define RBTI_CHECK(check)                                                                          \
    do {                                                                                           \
        const int failed = (check);                                                                \
        if (failed != RBT_OK)                                                                      \
            return failed;                                                                         \
    } while (0)

#ifndef RBT_DEVICE_ONLY

/* Number of nodes of a table. */
static uint64_t rbti_nodes(const rbti_header *header)
{
    return (uint64_t)header->n_alpha * header->n_speed;
}

/* Number of cells between nodes. An axis of one node has one cell. */
static uint64_t rbti_cells(const rbti_header *header)
{
    const uint64_t rows = header->n_alpha > 1 ? header->n_alpha - 1 : 1;
    return rows * (header->n_speed > 1 ? header->n_speed - 1 : 1);
}

#endif
