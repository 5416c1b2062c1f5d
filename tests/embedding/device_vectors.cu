/* Known-answer vectors through the kernels: device_vectors TABLE.rbt VECTORS.txt TOLERANCE

   vectors.c, whose draws and rebounds here are launches of one row. Compiled by nvcc it runs on a GPU,
   and by g++ with device_on_host.h in loops of the host. */

#define REBOUND_SAMPLER_IMPLEMENTATION
#include "rebound_sampler.h"
#include "rebound_device.h"

#include <cstdio>

/* Arguments and results of one row. */
struct row {
    double velocity[3], normal[3], half_size, wall[3], roughness, omega[3];
    double alpha1, speed, new_velocity[3], new_omega[3], values[RBT_VALUES];
    uint64_t index;
    uint32_t hit;
    rbt_device_report report;
};

static rbt_table on_device;
static void *table_copy, *row_copy;

/* A row on the device, beside the table, which is copied once. */
static row *put(const rbt_table *table, row *of)
{
    of->report = {~0ull, ~0ull, 0, 0};
    if (!table_copy && (rbt_to_device(table, &on_device, &table_copy) != RBT_OK ||
                        RBT_DEVICE_MALLOC(&row_copy, sizeof *of) != 0))
        std::exit(3);
    if (RBT_DEVICE_COPY(row_copy, of, sizeof *of) != 0)
        std::exit(3);
    return static_cast<row *>(row_copy);
}

/* The row back from the device, and the code of its launch. */
static int take(row *of)
{
    unsigned long long bad;
    if (RBT_DEVICE_COPY(of, row_copy, sizeof *of) != 0)
        std::exit(3);
    const int code = rbt_device_code(&of->report, 1, &bad);
    if (bad != (code < RBT_OK ? 0u : 1u) || (of->report.clamped > 0) != (code == RBT_CLAMPED))
        std::exit(4);
    return code;
}

static void copy_three(double *to, const double *from)
{
    for (int k = 0; k < 3; k++)
        to[k] = from[k];
}

static int draw_values(const rbt_table *table, double alpha1, double speed, const double *spin,
                       uint64_t seed, uint64_t index, uint32_t hit, int variables, double *values)
{
    row of = {};
    of.alpha1 = alpha1;
    of.speed = speed;
    of.index = index;
    of.hit = hit;
    if (spin)
        copy_three(of.omega, spin);
    row *there = put(table, &of);
    /* more threads than rows, of which the others have nothing to do */
    if (spin)
        RBT_LAUNCH(rbt_spin_draw_kernel, 2, 32, on_device, 1, 0u, &there->alpha1, &there->speed,
                   there->omega, seed, &there->index, &there->hit, there->values, &there->report);
    else
        RBT_LAUNCH(rbt_draw_kernel, 2, 32, on_device, 1, 0u, &there->alpha1, &there->speed, nullptr,
                   seed, &there->index, &there->hit, there->values, &there->report);
    const int code = take(&of);
    int columns[RBT_VALUES];
    const int n = rbt_components(table, columns);
    if (code >= RBT_OK && variables > 6) {
        /* kernels give the columns of a table; what else it has is that of the host */
        if (rbt_draw_all(table, alpha1, speed, seed, index, hit, values) != code)
            std::exit(4);
    } else if (code >= RBT_OK) {
        for (int k = 0; k < variables; k++)
            values[k] = 0.0;
    }
    for (int c = 0; c < n && code >= RBT_OK; c++)
        if (columns[c] < variables)
            values[columns[c]] = of.values[c];
    return code;
}

static int launch_draw(const rbt_table *table, double alpha1, double speed, const double *spin,
                       uint64_t seed, uint64_t index, uint32_t hit, double *state)
{
    return draw_values(table, alpha1, speed, spin, seed, index, hit, 6, state);
}

static int launch_draw_all(const rbt_table *table, double alpha1, double speed, uint64_t seed,
                           uint64_t index, uint32_t hit, double *values)
{
    return draw_values(table, alpha1, speed, nullptr, seed, index, hit, RBT_VALUES, values);
}

static int launch_rough_rebound(const rbt_table *table, const double *velocity,
                                const double *normal, double half_size, const double *wall,
                                double roughness, const double *omega, uint64_t seed,
                                uint64_t index, uint32_t hit, double *new_velocity,
                                double *new_omega, bool rough = true)
{
    row of = {};
    copy_three(of.velocity, velocity);
    copy_three(of.normal, normal);
    copy_three(of.wall, wall);
    of.half_size = half_size;
    of.roughness = roughness;
    of.index = index;
    of.hit = hit;
    if (omega)
        copy_three(of.omega, omega);
    copy_three(of.new_velocity, new_velocity);
    copy_three(of.new_omega, new_omega);
    row *there = put(table, &of);
    const auto kernel = rough ? rbt_rough_rebound_kernel
                              : (omega ? rbt_spin_rebound_kernel : rbt_rebound_kernel);
    RBT_LAUNCH(kernel, 1, 4, on_device, 1, 0u, there->velocity, there->normal, &there->half_size,
               there->wall, &there->roughness, omega ? there->omega : nullptr, seed, &there->index,
               &there->hit, there->new_velocity, there->new_omega, &there->report);
    const int code = take(&of);
    copy_three(new_velocity, of.new_velocity);
    copy_three(new_omega, of.new_omega);
    return code;
}

static int launch_rebound(const rbt_table *table, const double *velocity, const double *normal,
                          double half_size, const double *wall, const double *omega, uint64_t seed,
                          uint64_t index, uint32_t hit, double *new_velocity, double *new_omega)
{
    return launch_rough_rebound(table, velocity, normal, half_size, wall, 0.0, omega, seed, index,
                                hit, new_velocity, new_omega, false);
}

/* vectors.c gives batches of one row. */
static int launch_batch(const rbt_table *table, size_t, const rbt_impacts *of, uint64_t seed,
                        double *new_velocity, double *new_omega, rbt_report *)
{
    return launch_rough_rebound(table, of->velocity, of->normal, *of->half_size, of->wall_velocity,
                                of->roughness ? *of->roughness : 0.0, of->omega, seed, *of->index,
                                *of->hit, new_velocity, new_omega, of->roughness != nullptr);
}

#define rbt_draw launch_draw
#define rbt_draw_all launch_draw_all
#define rbt_rebound launch_rebound
#define rbt_rough_rebound launch_rough_rebound
#define rbt_rebound_batch launch_batch
#include "vectors.c"
