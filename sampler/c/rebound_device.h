/* rebound_device.h - draws and rebounds of arrays on a GPU, for CUDA and HIP.

   A program for a GPU says, in one file that its compiler for GPUs compiles,

       #define REBOUND_SAMPLER_IMPLEMENTATION
       #include "rebound_sampler.h"
       #include "rebound_device.h"

       rbt_table on_device;
       void *copy;
       int code = rbt_to_device(table, &on_device, &copy);   (a table from rbt_open)

   and then calls rbt_draw, rbt_rebound or rbt_rough_rebound with &on_device in kernels of its own,
   which take on_device by value as RBT_TABLE_ARGUMENT, or launches the kernels below; rbt_device_free
   ends the copy. Compile with -fmad=false for the bits of the host.

   All arrays lie on the device. Their numbers are of type RBT_REAL, double unless it is defined as
   float before this file is included: then what is read and written takes half of the memory's time.
   The arithmetic is that of rbt_draw and rbt_rebound either way; results are rounded to RBT_REAL once.

   Part of rebound-tables; MIT licence. */

#ifndef REBOUND_DEVICE_H
#define REBOUND_DEVICE_H

#ifndef REBOUND_SAMPLER_IMPLEMENTED
#error "include rebound_sampler.h first, with REBOUND_SAMPLER_IMPLEMENTATION defined"
#endif

#ifndef RBT_REAL
#define RBT_REAL double
#endif

/* How a kernel is declared, and the rows that one of its threads takes. */
#define RBT_KERNEL extern "C" __global__ void
#define RBT_EACH_ROW(k, n)                                                                         \
    for (unsigned long long k = (unsigned long long)blockIdx.x * blockDim.x + threadIdx.x; k < n;  \
         k += (unsigned long long)gridDim.x * blockDim.x)

/* How a kernel is launched: defined elsewhere to run the same sources in loops of the host, for
   tests. */
#ifndef RBT_LAUNCH
#define RBT_LAUNCH(kernel, blocks, threads, ...) kernel<<<blocks, threads>>>(__VA_ARGS__)
#endif

/* A part of a kernel. */
#define RBTI_PART static inline __device__

/* A table as the argument of a kernel. Without the word of CUDA, which nvcc and NVRTC know, each thread
   would keep a copy of it. */
#if defined(__NVCC__) || defined(__CUDACC_RTC__)
#define RBT_TABLE_ARGUMENT const __grid_constant__ rbt_table
#else
#define RBT_TABLE_ARGUMENT const rbt_table
#endif

/* What the threads of a launch report together. Set all bits of bad and clamped_row, and no other,
   before the first; rbt_device_code tells the result. */
typedef struct rbt_device_report {
    unsigned long long bad;          /* first row with an error, times 256, less its code */
    unsigned long long clamped_row;  /* first clamped row */
    unsigned long long clamped;      /* number of clamped rows */
    unsigned long long extrapolated; /* number of rows with RBT_EXTRAPOLATED */
} rbt_device_report;

/* Arguments of which one row stands for all: bits of `single`. */
#define RBT_ONE_VELOCITY 1u
#define RBT_ONE_NORMAL 2u
#define RBT_ONE_HALF_SIZE 4u
#define RBT_ONE_WALL_VELOCITY 8u
#define RBT_ONE_ROUGHNESS 16u
#define RBT_ONE_OMEGA 32u
#define RBT_ONE_ALPHA1 1u
#define RBT_ONE_SPEED 2u
#define RBT_ONE_SPIN 32u
#define RBT_ONE_INDEX 64u
#define RBT_ONE_HIT 128u
#define RBT_ISOTROPIC 256u /* no argument: facets are tilted across the plane of incidence as well */

/* Row of an argument. */
RBTI_PART unsigned long long rbti_row(uint32_t single, uint32_t bit, unsigned long long k)
{
    return single & bit ? 0 : k;
}

/* Vector in a row. */
RBTI_PART void rbti_vector(const RBT_REAL *array, unsigned long long row, double vector[3])
{
    for (unsigned k = 0; k < 3; k++)
        vector[k] = (double)array[3 * row + k];
}

