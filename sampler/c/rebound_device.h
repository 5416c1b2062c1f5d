/* rebound_device.h - draws and rebounds on a GPU, for CUDA and HIP.

   In one file of your program, which the compiler for GPUs compiles, say

       #define REBOUND_SAMPLER_IMPLEMENTATION
       #include "rebound_sampler.h"
       #include "rebound_device.h"

   Then copy a table from rbt_open to the device:

       rbt_table device_table;
       void *copy;
       int code = rbt_to_device(table, &device_table, &copy);

   Kernels of your own take device_table by value, as RBT_TABLE_ARGUMENT, and call rbt_sample or rbt_rebound
   with its address for one row at a time; tracker.cu does this. Or launch the kernels for arrays below.
   rbt_device_free ends the copy. Compile with -fmad=false for the bits of the host.

   All arrays of the kernels lie on the device. Their numbers are of type RBT_REAL, which is double unless you
   define it as float before you include this file. With float, reading and writing take half of the time; the
   arithmetic is the same, and results are rounded once.

   Part of rebound-tables; MIT licence. */

#ifndef REBOUND_DEVICE_H
#define REBOUND_DEVICE_H

#ifndef REBOUND_SAMPLER_IMPLEMENTED
#error "include rebound_sampler.h first, with REBOUND_SAMPLER_IMPLEMENTATION defined"
#endif

#ifndef RBT_REAL
#define RBT_REAL double
#endif

/* How kernels are declared. */
#define RBT_KERNEL extern "C" __global__ void

/* Loop over the rows that a thread of a kernel takes. */
#define RBT_EACH_ROW(k, n)                                                                         \
    for (unsigned long long k = (unsigned long long)blockIdx.x * blockDim.x + threadIdx.x; k < n;  \
         k += (unsigned long long)gridDim.x * blockDim.x)

/* How kernels are launched. Tests define it as a loop of the host, to run the same sources without a GPU. */
#ifndef RBT_LAUNCH
#define RBT_LAUNCH(kernel, blocks, threads, ...) kernel<<<blocks, threads>>>(__VA_ARGS__)
#endif

/* How functions of kernels are declared. */
#define RBTI_PART static inline __device__

/* A table as the argument of a kernel. Without __grid_constant__, which nvcc and NVRTC know, each thread would
   keep a copy of it. */
#if defined(__NVCC__) || defined(__CUDACC_RTC__)
#define RBT_TABLE_ARGUMENT const __grid_constant__ rbt_table
#else
#define RBT_TABLE_ARGUMENT const rbt_table
#endif

/* -- draws and rebounds ---------------------------------------------------------------------------

   Kernels for n rows. They fill codes[n]; rows with an error get what the host gives them. *flagged, which is
   0 before, becomes 1 if any code is not 0.

   The records have the fields of rbt_conditions and rbt_impacts, with arrays on the device. An array may have
   one row that holds for all particles: set bit k of `single` for field k, counted from 0. */

/* begin records */
enum { RBTI_CONDITIONS_ALPHA1, RBTI_CONDITIONS_SPEED, RBTI_CONDITIONS_SPIN,
       RBTI_CONDITIONS_INERTIA, RBTI_CONDITIONS_GRAIN, RBTI_CONDITIONS_INDEX,
       RBTI_CONDITIONS_HIT };
typedef struct rbt_device_conditions {
    const RBT_REAL *alpha1, *speed, *spin, *inertia, *grain;
    const uint64_t *index;
    const uint32_t *hit;
    uint32_t single;
    int fresh;
} rbt_device_conditions;

enum { RBTI_IMPACTS_VELOCITY, RBTI_IMPACTS_NORMAL, RBTI_IMPACTS_HALF_SIZE,
       RBTI_IMPACTS_WALL_VELOCITY, RBTI_IMPACTS_OMEGA, RBTI_IMPACTS_INERTIA,
       RBTI_IMPACTS_ROUGHNESS, RBTI_IMPACTS_GRAIN, RBTI_IMPACTS_INDEX, RBTI_IMPACTS_HIT };
typedef struct rbt_device_impacts {
    const RBT_REAL *velocity, *normal, *half_size, *wall_velocity, *omega, *inertia, *roughness,
        *grain;
    const uint64_t *index;
    const uint32_t *hit;
    uint32_t single;
    int fresh, isotropic;
} rbt_device_impacts;
/* end records */

