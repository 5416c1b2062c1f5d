/* rebound_device.h - draws and rebounds of arrays on a GPU, for CUDA and HIP.

   A program for a GPU says, in one file that its compiler for GPUs compiles,

       #define REBOUND_SAMPLER_IMPLEMENTATION
       #include "rebound_sampler.h"
       #include "rebound_device.h"

       rbt_table on_device;
       void *copy;
       int code = rbt_to_device(table, &on_device, &copy);   (a table from rbt_open)

   and then calls rbt_sample or rbt_rebound with &on_device in kernels of its own, one row at a time,
   which take on_device by value as RBT_TABLE_ARGUMENT, or launches the kernels below; rbt_device_free
   ends the copy. Compile with -fmad=false for the bits of the host.

   All arrays lie on the device. Their numbers are of type RBT_REAL, double unless it is defined as
   float before this file is included: then what is read and written takes half of the memory's time.
   The arithmetic is that of rbt_sample and rbt_rebound either way; results are rounded once.

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

/* -- draws and rebounds ---------------------------------------------------------------------------

   The kernels take n rows and fill codes[n]; rows with an error have what the host gives them. *flagged, 0
   before, becomes 1 if any code is not 0. Records are those of rbt_conditions and rbt_impacts, on the
   device. One row can stand for all: bit k of `single` says so of field k, counted from 0. */

typedef struct rbt_device_conditions {
    const RBT_REAL *alpha1, *speed, *spin, *inertia, *grain;
    const uint64_t *index;
    const uint32_t *hit;
    uint32_t single;
    int fresh;
} rbt_device_conditions;

typedef struct rbt_device_impacts {
    const RBT_REAL *velocity, *normal, *half_size, *wall_velocity, *omega, *inertia, *roughness,
        *grain;
    const uint64_t *index;
    const uint32_t *hit;
    uint32_t single;
    int fresh, isotropic;
} rbt_device_impacts;

/* Row of a field. */
RBTI_PART unsigned long long rbti_row(uint32_t single, unsigned field, unsigned long long k)
{
    return single >> field & 1 ? 0 : k;
}

/* Numbers of a row of an array, or NULL where there is none. */
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

/* Draw n rows from the spin law, or from that of first impacts. */
RBTI_PART void rbti_sample_rows(const rbt_table *table, unsigned long long n,
                                const rbt_device_conditions *of, int spins, uint64_t seed,
                                RBT_REAL *states, RBT_REAL *inertia, int *codes, int *flagged)
{
    const uint32_t one = of->single;
    RBT_EACH_ROW(k, n) {
        double alpha1, speed, spin[3], about = 0, grain[3], values[RBT_VALUES], after;
        rbti_grains grains = {(const double *)0, seed, of->fresh};
        rbti_load(of->alpha1, 1, rbti_row(one, 0, k), &alpha1);
        rbti_load(of->speed, 1, rbti_row(one, 1, k), &speed);
        if (spins)
            grains.given = rbti_load(of->grain, 3, rbti_row(one, 4, k), grain);
        rbti_load(of->inertia, 1, rbti_row(one, 3, k), &about);
        const double *given = spins ? rbti_load(of->spin, 3, rbti_row(one, 2, k), spin) : grains.given;
        codes[k] = rbti_draw_one(table, alpha1, speed, given, about, seed, &grains,
                                 of->index[rbti_row(one, 5, k)], of->hit[rbti_row(one, 6, k)],
                                 spins, RBT_VALUES, values, &after);
        after = codes[k] < RBT_OK ? rbti_nan() : after;
        rbti_store(&after, 1, k, inertia);
        for (int c = 0; c < table->n_columns; c++) {
            double value = values[0]; /* no place can be looked up in registers */
            for (int v = 1; v < RBT_VALUES; v++)
                value = table->columns[c] == v ? values[v] : value;
            states[(size_t)table->n_columns * k + (size_t)c] =
                (RBT_REAL)(codes[k] < RBT_OK ? rbti_nan() : value);
        }
        if (codes[k] != RBT_OK)
            *flagged = 1;
    }
}