/* Count a row in what one thread has found. */
RBTI_PART void rbti_count_row(int code, unsigned long long row, rbt_device_report *found)
{
    if (code < RBT_OK) {
        const unsigned long long bad = row * 256u + (unsigned)-code;
        found->bad = bad < found->bad ? bad : found->bad;
        return;
    }
    if (code & RBT_CLAMPED) {
        found->clamped_row = row < found->clamped_row ? row : found->clamped_row;
        found->clamped++;
    }
    found->extrapolated += (code & RBT_EXTRAPOLATED) != 0;
}

/* Add what one thread has found; mostly there is nothing. */
RBTI_PART void rbti_add_to_report(const rbt_device_report *found, rbt_device_report *report)
{
    if (found->bad != ~0ull)
        atomicMin(&report->bad, found->bad);
    if (found->clamped > 0) {
        atomicMin(&report->clamped_row, found->clamped_row);
        atomicAdd(&report->clamped, found->clamped);
    }
    if (found->extrapolated > 0)
        atomicAdd(&report->extrapolated, found->extrapolated);
}

/* -- draws ---------------------------------------------------------------------------------------- */

/* Parameters of the kernels of draws, behind the table: those of rbt_draw_batch, and
   states[n_columns * n], of which a row has the table's columns in their order. Rows with an error are
   not written. */
#define RBTI_DRAW_PARAMETERS                                                                       \
    unsigned long long n, uint32_t single, const RBT_REAL *alpha1, const RBT_REAL *speed,          \
        const RBT_REAL *spin, uint64_t seed, const uint64_t *index, const uint32_t *hit,           \
        RBT_REAL *states, rbt_device_report *report

/* One row of a launch: the code. */
RBTI_PART int rbti_draw_row(const rbt_table *table, double alpha1, double speed,
                            const RBT_REAL *spin, unsigned long long spin_row, uint64_t seed,
                            uint64_t index, uint32_t hit, RBT_REAL *states)
{
    double values[RBT_VALUES], vector[3];
    if (spin)
        rbti_vector(spin, spin_row, vector);
    const int code = rbt_draw_all(table, alpha1, speed, spin ? vector : NULL, NULL, seed, index,
                                  hit, values);
    for (int c = 0; c < table->n_columns && code >= RBT_OK; c++) {
        double value = values[0]; /* no place can be looked up in registers */
        for (int k = 1; k < RBT_VALUES; k++)
            value = table->columns[c] == k ? values[k] : value;
        states[c] = (RBT_REAL)value;
    }
    return code;
}

RBTI_PART void rbti_draw_rows(const rbt_table *table, RBTI_DRAW_PARAMETERS)
{
    rbt_device_report found = {~0ull, ~0ull, 0, 0};
    RBT_EACH_ROW(k, n) {
        const int code = rbti_draw_row(
            table, (double)alpha1[rbti_row(single, RBT_ONE_ALPHA1, k)],
            (double)speed[rbti_row(single, RBT_ONE_SPEED, k)], spin,
            rbti_row(single, RBT_ONE_SPIN, k), seed, index[rbti_row(single, RBT_ONE_INDEX, k)],
            hit[rbti_row(single, RBT_ONE_HIT, k)], states + (size_t)table->n_columns * k);
        rbti_count_row(code, k, &found);
    }
    rbti_add_to_report(&found, report);
}

/* Draws from the law of first impacts; `spin` is not read. */
RBT_KERNEL rbt_draw_kernel(RBT_TABLE_ARGUMENT table, RBTI_DRAW_PARAMETERS)
{
    (void)spin;
    rbti_draw_rows(&table, n, single, alpha1, speed, (const RBT_REAL *)0, seed, index, hit, states,
                   report);
}

/* Draws from the spin law; spin[3 * n] is there. */
RBT_KERNEL rbt_spin_draw_kernel(RBT_TABLE_ARGUMENT table, RBTI_DRAW_PARAMETERS)
{
    rbti_draw_rows(&table, n, single, alpha1, speed, spin, seed, index, hit, states, report);
}