/* Row of an array for particle k. */
#define RBTI_ROW(ARRAY) (single >> RBTI_##ARRAY & 1 ? 0 : k)

/* Read the numbers of a row. Returns them, or NULL if there is no array. */
RBTI_PART const double *rbti_load(const RBT_REAL *array, unsigned width, unsigned long long row,
                                  double *numbers)
{
    for (unsigned c = 0; c < width && array; c++)
        numbers[c] = (double)array[width * row + c];
    return array ? numbers : (const double *)0;
}

/* Write a row of an array, if there is one. */
RBTI_PART void rbti_store(const double *numbers, unsigned width, unsigned long long row,
                          RBT_REAL *array)
{
    for (unsigned c = 0; c < width && array; c++)
        array[width * row + c] = (RBT_REAL)numbers[c];
}

/* Draw n rows from the spin law if `spins`, else from the law of first impacts. */
RBTI_PART void rbti_sample_rows(const rbt_table *table, unsigned long long n,
                                const rbt_device_conditions *conditions, int spins, uint64_t seed,
                                RBT_REAL *states, RBT_REAL *inertia_after, int *codes, int *flagged)
{
    const uint32_t single = conditions->single;
    RBT_EACH_ROW(k, n) {
        double alpha1 = 0, speed = 0, inertia = 0, after = 0;
        double spin[3], grain[3], values[RBT_VALUES];
        rbti_grains grains = {(const double *)0, seed, conditions->fresh};
        rbti_load(conditions->alpha1, 1, RBTI_ROW(CONDITIONS_ALPHA1), &alpha1);
        rbti_load(conditions->speed, 1, RBTI_ROW(CONDITIONS_SPEED), &speed);
        rbti_load(conditions->inertia, 1, RBTI_ROW(CONDITIONS_INERTIA), &inertia);
        const double *spin_or_null = (const double *)0;
        if (spins) {
            spin_or_null = rbti_load(conditions->spin, 3, RBTI_ROW(CONDITIONS_SPIN), spin);
            grains.prescribed =
                rbti_load(conditions->grain, 3, RBTI_ROW(CONDITIONS_GRAIN), grain);
        }
        codes[k] = rbti_draw_one(table, alpha1, speed, spin_or_null, inertia, seed, &grains,
                                 conditions->index[RBTI_ROW(CONDITIONS_INDEX)],
                                 conditions->hit[RBTI_ROW(CONDITIONS_HIT)], spins, RBT_VALUES,
                                 values, &after);
        after = codes[k] < RBT_OK ? rbti_nan() : after;
        rbti_store(&after, 1, k, inertia_after);
        for (int c = 0; c < table->n_columns; c++) {
            double value = values[0]; /* compared and not indexed, so that values stay in registers */
            for (int v = 1; v < RBT_VALUES; v++)
                value = table->columns[c] == v ? values[v] : value;
            states[(size_t)table->n_columns * k + (size_t)c] =
                (RBT_REAL)(codes[k] < RBT_OK ? rbti_nan() : value);
        }
        if (codes[k] != RBT_OK)
            *flagged = 1;
    }
}

/* Draw states, the table's columns, from the law of first impacts. `spin`, `inertia` and `grain` of the
   conditions are not read. `inertia_after` may be NULL. */
RBT_KERNEL rbt_sample_kernel(RBT_TABLE_ARGUMENT table, unsigned long long n,
                             const rbt_device_conditions conditions, uint64_t seed, RBT_REAL *states,
                             RBT_REAL *inertia_after, int *codes, int *flagged)
{
    rbti_sample_rows(&table, n, &conditions, 0, seed, states, inertia_after, codes, flagged);
}

/* Draw states from the spin law. `spin`, `inertia` and `grain` of the conditions may be NULL. */
RBT_KERNEL rbt_spin_sample_kernel(RBT_TABLE_ARGUMENT table, unsigned long long n,
                                  const rbt_device_conditions conditions, uint64_t seed,
                                  RBT_REAL *states, RBT_REAL *inertia_after, int *codes, int *flagged)
{
    rbti_sample_rows(&table, n, &conditions, 1, seed, states, inertia_after, codes, flagged);
}

/* Rebound particles. `inertia` and `works` may be NULL. Results may be the arrays of the impacts unless one
   row holds for all. If works are asked for and the table has none, all codes are RBT_ERR_NO_WORKS and nothing
   else is written. */