/* Draw states of the table's columns from the law of first impacts; spin, inertia and grain are not
   read. `inertia`, for those after, may be NULL. */
RBT_KERNEL rbt_sample_kernel(RBT_TABLE_ARGUMENT table, unsigned long long n,
                             const rbt_device_conditions of, uint64_t seed, RBT_REAL *states,
                             RBT_REAL *inertia, int *codes, int *flagged)
{
    rbti_sample_rows(&table, n, &of, 0, seed, states, inertia, codes, flagged);
}

/* The same from the spin law; spin, inertia and grain may be NULL. */
RBT_KERNEL rbt_spin_sample_kernel(RBT_TABLE_ARGUMENT table, unsigned long long n,
                                  const rbt_device_conditions of, uint64_t seed, RBT_REAL *states,
                                  RBT_REAL *inertia, int *codes, int *flagged)
{
    rbti_sample_rows(&table, n, &of, 1, seed, states, inertia, codes, flagged);
}

/* Rebound particles; results may be the arrays of the impacts where no row stands for all, and `inertia`
   and `works` NULL. Where works are wanted of a table without, codes are RBT_ERR_NO_WORKS, and nothing
   else is written. */
RBT_KERNEL rbt_rebound_kernel(RBT_TABLE_ARGUMENT table, unsigned long long n,
                              const rbt_device_impacts of, uint64_t seed, RBT_REAL *velocity,
                              RBT_REAL *omega, RBT_REAL *inertia, RBT_REAL *works, int *codes,
                              int *flagged)
{
    const uint32_t one = of.single;
    RBT_EACH_ROW(k, n) {
        if (rbti_lacks_works(&table, works != (RBT_REAL *)0)) {
            codes[k] = RBT_ERR_NO_WORKS;
            *flagged = 1;
            continue;
        }
        double vectors[5][3], half_size, about, roughness, after[3], turning[3], moment, work[2];
        const uint64_t index = of.index[rbti_row(one, 8, k)];
        const uint32_t hit = of.hit[rbti_row(one, 9, k)];
        const rbt_impacts impact = {
            rbti_load(of.velocity, 3, rbti_row(one, 0, k), vectors[0]),
            rbti_load(of.normal, 3, rbti_row(one, 1, k), vectors[1]),
            rbti_load(of.half_size, 1, rbti_row(one, 2, k), &half_size),
            rbti_load(of.wall_velocity, 3, rbti_row(one, 3, k), vectors[2]),
            rbti_load(of.omega, 3, rbti_row(one, 4, k), vectors[3]),
            rbti_load(of.inertia, 1, rbti_row(one, 5, k), &about),
            rbti_load(of.roughness, 1, rbti_row(one, 6, k), &roughness),
            rbti_load(of.grain, 3, rbti_row(one, 7, k), vectors[4]),
            &index, &hit, of.fresh, of.isotropic};
        const rbt_rebounds out = {after, turning, &moment, works ? work : (double *)0, (int *)0,
                                  0, 0, {0}};
        codes[k] = rbti_rebound_row(&table, &impact, 0, seed, &out);
        rbti_store(after, 3, k, velocity);
        rbti_store(turning, 3, k, omega);
        rbti_store(&moment, 1, k, inertia);
        rbti_store(work, 2, k, works);
        if (codes[k] != RBT_OK)
            *flagged = 1;
    }
}

/* -- tables --------------------------------------------------------------------------------------- */

/* Table of an image that lies on the device, for programs that have no rbt_table (Python): its size,
   and the table behind it. One thread. */
typedef struct rbt_device_table {
    unsigned long long bytes;
    rbt_table table;
} rbt_device_table;

/* Kernels take 4096 bytes of arguments. */
static_assert(sizeof(rbt_device_table) <= 2048, "a table does not fit among the arguments");

RBT_KERNEL rbt_table_kernel(const void *image, unsigned long long size, rbt_device_table *out)
{
    out->bytes = sizeof out->table;
    out->table = rbt_unchecked(image, (size_t)size);
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

#endif

#endif /* REBOUND_DEVICE_H */