/* -- rebounds ------------------------------------------------------------------------------------- */

/* Parameters of the kernels of rebounds, behind the table: those of rbt_rebound_batch. wall_velocity
   may be NULL. Rows with an error are not written; new_velocity may be velocity, and new_omega omega,
   where no row of theirs stands for all. */
#define RBTI_REBOUND_PARAMETERS                                                                    \
    unsigned long long n, uint32_t single, const RBT_REAL *velocity, const RBT_REAL *normal,       \
        const RBT_REAL *half_size, const RBT_REAL *wall_velocity, const RBT_REAL *roughness,       \
        const RBT_REAL *omega, uint64_t seed, const uint64_t *index, const uint32_t *hit,          \
        RBT_REAL *new_velocity, RBT_REAL *new_omega, rbt_device_report *report

/* Impact of one row, and the keys of its random numbers. */
typedef struct rbti_device_impact {
    double velocity[3], normal[3], wall[3], omega[3], half_size, roughness;
    uint64_t seed, index;
    uint32_t hit;
    int isotropic;
} rbti_device_impact;

/* Rebound one row: the code. */
RBTI_PART int rbti_rebound_row(const rbt_table *table, const rbti_device_impact *of, int rough,
                               int spins, unsigned long long k, RBT_REAL *new_velocity,
                               RBT_REAL *new_omega)
{
    double v[3], turning[3];
    const double *omega = spins ? of->omega : (const double *)0;
    const int code =
        rough ? rbt_rebound_grain(table, of->velocity, of->normal, of->half_size, of->wall,
                                  of->roughness, of->isotropic, omega, (const double *)0, of->seed,
                                  of->index, of->hit, v, turning)
              : rbt_rebound(table, of->velocity, of->normal, of->half_size, of->wall, omega,
                            of->seed, of->index, of->hit, v, turning);
    for (unsigned c = 0; c < 3 && code >= RBT_OK; c++) {
        new_velocity[3 * k + c] = (RBT_REAL)v[c];
        new_omega[3 * k + c] = (RBT_REAL)turning[c];
    }
    return code;
}

RBTI_PART void rbti_rebound_rows(const rbt_table *table, RBTI_REBOUND_PARAMETERS)
{
    rbt_device_report found = {~0ull, ~0ull, 0, 0};
    RBT_EACH_ROW(k, n) {
        rbti_device_impact of;
        rbti_vector(velocity, rbti_row(single, RBT_ONE_VELOCITY, k), of.velocity);
        rbti_vector(normal, rbti_row(single, RBT_ONE_NORMAL, k), of.normal);
        of.half_size = (double)half_size[rbti_row(single, RBT_ONE_HALF_SIZE, k)];
        of.wall[0] = of.wall[1] = of.wall[2] = 0.0;
        if (wall_velocity)
            rbti_vector(wall_velocity, rbti_row(single, RBT_ONE_WALL_VELOCITY, k), of.wall);
        if (roughness)
            of.roughness = (double)roughness[rbti_row(single, RBT_ONE_ROUGHNESS, k)];
        if (omega)
            rbti_vector(omega, rbti_row(single, RBT_ONE_OMEGA, k), of.omega);
        of.isotropic = (single & RBT_ISOTROPIC) != 0;
        of.seed = seed;
        of.index = index[rbti_row(single, RBT_ONE_INDEX, k)];
        of.hit = hit[rbti_row(single, RBT_ONE_HIT, k)];
        const int code = rbti_rebound_row(table, &of, roughness != (const RBT_REAL *)0,
                                          omega != (const RBT_REAL *)0, k, new_velocity, new_omega);
        rbti_count_row(code, k, &found);
    }
    rbti_add_to_report(&found, report);
}

/* Rebounds from smooth walls; `roughness` is not read, and omega may be NULL. */
RBT_KERNEL rbt_rebound_kernel(RBT_TABLE_ARGUMENT table, RBTI_REBOUND_PARAMETERS)
{
    (void)roughness;
    rbti_rebound_rows(&table, n, single, velocity, normal, half_size, wall_velocity,
                      (const RBT_REAL *)0, omega, seed, index, hit, new_velocity, new_omega, report);
}