RBT_KERNEL rbt_rebound_kernel(RBT_TABLE_ARGUMENT table, unsigned long long n,
                              const rbt_device_impacts impacts, uint64_t seed, RBT_REAL *velocity,
                              RBT_REAL *omega, RBT_REAL *inertia, RBT_REAL *works, int *codes,
                              int *flagged)
{
    const uint32_t single = impacts.single;
    RBT_EACH_ROW(k, n) {
        if (rbti_lacks_works(&table, works != (RBT_REAL *)0)) {
            codes[k] = RBT_ERR_NO_WORKS;
            *flagged = 1;
            continue;
        }
        double v[3], normal[3], wall_velocity[3], spin[3], grain[3];
        double half_size, k_before, roughness;
        double new_v[3], new_omega[3], new_inertia, work[2];
        const uint64_t index = impacts.index[RBTI_ROW(IMPACTS_INDEX)];
        const uint32_t hit = impacts.hit[RBTI_ROW(IMPACTS_HIT)];
        rbt_impacts impact = {};
        impact.velocity = rbti_load(impacts.velocity, 3, RBTI_ROW(IMPACTS_VELOCITY), v);
        impact.normal = rbti_load(impacts.normal, 3, RBTI_ROW(IMPACTS_NORMAL), normal);
        impact.half_size = rbti_load(impacts.half_size, 1, RBTI_ROW(IMPACTS_HALF_SIZE), &half_size);
        impact.wall_velocity =
            rbti_load(impacts.wall_velocity, 3, RBTI_ROW(IMPACTS_WALL_VELOCITY), wall_velocity);
        impact.omega = rbti_load(impacts.omega, 3, RBTI_ROW(IMPACTS_OMEGA), spin);
        impact.inertia = rbti_load(impacts.inertia, 1, RBTI_ROW(IMPACTS_INERTIA), &k_before);
        impact.roughness = rbti_load(impacts.roughness, 1, RBTI_ROW(IMPACTS_ROUGHNESS), &roughness);
        impact.grain = rbti_load(impacts.grain, 3, RBTI_ROW(IMPACTS_GRAIN), grain);
        impact.index = &index;
        impact.hit = &hit;
        impact.fresh = impacts.fresh;
        impact.isotropic = impacts.isotropic;
        rbt_rebounds after = {};
        after.velocity = new_v;
        after.omega = new_omega;
        after.inertia = &new_inertia;
        after.works = works ? work : (double *)0;
        codes[k] = rbti_rebound_row(&table, &impact, 0, seed, &after);
        rbti_store(new_v, 3, k, velocity);
        rbti_store(new_omega, 3, k, omega);
        rbti_store(&new_inertia, 1, k, inertia);
        rbti_store(work, 2, k, works);
        if (codes[k] != RBT_OK)
            *flagged = 1;
    }
}

/* -- tables --------------------------------------------------------------------------------------- */

/* Table of an image that lies on the device, for programs without rbt_open, as Python. Launch the kernel with
   one thread; it writes the size of a table, and the table. */
typedef struct rbt_device_table {
    unsigned long long bytes;
    rbt_table table;
} rbt_device_table;

/* Kernels take 4096 bytes of arguments, and a table is one of several. */
static_assert(sizeof(rbt_device_table) <= 2048, "a table does not fit among the arguments");

RBT_KERNEL rbt_table_kernel(const void *image, unsigned long long size, rbt_device_table *out)
{
    out->bytes = sizeof out->table;
    out->table = rbt_unchecked(image, (size_t)size);
}

#ifndef RBT_DEVICE_ONLY

/* Functions of CUDA or HIP for memory of the device. They return 0 if all is well. */
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

/* Copy a table to the device. *copy becomes the block of memory there, which belongs to the caller, who ends
   it with rbt_device_free; *device_table is for kernels, by value. The table of the host may be closed
   afterwards. RBT_OK, or RBT_ERR_NO_MEMORY if the device refuses. */
static inline int rbt_to_device(const rbt_table *table, rbt_table *device_table, void **copy)
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
    *device_table = rbt_moved(table, *copy);
    return RBT_OK;
}

/* Free the copy of a table. NULL is allowed. */
static inline void rbt_device_free(void *copy)
{
    if (copy)
        (void)RBT_DEVICE_FREE(copy);
}

#endif

#endif /* REBOUND_DEVICE_H */
