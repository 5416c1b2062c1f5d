/* -- reading a binary table, whose layout is in tables/FORMAT.md ---------------------------------- */

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
        n_channels, n_marginals, n_columns, stride, flags;
    int8_t channels[8], marginals[8], columns[8];
    int32_t alpha_offset, speed_offset;
    double alpha_first, alpha_last, alpha_origin, alpha_scale, speed_first, speed_last,
        speed_origin, speed_scale, variate_max;
    uint64_t at_alpha_coordinate, at_speed_coordinate, at_normals, at_alias, at_first_of_class,
        at_components, at_spans, at_quantiles;
    double valid_speed[2];
    uint32_t n_shapes, n_nodes, n_leaves, n_spin_knots;
    double spin_alpha[2], spin_speed[2], spin_coordinate[2], aspect[8];
    uint64_t at_shape_codes, at_shape_shares, at_shape_ratios, at_roots, at_node_axis,
        at_node_cut, at_node_child, at_inputs, at_spin_spans, at_spin_quantiles, at_group_gates,
        at_gates, at_experts;
    double least_inertia, spin_size[2];
    uint64_t at_shape_inertia, n_laws, at_laws;
} rbti_header;
/* end header */

/* begin checks */
#define RBTI_MAGIC "\211\122\102\124\015\012\032\012"
#define RBTI_MAJOR 1
#define RBTI_MOST_BYTES 0x80000000u
#define RBTI_SPEED_INDEPENDENT 1u
#define RBTI_OTHER_POPULATION 2u
#define RBTI_SPIN_WORKS 4u
#define RBTI_SPHERES 8u
#define RBTI_FIRST_MIRRORED 3
#define RBTI_END_MIRRORED 6
/* channels (bits) from which each variable is made */
#define RBTI_NEEDS {0x03, 0x01, 0x0b, 0x10, 0x20, 0x04, 0x4b, 0x80, 0x101, 0x14b}
#define RBTI_NORMAL_HAT 0x100u
#define RBTI_FIRST_HEADER_BYTES 432
/* least and largest value; see sampler/formats/bounds.py */
#define RBTI_ALPHA_BOUNDS 1.7453292519925846e-11, 1.5707963267964675
#define RBTI_SPEED_BOUNDS 1e-09, 1000000000.0
#define RBTI_ANY_SPEED_BOUNDS 1e-300, 1e+300
#define RBTI_ANY_SPIN_BOUNDS 0.0, 1e+150
#define RBTI_VARIATE_BOUNDS 0.001, 1000000.0
#define RBTI_SPIN_SPEED_BOUNDS 1e-09, 1000000000.0
#define RBTI_SPEED_COORDINATE_BOUNDS 1e-06, 1000.0
#define RBTI_OUTCOME_BOUNDS -1000000.0, 1000000.0
#define RBTI_MOST_NUMBER 1000000.0
#define RBTI_NUMBER_ROUNDING 0.02002
#define RBTI_MOST_SPEED_SCALE 1e+30
#define RBTI_LEAST_V 1e-15
#define RBTI_MOST_CUT 1000.0
#define RBTI_MOST_MIDDLE 1000.0f
#define RBTI_MOST_SCALE 10000.0f
/* ends of the open interval of the quantiles of each channel */
#define RBTI_LEAST_QUANTILES {0, -1, -1e+09, -1, -1e+09, -1e+09, 0, 0, 0}
#define RBTI_MOST_QUANTILES {1, 1, 1e+09, 1, 1e+09, 1e+09, 1, 1e+09, 1}
/* DO(dimension, least, most) */
#define RBTI_DIMENSIONS(DO)                                                                        \
    DO(n_alpha, 1, 65536)                                                                          \
    DO(n_speed, 1, 65536)                                                                          \
    DO(n_alpha_grid, 2, 16777216)                                                                  \
    DO(n_speed_grid, 2, 16777216)                                                                  \
    DO(n_knots, 2, 65536)                                                                          \
    DO(n_components, 1, 65536)                                                                     \
    DO(n_classes, 1, 65536)                                                                        \
    DO(n_channels, 1, 8)                                                                           \
    DO(n_marginals, 1, 8)                                                                          \
    DO(n_columns, 1, 8)
#define RBTI_SPIN_DIMENSIONS(DO)                                                                   \
    DO(n_shapes, 1, 1024)                                                                          \
    DO(n_nodes, 1, 1048576)                                                                        \
    DO(n_leaves, 1, 1048576)                                                                       \
    DO(n_spin_knots, 2, 4096)