/* Rebounds from rough walls, roughness[n]; omega may be NULL. */
RBT_KERNEL rbt_rough_rebound_kernel(RBT_TABLE_ARGUMENT table, RBTI_REBOUND_PARAMETERS)
{
    rbti_rebound_rows(&table, n, single, velocity, normal, half_size, wall_velocity, roughness,
                      omega, seed, index, hit, new_velocity, new_omega, report);
}

/* -- tables --------------------------------------------------------------------------------------- */

/* Table of an image that lies on the device, for programs that have no rbt_table (Python): its size,
   and the table behind it. One thread; `kept` as in rbt_keep_grains. */
typedef struct rbt_device_table {
    unsigned long long bytes;
    rbt_table table;
} rbt_device_table;

/* Kernels take 4096 bytes of arguments. */
static_assert(sizeof(rbt_device_table) <= 2048, "a table does not fit among the arguments");

RBT_KERNEL rbt_table_kernel(const void *image, unsigned long long size, int kept,
                            rbt_device_table *out)
{
    rbt_table table = rbt_unchecked(image, (size_t)size);
    rbt_keep_grains(&table, kept);
    out->bytes = sizeof table;
    out->table = table;
}

#ifndef RBT_DEVICE_ONLY

/* Memory of the device: functions of CUDA or HIP that return 0 if all is well. */
#ifndef RBT_DEVICE_MALLOC
#if defined(__CUDACC__)
#define RBT_DEVICE_MALLOC(pointer, size) ((int)cudaMalloc(pointer, size))
#define RBT_DEVICE_COPY(to, from, size) ((int)cudaMemcpy(to, from, size, cudaMemcpyDefault))
#define RBT_DEVICE_FREE(pointer) ((int)cudaFree(pointer))
#else
#define RBT_DEVICE_MALLOC(pointer, size) ((int)hipMalloc(pointer, size))
#define RBT_DEVICE_COPY(to, from, size) ((int)hipMemcpy(to, from, size, hipMemcpyDefault))
#define RBT_DEVICE_FREE(pointer) ((int)hipFree(pointer))
#endif
#endif

/* Copy a table to the device, as one block of memory that nothing writes. *copy is that block, which
   the caller ends with rbt_device_free; *on_device is to be passed to kernels by value. The table of
   the host may be closed afterwards. RBT_OK, or RBT_ERR_NO_MEMORY if the device refuses. */
static inline int rbt_to_device(const rbt_table *table, rbt_table *on_device, void **copy)
{
    size_t size;
    const void *image = rbt_image(table, &size);
    *copy = (void *)0;
    if (RBT_DEVICE_MALLOC(copy, size) != 0)
        return RBT_ERR_NO_MEMORY;
    if (RBT_DEVICE_COPY(*copy, image, size) != 0) {
        (void)RBT_DEVICE_FREE(*copy);
        *copy = (void *)0;
        return RBT_ERR_NO_MEMORY;
    }
    *on_device = rbt_moved(table, *copy);
    return RBT_OK;
}

/* End the copy of a table; NULL is allowed. */
static inline void rbt_device_free(void *copy)
{
    if (copy)
        (void)RBT_DEVICE_FREE(copy);
}

/* What a launch of n rows says, as rbt_draw_batch would: RBT_OK, flags, or the code of the first
   row with an error, and its number in *row (else n). The report was copied to the host. Unlike in a
   batch, rows behind one with an error are done, and counted. */
static inline int rbt_device_code(const rbt_device_report *report, unsigned long long n,
                                  unsigned long long *row)
{
    *row = report->bad == ~0ull ? n : report->bad / 256u;
    if (report->bad != ~0ull)
        return -(int)(report->bad % 256u);
    return (report->clamped > 0) * RBT_CLAMPED | (report->extrapolated > 0) * RBT_EXTRAPOLATED;
}

#endif

#endif /* REBOUND_DEVICE_H */