/* DO(array, member of rbt_table, type, rows, numbers of a row, extra numbers) */
#define RBTI_ARRAYS(DO)                                                                            \
    DO(alpha_coordinate, alpha.coordinate, double, h->n_alpha_grid, 1, 0)                          \
    DO(speed_coordinate, speed.coordinate, double, h->n_speed_grid, 1, 0)                          \
    DO(normals, normals, float, 257, (uint64_t)4, 0)                                               \
    DO(alias, alias, uint32_t, rbti_nodes(h), (uint64_t)h->n_components, 0)                        \
    DO(first_of_class, first_of_class, uint16_t, rbti_nodes(h), (uint64_t)h->n_classes, 0)         \
    DO(components, components, int16_t, rbti_nodes(h), (uint64_t)h->n_components * h->stride, 8)   \
    DO(spans, spans, double, rbti_cells(h), (uint64_t)h->n_classes * h->n_marginals * 2, 0)        \
    DO(quantiles, quantiles, uint16_t, rbti_cells(h), (uint64_t)h->n_classes * h->n_marginals *    \
       h->n_knots * 4, 0)
#define RBTI_SPIN_ARRAYS(DO)                                                                       \
    DO(shape_codes, spin.shape_codes, int32_t, h->n_shapes, 1, 0)                                  \
    DO(shape_shares, spin.shape_shares, double, h->n_shapes, 1, 0)                                 \
    DO(shape_ratios, spin.shape_ratios, double, h->n_shapes, (uint64_t)2, 0)                       \
    DO(roots, spin.roots, int32_t, h->n_shapes, 1, 0)                                              \
    DO(node_axis, spin.node_axis, int8_t, h->n_nodes, 1, 0)                                        \
    DO(node_cut, spin.node_cut, double, h->n_nodes, 1, 0)                                          \
    DO(node_child, spin.node_child, int32_t, h->n_nodes, (uint64_t)2, 0)                           \
    DO(inputs, spin.inputs, float, h->n_leaves, (uint64_t)14, 0)                                   \
    DO(spin_spans, spin.spans, float, h->n_leaves, (uint64_t)rbti_outcomes(h) * 2, 0)              \
    DO(spin_quantiles, spin.quantiles, uint16_t, h->n_leaves, (uint64_t)rbti_outcomes(h) *         \
       h->n_spin_knots, 0)                                                                         \
    DO(group_gates, spin.group_gates, int16_t, h->n_leaves, (uint64_t)23 * 8, 0)                   \
    DO(gates, spin.gates, int16_t, h->n_leaves, (uint64_t)8 * 23 * 16, 0)                          \
    DO(experts, spin.experts, int16_t, h->n_leaves, (uint64_t)128 *                                \
       rbti_expert_stride(rbti_outcomes(h)), 8)
#define RBTI_INERTIA_ARRAYS(DO)                                                                    \
    DO(shape_inertia, spin.shape_inertia, double, h->n_shapes, (uint64_t)2, 0)
#define RBTI_LAW_ARRAYS(DO)                                                                        \
    DO(laws, laws, double, h->n_laws, 1, 0)
/* end checks */

/* End a function with a code where something does not hold. */
#define RBTI_NEED(holds, code)                                                                     \
    do {                                                                                           \
        if (!(holds))                                                                              \
            return (code);                                                                         \
    } while (0)

/* End a function with the code of a check that fails. */
#define RBTI_CHECK(check)                                                                          \
    do {                                                                                           \
        const int failed = (check);                                                                \
        if (failed != RBT_OK)                                                                      \
            return failed;                                                                         \
    } while (0)

/* Outcomes of the spin law. */
static RBT_DEVICE size_t rbti_outcomes(const rbti_header *header)
{
    return header->flags & RBTI_SPIN_WORKS ? RBTI_MOST_OUTCOMES : RBTI_OUTCOMES;
}

#ifndef RBT_DEVICE_ONLY

static uint64_t rbti_cells(const rbti_header *header)
{
    const uint64_t rows = header->n_alpha > 1 ? header->n_alpha - 1 : 1;
    return rows * (header->n_speed > 1 ? header->n_speed - 1 : 1);
}

static uint64_t rbti_nodes(const rbti_header *header)
{
    return (uint64_t)header->n_alpha * header->n_speed;
}

#endif
