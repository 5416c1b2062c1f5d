/* rebound_sampler.h - rebounds of non-spherical particles, drawn from a table, in C.

   One file of one C program or library says

       #define REBOUND_SAMPLER_IMPLEMENTATION
       #include "rebound_sampler.h"

   and any others include the header alone. C99, C++11 or later, or CUDA; needs libc and libm.

       rbt_table *table;
       int code = rbt_open("corundum-steel.rbt", &table);
       if (code < 0) { fprintf(stderr, "%s\n", rbt_strerror(code)); exit(1); }
       double state[6];
       code = rbt_draw(table, 0.5, 150.0, seed, particle, hits, state);
       rbt_close(table);

   The file is what `sampler export T.h5 --output T.rbt` writes. Equal arguments give the states
   that the Python package gives, with the same bits whatever the compiler flags and the processor,
   and rebounds to the last digits of the C library's atan2, cos and sin; but with
   -ffast-math, clang's -ffp-contract=fast, and on CUDA devices without -fmad=false, the same to
   rounding in single precision.

   Angles are in radians, everything else in SI units. A state is u, v, w over V and omega_x,
   omega_y, omega_z times a/V (V: impact speed, a: largest half-size of the particle) in the frame
   of the impact: x along the tangential velocity before impact, y along the wall normal into the
   gas. Components that a table leaves out are 0.

   Threads: a table is never written after it was opened, and a draw is a pure function of its
   arguments that allocates nothing. Any number of threads may use one table at once; rbt_open and
   rbt_close of one table must not run beside other calls with it.

   Return values: 0 is fine, positive is fine with a remark, negative is an error with nothing
   written. Nothing is printed. RBT_CLAMPED, the one remark, says that angle or speed lay outside
   the table, and that its nearest condition was drawn: count these codes (a batch counts them in
   rbt_report.clamped) and tell your user at the first, as examples/ do. A table of a law that does
   not depend on the speed covers every speed.

   Part of rebound-tables; MIT licence. */

#ifndef REBOUND_SAMPLER_H
#define REBOUND_SAMPLER_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Functions that may be called on a device too; empty but in CUDA. */
#ifndef RBT_DEVICE
#if defined(__CUDACC__)
#define RBT_DEVICE __host__ __device__
#else
#define RBT_DEVICE
#endif
#endif

/* How functions are declared; define as `static` to keep them within one file. */
#ifndef RBT_API
#define RBT_API extern
#endif

/* Draws. */
#define RBT_OK 0
#define RBT_CLAMPED 1                 /* outside the table: its nearest condition was used */
#define RBT_NOT_FINITE (-1)           /* an argument is NaN or infinite, or a speed overflows */
#define RBT_NOT_APPROACHING (-2)      /* alpha1 outside (0, pi/2], or velocity off the wall */
#define RBT_SPEED_NOT_POSITIVE (-3)   /* speed <= 0, or velocity equal to the wall's */
#define RBT_NORMAL_NOT_USABLE (-4)    /* normal of length zero */
#define RBT_HALF_SIZE_NOT_POSITIVE (-5)

/* Files. rbt_strerror says more. */
#define RBT_NOT_OPENED (-10)
#define RBT_NOT_READ (-11)
#define RBT_NO_MEMORY (-12)
#define RBT_BIG_ENDIAN (-13)
#define RBT_FORMAT (-14)
#define RBT_VERSION (-15)
#define RBT_SIZE (-16)
#define RBT_CHECKSUM (-17)
#define RBT_DIMENSIONS (-18)
#define RBT_NAMES (-19)
#define RBT_OFFSETS (-20)
#define RBT_AXES (-21)
#define RBT_COORDINATES (-22)
#define RBT_NORMALS (-23)
#define RBT_ALIAS (-24)
#define RBT_CLASSES (-25)
#define RBT_COMPONENTS (-26)
#define RBT_SPANS (-27)
#define RBT_QUANTILES (-28)

/* Most components that a state can have: u, v, w, omega_x, omega_y, omega_z, rotational energy over
   the initial kinetic energy, number of collisions. */
#define RBT_VALUES 8

/* A table in memory. Its fields are for the functions below. */
typedef struct rbt_table rbt_table;

/* Open a table image and check everything in it, its checksum included.

   The file is mapped where the system can do that, and read otherwise. It must not be changed while
   it is open (`sampler export` puts a new file in its place, which is safe). On success *table
   belongs to the caller, who ends it with rbt_close. On an error *table is NULL. */
RBT_API int rbt_open(const char *path, rbt_table **table);

/* The same for an image in memory, at an address that is a multiple of 64. The bytes stay the
   caller's, and must not change or go before rbt_close. */
RBT_API int rbt_open_memory(const void *image, size_t size, rbt_table **table);

/* End a table; NULL is allowed. */
RBT_API void rbt_close(rbt_table *table);

/* One line on a return code; a constant string, never NULL. */
RBT_API const char *rbt_strerror(int code);

/* Range of the table: impact angles in rad, impact speeds in m/s; {smallest, largest}. */
RBT_API void rbt_alpha_range(const rbt_table *table, double range[2]);
RBT_API void rbt_speed_range(const rbt_table *table, double range[2]);

/* Components that the table gives: how many, and which (0: u, ... 7: number of collisions). Others
   are 0 in every state. `columns` may be NULL. */
RBT_API int rbt_components(const rbt_table *table, int columns[RBT_VALUES]);

/* Name of the material pair, UTF-8; lives as long as the table. */
RBT_API const char *rbt_pair(const rbt_table *table);

/* Draw one state.

   alpha1: impact angle from the wall, in (0, pi/2]. speed: impact speed V > 0. (seed, index, hit):
   seed of the run, identity of the particle, and how many walls it has met before; they select the
   random numbers.

   RBT_OK, RBT_CLAMPED, or RBT_NOT_FINITE, RBT_NOT_APPROACHING, RBT_SPEED_NOT_POSITIVE. */
RBT_API RBT_DEVICE int rbt_draw(const rbt_table *table, double alpha1, double speed, uint64_t seed,
                                uint64_t index, uint32_t hit, double state[6]);

/* The same with all components that a table can have. */
RBT_API RBT_DEVICE int rbt_draw_all(const rbt_table *table, double alpha1, double speed,
                                    uint64_t seed, uint64_t index, uint32_t hit,
                                    double values[RBT_VALUES]);

/* What a batch reports. Rows count from 0; `row` and `clamped_row` are the number of rows if there
   is none. */
typedef struct rbt_report {
    size_t row;         /* first row with an error */
    size_t clamped_row; /* first clamped row */
    size_t clamped;     /* number of clamped rows, before the error if there is one */
} rbt_report;

/* Draw n states, row by row into states[6 * n]: the same as n calls of rbt_draw with (alpha1[k],
   speed[k], seed, index[k], hit[k]), and faster, because many draws wait for memory together.

   RBT_OK, RBT_CLAMPED if any row was clamped, or the code of the first row with an error; then
   rows before it may be written, rows from it on are not. `report` may be NULL. */
RBT_API int rbt_draw_batch(const rbt_table *table, size_t n, const double *alpha1,
                           const double *speed, uint64_t seed, const uint64_t *index,
                           const uint32_t *hit, double *states, rbt_report *report);

/* Rebound one particle, in the lab frame.

   velocity, wall_velocity: of particle and wall at the contact, m/s; a wall_velocity of NULL is a
   wall at rest. normal: from the wall into the gas, any length but zero. half_size: largest
   half-size a of the particle, m. new_velocity: m/s; may be velocity itself. omega: angular
   velocity after the rebound, rad/s. At exactly normal impact the direction along the wall is
   uniform.

   Codes as rbt_draw; also RBT_NORMAL_NOT_USABLE, RBT_HALF_SIZE_NOT_POSITIVE. */
RBT_API RBT_DEVICE int rbt_rebound(const rbt_table *table, const double velocity[3],
                                   const double normal[3], double half_size,
                                   const double wall_velocity[3], uint64_t seed, uint64_t index,
                                   uint32_t hit, double new_velocity[3], double omega[3]);

/* An axis of the table: see sampler/formats/table_arrays.py. */
typedef struct rbt_axis {
    double first, last, low, high, origin, scale;
    int32_t offset, nodes, grid;
    const double *coordinate;
} rbt_axis;

struct rbt_table {
    rbt_axis alpha, speed;
    double variate_max, variate_scale;
    int32_t n_knots, n_components, n_classes, n_channels, n_marginals, n_columns, stride;
    int8_t channels[RBT_VALUES], marginals[RBT_VALUES], columns[RBT_VALUES];
    float units[2][RBT_VALUES]; /* of the rows of a factor, without and with reflection */
    const float *normals;
    const uint32_t *alias;
    const uint16_t *first_of_class;
    const int16_t *components;
    const double *spans;
    const uint16_t *quantiles;
    const char *image;
    size_t image_size;
    void *to_free;  /* memory that belongs to the table, else NULL */
    void *to_unmap; /* mapping that belongs to the table, else NULL */
    char pair[128];
};

/* For memory that the host cannot read, as of a GPU: the bytes of the image and their number; and a
   table whose draws read a copy of them at another address, to be passed by value. */
RBT_API const void *rbt_image(const rbt_table *table, size_t *size);
RBT_API rbt_table rbt_moved(const rbt_table *table, const void *copy);

#ifdef __cplusplus
}
#endif

#endif /* REBOUND_SAMPLER_H */

/* ---------------------------------------------------------------------------------------------- */

#if defined(REBOUND_SAMPLER_IMPLEMENTATION) && !defined(REBOUND_SAMPLER_IMPLEMENTED)
#define REBOUND_SAMPLER_IMPLEMENTED

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#if !defined(RBT_NO_MMAP) && (defined(__unix__) || defined(__APPLE__))
#define RBTI_MMAP 1
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#else
#include <stdio.h>
#endif

/* No multiplication is fused with an addition, so that states have the bits of Python's. */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__) && !defined(__CUDACC__)
#pragma GCC push_options
#pragma GCC optimize("fp-contract=off")
#endif

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define RBTI_INLINE static inline __attribute__((always_inline))
#define RBTI_ALIGNED __attribute__((aligned(64)))
#else
#define RBTI_INLINE static inline
#define RBTI_ALIGNED
#endif

/* Versions of a function for processors with wide vectors, of which the loader takes the one for the
   processor at hand: batches take half the time, whatever flags the program is compiled with. */
#if !defined(RBT_NO_CLONES) && defined(__GNUC__) && !defined(__clang__) && __GNUC__ >= 12 &&        \
    defined(__x86_64__) && defined(__linux__) && defined(__GLIBC__) && !defined(__CUDACC__) &&     \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define RBTI_CLONES                                                                                \
    __attribute__((optimize("O3", "fp-contract=off"),                                              \
                   target_clones("arch=x86-64-v4", "avx2", "default")))
#else
#define RBTI_CLONES
#endif

#if defined(__GNUC__) && !defined(__CUDA_ARCH__)
#define RBTI_PREFETCH(place) __builtin_prefetch(place)
#else
#define RBTI_PREFETCH(place) ((void)(place))
#endif

/* -- numbers of the law: sampler/drawing/kernel.py, sampler/formats/channels.py --------------------------------- */

#define RBTI_HALF_PI 1.5707963267948966
#define RBTI_TWO_PI 6.283185307179586
#define RBTI_ROUNDING 1e-12
#define RBTI_LANES 8
#define RBTI_UNIT (1.0f / 4096.0f)
#define RBTI_NORMAL_IMPACT 1e-12
#define RBTI_FIRST_MIRRORED 3
#define RBTI_END_MIRRORED 6

/* Not isfinite(), which some compiler flags remove. */
RBTI_INLINE RBT_DEVICE int rbti_finite(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return (bits & 0x7ff0000000000000u) != 0x7ff0000000000000u;
}

/* -- random words: sampler/drawing/philox.py ------------------------------------------------------------ */

RBTI_INLINE RBT_DEVICE void rbti_philox(uint32_t key0, uint32_t key1, uint32_t c0, uint32_t c1,
                                        uint32_t c2, uint32_t c3, uint32_t words[4])
{
    for (int round = 0; round < 10; round++) {
        const uint64_t p0 = (uint64_t)0xD2511F53u * c0;
        const uint64_t p1 = (uint64_t)0xCD9E8D57u * c2;
        c0 = (uint32_t)(p1 >> 32) ^ c1 ^ key0;
        c1 = (uint32_t)p1;
        c2 = (uint32_t)(p0 >> 32) ^ c3 ^ key1;
        c3 = (uint32_t)p0;
        key0 += 0x9E3779B9u;
        key1 += 0xBB67AE85u;
    }
    words[0] = c0;
    words[1] = c1;
    words[2] = c2;
    words[3] = c3;
}

RBTI_INLINE RBT_DEVICE void rbti_block_of(uint64_t seed, uint64_t index, uint32_t hit,
                                          uint32_t block, uint32_t words[4])
{
    rbti_philox((uint32_t)seed, (uint32_t)(seed >> 32), (uint32_t)index, (uint32_t)(index >> 32),
                hit, block, words);
}

/* -- normal numbers: sampler/drawing/normal.py ---------------------------------------------------------- */

/* Row of the table of cubics, place t in its piece and sign. The octave is counted by the exponent
   of a floating-point number, which unlike a count of leading zeros can be vectorised. */
RBTI_INLINE RBT_DEVICE int32_t rbti_piece(uint32_t word, float *t, float *sign)
{
    const int32_t upper = (int32_t)(word >> 31);
    const uint32_t mask = (uint32_t)-upper;
    /* half the distance from the nearer end, in units of 2^-32: from 1/2 to 2^31 */
    float half = (float)(int32_t)((word ^ mask) & 0x7fffffffu) + 0.5f;
    uint32_t bits;
    memcpy(&bits, &half, sizeof bits);
    const int32_t row = (int32_t)(bits >> 20) - 8 * 126;
    bits = (bits << 3 & 0x7fffffu) | 0x3f800000u;
    memcpy(&half, &bits, sizeof half);
    *t = half - 1.0f;
    *sign = 1.0f - 2.0f * (float)upper;
    return row;
}

RBTI_INLINE RBT_DEVICE float rbti_normal(const float *table, uint32_t word)
{
    float t, sign;
    const float *row = table + 4 * rbti_piece(word, &t, &sign);
    return sign * (row[0] + t * (row[1] + t * (row[2] + t * row[3])));
}

/* -- the steps of a draw: sampler/drawing/kernel.py ----------------------------------------------------- */

RBTI_INLINE RBT_DEVICE int rbti_status(const rbt_table *table, double alpha1, double speed)
{
    if (!(rbti_finite(alpha1) && rbti_finite(speed)))
        return RBT_NOT_FINITE;
    if (alpha1 >= table->alpha.low && alpha1 <= table->alpha.high && speed >= table->speed.low &&
        speed <= table->speed.high)
        return RBT_OK;
    if (alpha1 <= 0.0 || alpha1 > RBTI_HALF_PI + RBTI_ROUNDING)
        return RBT_NOT_APPROACHING;
    return speed <= 0.0 ? RBT_SPEED_NOT_POSITIVE : RBT_CLAMPED;
}

/* Lower node; weight of the upper one. */
RBTI_INLINE RBT_DEVICE int32_t rbti_locate(const rbt_axis *axis, double value, double *weight)
{
    value = value > axis->first ? value : axis->first;
    value = value < axis->last ? value : axis->last;
    double position = (value - axis->origin) * axis->scale;
    position = position > 0.0 ? position : 0.0;
    position = position < axis->grid - 1.0 ? position : axis->grid - 1.0;
    int32_t k = (int32_t)position;
    k = k < axis->grid - 2 ? k : axis->grid - 2;
    const double below = axis->coordinate[k];
    const double x = below + (position - k) * (axis->coordinate[k + 1] - below);
    /* on an axis of one node both neighbours are that node, with weight 0 for the upper one */
    int32_t lower = (int32_t)x - axis->offset;
    lower = lower < axis->nodes - 2 ? lower : axis->nodes - 2;
    lower = lower > 0 ? lower : 0;
    const double most = axis->nodes > 1 ? 1.0 : 0.0;
    double rest = x - (lower + axis->offset);
    rest = rest > 0.0 ? rest : 0.0;
    *weight = rest < most ? rest : most;
    return lower;
}

/* Column of the alias table, and place in it in units of 2^-16: whole and fractional part of w0 times
   the number of columns over 2^32, in 32 bits. */
RBTI_INLINE RBT_DEVICE int32_t rbti_column(uint32_t w0, uint32_t columns, uint32_t *fraction)
{
    const uint32_t product = (w0 >> 16) * columns + ((w0 & 0xffffu) * columns >> 16);
    *fraction = product & 0xffffu;
    return (int32_t)(product >> 16);
}

/* Pairs of 16-bit numbers in the longest record, of 8 channels. */
#define RBTI_PAIRS 23

/* Where a draw reads: first number of its component's record, first function of its class among
   the quantile functions of its cell, weights of the four nodes. */
typedef struct rbti_place {
    int32_t record, functions;
    float weights[4];
} rbti_place;

RBTI_INLINE RBT_DEVICE void rbti_choose(const rbt_table *table, double alpha1, double speed,
                                        uint32_t w0, uint32_t w1, rbti_place *place)
{
    double t, r;
    const int32_t i = rbti_locate(&table->alpha, alpha1, &t);
    const int32_t j = rbti_locate(&table->speed, speed, &r);
    const double w[4] = {(1.0 - t) * (1.0 - r), (1.0 - t) * r, t * (1.0 - r), t * r};
    for (int k = 0; k < 4; k++)
        place->weights[k] = (float)w[k];
    /* one of the four nodes, with these weights, by the upper 20 bits of w1 */
    const double c = ((double)(w1 >> 12) + 0.5) * (1.0 / 1048576.0);
    const double half = w[0] + w[1];
    const int upper_alpha = c >= half;
    const int upper_speed = c >= (upper_alpha ? half + w[2] : w[0]);
    const int32_t node_i = upper_alpha && i + 1 < table->alpha.nodes ? i + 1 : i;
    const int32_t node_j = upper_speed && j + 1 < table->speed.nodes ? j + 1 : j;
    const int32_t node = node_i * table->speed.nodes + node_j;
    /* one of its components, by the alias method */
    uint32_t fraction;
    int32_t column = rbti_column(w0, (uint32_t)table->n_components, &fraction);
    const uint32_t entry = table->alias[node * table->n_components + column];
    column = fraction >= entry >> 16 ? (int32_t)(entry & 0xffffu) : column;
    /* its class */
    int32_t kind = 0;
    const uint16_t *first = table->first_of_class + node * table->n_classes;
    for (int32_t k = 1; k < table->n_classes; k++)
        kind = column >= first[k] ? k : kind;
    const int32_t cells_of_row = table->speed.nodes > 1 ? table->speed.nodes - 1 : 1;
    place->record = (node * table->n_components + column) * table->stride;
    place->functions =
        ((i * cells_of_row + j) * table->n_classes + kind) * table->n_marginals;
}

/* Signed number in the lower half of a word. */
RBTI_INLINE int32_t rbti_signed(uint32_t word)
{
    return (int32_t)(word << 16) >> 16;
}

/* Variates mean + L n of all eight rows side by side, column by column, reflected or not. Rows above
   the diagonal get zeros added, and rows that the table lacks something finite: both read on into
   neighbouring numbers. */
RBTI_INLINE RBT_DEVICE void rbti_mix(const rbt_table *table, int32_t n, int32_t record, uint32_t w1,
                                     const float *normals, float variates[RBTI_LANES])
{
    const int16_t *numbers = table->components + record;
    const float *units = table->units[(int32_t)(w1 & 4095u) < numbers[0]];
    float z[RBTI_LANES];
    for (int lane = 0; lane < RBTI_LANES; lane++)
        z[lane] = (float)numbers[1 + lane];
    numbers += 1 + n;
    for (int32_t column = 0; column < n; column++) {
        const float x = normals[column];
        for (int lane = 0; lane < RBTI_LANES; lane++)
            z[lane] += (float)numbers[lane] * (lane >= column ? x : 0.0f);
        numbers += n - column - 1;
    }
    for (int lane = 0; lane < RBTI_LANES; lane++)
        variates[lane] = z[lane] * units[lane];
}

/* Knot below a variate, which becomes the fraction of the way to the next. */
RBTI_INLINE RBT_DEVICE int32_t rbti_knot(const rbt_table *table, float *variate)
{
    const float last = (float)(table->n_knots - 1);
    float position = (*variate + (float)table->variate_max) * (float)table->variate_scale;
    position = position > 0.0f ? position : 0.0f;
    position = position < last ? position : last;
    int32_t k = (int32_t)position;
    k = k < table->n_knots - 2 ? k : table->n_knots - 2;
    *variate = position - (float)k;
    return k;
}

/* Quantile of a marginal between a knot and the next, averaged over the four nodes. */
RBTI_INLINE RBT_DEVICE double rbti_quantile(const rbt_table *table, int32_t function, int32_t knot,
                                            float f, const float weights[4])
{
    const uint16_t *q = table->quantiles + 4 * (function * table->n_knots + knot);
    float term[4];
    for (int c = 0; c < 4; c++)
        term[c] = weights[c] * ((float)q[c] + f * ((float)q[4 + c] - (float)q[c]));
    const double *span = table->spans + 2 * function;
    return span[0] + span[1] * (double)((term[0] + term[1]) + (term[2] + term[3]));
}

/* Channels to components of the state: sampler/formats/channels.py. */
RBTI_INLINE RBT_DEVICE void rbti_to_state(double values[RBT_VALUES])
{
    const double v = values[0], u_hat = values[1], omega_z = values[2];
    const double w_hat = values[3], omega_x = values[4], omega_y = values[5];
    double rest = (1.0 - v) * (1.0 + v);
    values[0] = u_hat * sqrt(rest);
    values[1] = v;
    rest *= (1.0 - u_hat) * (1.0 + u_hat);
    values[2] = w_hat * sqrt(rest);
    values[3] = omega_x;
    values[4] = omega_y;
    values[5] = omega_z;
    values[6] *= rest * ((1.0 - w_hat) * (1.0 + w_hat));
    values[7] = floor(values[7]);
}

/* A draw at a condition that may be drawn at; n is the number of channels, which the compiler knows
   for the commonest tables. */
RBTI_INLINE RBT_DEVICE void rbti_draw_one(const rbt_table *table, int32_t n, double alpha1,
                                          double speed, uint64_t seed, uint64_t index, uint32_t hit,
                                          double values[RBT_VALUES])
{
    /* words 8 and 11 belong to no channel: the azimuth of a normal impact is made of word 8 */
    uint32_t words[12];
    rbti_block_of(seed, index, hit, 0, words);
    if (n > 2)
        rbti_block_of(seed, index, hit, 1, words + 4);
    if (n > 6)
        rbti_block_of(seed, index, hit, 2, words + 8);
    rbti_place place;
    rbti_choose(table, alpha1, speed, words[0], words[1], &place);
    RBTI_PREFETCH(table->components + place.record);
    float normals[RBTI_LANES], variates[RBTI_LANES];
    for (int32_t row = 0; row < n; row++)
        normals[row] = rbti_normal(table->normals, words[row < 6 ? 2 + row : 3 + row]);
    rbti_mix(table, n, place.record, words[1], normals, variates);
    for (int k = 0; k < RBT_VALUES; k++)
        values[k] = 0.0;
    for (int32_t row = 0; row < n; row++) {
        if (table->marginals[row] < 0)
            continue;
        const int32_t knot = rbti_knot(table, &variates[row]);
        values[table->channels[row]] = rbti_quantile(
            table, place.functions + table->marginals[row], knot, variates[row], place.weights);
    }
    rbti_to_state(values);
}

RBTI_INLINE RBT_DEVICE int rbti_draw(const rbt_table *table, double alpha1, double speed,
                                     uint64_t seed, uint64_t index, uint32_t hit,
                                     double values[RBT_VALUES])
{
    const int status = rbti_status(table, alpha1, speed);
    if (status < RBT_OK)
        return status;
    if (table->n_channels == 6)
        rbti_draw_one(table, 6, alpha1, speed, seed, index, hit, values);
    else
        rbti_draw_one(table, table->n_channels, alpha1, speed, seed, index, hit, values);
    return status;
}

RBT_API RBT_DEVICE int rbt_draw(const rbt_table *table, double alpha1, double speed, uint64_t seed,
                                uint64_t index, uint32_t hit, double state[6])
{
    double values[RBT_VALUES];
    const int status = rbti_draw(table, alpha1, speed, seed, index, hit, values);
    if (status >= RBT_OK)
        for (int k = 0; k < 6; k++)
            state[k] = values[k];
    return status;
}

RBT_API RBT_DEVICE int rbt_draw_all(const rbt_table *table, double alpha1, double speed,
                                    uint64_t seed, uint64_t index, uint32_t hit,
                                    double values[RBT_VALUES])
{
    double drawn[RBT_VALUES];
    const int status = rbti_draw(table, alpha1, speed, seed, index, hit, drawn);
    if (status >= RBT_OK)
        for (int k = 0; k < RBT_VALUES; k++)
            values[k] = drawn[k];
    return status;
}

/* -- many draws side by side: sampler/drawing/batch.py --------------------------------------------------

   A step at a time for all draws of a block. Each step is a loop over arrays of fixed length without
   branches, which compilers turn into vector instructions; what it reads in memory was asked for by
   the step before. The arithmetic of a draw is that of rbti_draw. */

#define RBTI_BLOCK ((size_t)32)

typedef struct rbti_draws {
    double alpha1[RBTI_BLOCK], speed[RBTI_BLOCK];
    uint32_t words[12][RBTI_BLOCK];
    double alpha_weight[RBTI_BLOCK], speed_weight[RBTI_BLOCK];
    float weights[4][RBTI_BLOCK];
    int32_t alpha_node[RBTI_BLOCK], speed_node[RBTI_BLOCK];
    int32_t record[RBTI_BLOCK], functions[RBTI_BLOCK];
    float values[RBT_VALUES][RBTI_BLOCK]; /* normals, then fractions, by row of the factor */
    int32_t entries[RBT_VALUES][RBTI_BLOCK];
    double channels[RBT_VALUES][RBTI_BLOCK];
} rbti_draws;

#define RBTI_EACH_DRAW(r) for (size_t r = 0; r < RBTI_BLOCK; r++)

/* Random words of a block; one that is not full repeats its last draw. Words lie in the lower halves
   of 64 bits, so that products need no rearrangement. */
RBTI_INLINE void rbti_fill_words(uint32_t blocks, uint64_t seed, const uint64_t *index,
                                 const uint32_t *hit, size_t count, rbti_draws *draws)
{
    const uint64_t low = 0xffffffffu;
    for (uint32_t block = 0; block < blocks; block++) {
        uint64_t c0[RBTI_BLOCK] RBTI_ALIGNED, c1[RBTI_BLOCK] RBTI_ALIGNED;
        uint64_t c2[RBTI_BLOCK] RBTI_ALIGNED, c3[RBTI_BLOCK] RBTI_ALIGNED;
        uint64_t key0 = seed & low, key1 = seed >> 32;
        RBTI_EACH_DRAW(r)
        {
            const size_t k = r < count ? r : count - 1;
            c0[r] = index[k];
            c1[r] = index[k] >> 32;
            c2[r] = hit[k];
            c3[r] = block;
        }
        for (int round = 0; round < 10; round++) {
            RBTI_EACH_DRAW(r)
            {
                const uint64_t p0 = (c0[r] & low) * 0xD2511F53u, p1 = (c2[r] & low) * 0xCD9E8D57u;
                c0[r] = (p1 >> 32) ^ c1[r] ^ key0;
                c1[r] = p1;
                c2[r] = (p0 >> 32) ^ c3[r] ^ key1;
                c3[r] = p0;
            }
            key0 = (key0 + 0x9E3779B9u) & low;
            key1 = (key1 + 0xBB67AE85u) & low;
        }
        RBTI_EACH_DRAW(r)
        {
            draws->words[4 * block][r] = (uint32_t)c0[r];
            draws->words[4 * block + 1][r] = (uint32_t)c1[r];
            draws->words[4 * block + 2][r] = (uint32_t)c2[r];
            draws->words[4 * block + 3][r] = (uint32_t)c3[r];
        }
    }
}

RBTI_INLINE void rbti_locate_block(const rbt_axis *axis, const double *values, int32_t *nodes,
                                   double *weights)
{
    const rbt_axis a = *axis;
    RBTI_EACH_DRAW(r)
    {
        nodes[r] = rbti_locate(&a, values[r], &weights[r]);
    }
}

/* Node, column of its alias table, then component and class; asks for the record. */
RBTI_INLINE void rbti_choose_block(const rbt_table *table, rbti_draws *d)
{
    const int32_t speeds = table->speed.nodes, last_alpha = table->alpha.nodes - 1;
    const int32_t components = table->n_components, classes = table->n_classes;
    const int32_t cells_of_row = speeds > 1 ? speeds - 1 : 1;
    int32_t node[RBTI_BLOCK] RBTI_ALIGNED, column[RBTI_BLOCK] RBTI_ALIGNED;
    int32_t kind[RBTI_BLOCK] RBTI_ALIGNED;
    uint32_t fraction[RBTI_BLOCK] RBTI_ALIGNED;
    RBTI_EACH_DRAW(r)
    {
        const double t = d->alpha_weight[r], s = d->speed_weight[r];
        const double w0 = (1.0 - t) * (1.0 - s), w1 = (1.0 - t) * s, w2 = t * (1.0 - s);
        d->weights[0][r] = (float)w0;
        d->weights[1][r] = (float)w1;
        d->weights[2][r] = (float)w2;
        d->weights[3][r] = (float)(t * s);
        const double c = ((double)(int32_t)(d->words[1][r] >> 12) + 0.5) * (1.0 / 1048576.0);
        const double half = w0 + w1;
        const int32_t upper_alpha = c >= half;
        const double limit = upper_alpha ? half + w2 : w0;
        const int32_t upper_speed = c >= limit;
        const int32_t i = d->alpha_node[r] + upper_alpha, j = d->speed_node[r] + upper_speed;
        node[r] = (i < last_alpha ? i : last_alpha) * speeds + (j < speeds - 1 ? j : speeds - 1);
        column[r] = rbti_column(d->words[0][r], (uint32_t)components, &fraction[r]);
    }
    RBTI_EACH_DRAW(r)
    {
        RBTI_PREFETCH(table->alias + node[r] * components + column[r]);
    }
    uint32_t entry[RBTI_BLOCK] RBTI_ALIGNED;
    RBTI_EACH_DRAW(r)
    {
        entry[r] = table->alias[node[r] * components + column[r]];
    }
    RBTI_EACH_DRAW(r)
    {
        const int32_t other = (int32_t)(entry[r] & 0xffffu);
        column[r] = fraction[r] >= entry[r] >> 16 ? other : column[r];
        kind[r] = 0;
    }
    for (int32_t k = 1; k < classes; k++) {
        int32_t first[RBTI_BLOCK] RBTI_ALIGNED;
        RBTI_EACH_DRAW(r)
        {
            first[r] = table->first_of_class[node[r] * classes + k];
        }
        RBTI_EACH_DRAW(r)
        {
            kind[r] = column[r] >= first[r] ? k : kind[r];
        }
    }
    RBTI_EACH_DRAW(r)
    {
        const int32_t cell = d->alpha_node[r] * cells_of_row + d->speed_node[r];
        d->record[r] = (node[r] * components + column[r]) * table->stride;
        d->functions[r] = (cell * classes + kind[r]) * table->n_marginals;
    }
    RBTI_EACH_DRAW(r)
    {
        RBTI_PREFETCH(table->components + d->record[r]);
    }
}

RBTI_INLINE void rbti_fill_normals(const float *table, const uint32_t *words, float *normals)
{
    int32_t rows[RBTI_BLOCK] RBTI_ALIGNED;
    float t[RBTI_BLOCK] RBTI_ALIGNED, sign[RBTI_BLOCK] RBTI_ALIGNED;
    float cubic[4][RBTI_BLOCK] RBTI_ALIGNED;
    RBTI_EACH_DRAW(r)
    {
        rows[r] = rbti_piece(words[r], &t[r], &sign[r]);
    }
    RBTI_EACH_DRAW(r)
    {
        const float *row = table + 4 * rows[r];
        cubic[0][r] = row[0];
        cubic[1][r] = row[1];
        cubic[2][r] = row[2];
        cubic[3][r] = row[3];
    }
    RBTI_EACH_DRAW(r)
    {
        normals[r] = sign[r] * (cubic[0][r] +
                                t[r] * (cubic[1][r] + t[r] * (cubic[2][r] + t[r] * cubic[3][r])));
    }
}

/* Records of a block, number by number: factors[k][r] is number k of the record of draw r. */
RBTI_INLINE void rbti_fill_factors(const rbt_table *table, int32_t n, const int32_t *records,
                                   float (*factors)[RBTI_BLOCK])
{
    const int32_t pairs = (2 + n + n * (n + 1) / 2) / 2;
    uint32_t raw[RBTI_PAIRS][RBTI_BLOCK] RBTI_ALIGNED;
    RBTI_EACH_DRAW(r)
    {
        const int16_t *record = table->components + records[r];
        for (int32_t k = 0; k < pairs; k++)
            memcpy(&raw[k][r], record + 2 * k, sizeof raw[k][r]);
    }
    for (int32_t k = 0; k < pairs; k++) {
        RBTI_EACH_DRAW(r)
        {
            factors[2 * k][r] = (float)rbti_signed(raw[k][r]);
            factors[2 * k + 1][r] = (float)rbti_signed(raw[k][r] >> 16);
        }
    }
}

/* Normals to fractions between knots; asks for the quantiles there. */
RBTI_INLINE void rbti_mix_block(const rbt_table *table, int32_t n, rbti_draws *d)
{
    const float variate_max = (float)table->variate_max, scale = (float)table->variate_scale;
    const float last = (float)(table->n_knots - 1);
    const int32_t last_but_one = table->n_knots - 2, knots = table->n_knots;
    float factors[2 * RBTI_PAIRS][RBTI_BLOCK] RBTI_ALIGNED;
    float unit[2][RBTI_BLOCK] RBTI_ALIGNED;
    rbti_fill_factors(table, n, d->record, factors);
    RBTI_EACH_DRAW(r)
    {
        const float limit = (float)(int32_t)(d->words[1][r] & 4095u);
        unit[0][r] = RBTI_UNIT;
        unit[1][r] = limit < factors[0][r] ? -RBTI_UNIT : RBTI_UNIT;
    }
    for (int32_t row = n - 1; row >= 0; row--) {
        /* from the last row upwards, so that each row still finds the normals it needs */
        const float *units = unit[table->units[1][row] < 0.0f];
        float z[RBTI_BLOCK] RBTI_ALIGNED;
        RBTI_EACH_DRAW(r)
        {
            z[r] = factors[1 + row][r];
        }
        for (int32_t column = 0; column <= row; column++) {
            const float *factor = factors[1 + n + column * n - column * (column + 1) / 2 + row];
            RBTI_EACH_DRAW(r)
            {
                z[r] += factor[r] * d->values[column][r];
            }
        }
        RBTI_EACH_DRAW(r)
        {
            float position = (z[r] * units[r] + variate_max) * scale;
            position = position > 0.0f ? position : 0.0f;
            position = position < last ? position : last;
            int32_t k = (int32_t)position;
            k = k < last_but_one ? k : last_but_one;
            d->values[row][r] = position - (float)k;
            d->entries[row][r] = ((d->functions[r] + table->marginals[row]) * knots + k) * 4;
        }
        if (table->marginals[row] >= 0) {
            RBTI_EACH_DRAW(r)
            {
                RBTI_PREFETCH(table->quantiles + d->entries[row][r]);
            }
        }
    }
}

/* Quantiles of one channel between knots, averaged over the four nodes. */
RBTI_INLINE void rbti_quantile_block(const rbt_table *table, int32_t row, const rbti_draws *d,
                                     double *result)
{
    uint32_t raw[4][RBTI_BLOCK] RBTI_ALIGNED;
    double least[RBTI_BLOCK] RBTI_ALIGNED, step[RBTI_BLOCK] RBTI_ALIGNED;
    RBTI_EACH_DRAW(r)
    {
        uint32_t eight[4];
        memcpy(eight, table->quantiles + d->entries[row][r], sizeof eight);
        raw[0][r] = eight[0];
        raw[1][r] = eight[1];
        raw[2][r] = eight[2];
        raw[3][r] = eight[3];
    }
    RBTI_EACH_DRAW(r)
    {
        const double *span = table->spans + 2 * (d->functions[r] + table->marginals[row]);
        least[r] = span[0];
        step[r] = span[1];
    }
    RBTI_EACH_DRAW(r)
    {
        const float f = d->values[row][r];
        float mean[2];
        for (int half = 0; half < 2; half++) {
            const float low0 = (float)(int32_t)(raw[half][r] & 0xffffu);
            const float low1 = (float)(int32_t)(raw[half][r] >> 16);
            const float high0 = (float)(int32_t)(raw[2 + half][r] & 0xffffu);
            const float high1 = (float)(int32_t)(raw[2 + half][r] >> 16);
            mean[half] = d->weights[2 * half][r] * (low0 + f * (high0 - low0)) +
                         d->weights[2 * half + 1][r] * (low1 + f * (high1 - low1));
        }
        result[r] = least[r] + step[r] * (double)(mean[0] + mean[1]);
    }
}

/* Channels to states, of which `count` are written. */
RBTI_INLINE void rbti_finish_block(rbti_draws *d, size_t count, double *states)
{
    double(*c)[RBTI_BLOCK] = d->channels;
    double u[RBTI_BLOCK] RBTI_ALIGNED, w[RBTI_BLOCK] RBTI_ALIGNED;
    RBTI_EACH_DRAW(r)
    {
        const double rest = (1.0 - c[0][r]) * (1.0 + c[0][r]);
        const double last = rest * ((1.0 - c[1][r]) * (1.0 + c[1][r]));
        u[r] = c[1][r] * sqrt(rest);
        w[r] = c[3][r] * sqrt(last);
    }
    for (size_t r = 0; r < count; r++) {
        double *state = states + 6 * r;
        state[0] = u[r];
        state[1] = c[0][r];
        state[2] = w[r];
        state[3] = c[4][r];
        state[4] = c[5][r];
        state[5] = c[2][r];
    }
}

/* Draws of a block with conditions that may be drawn at; n is the number of channels, which the
   compiler knows for the commonest tables. */
RBTI_INLINE void rbti_draw_block(const rbt_table *table, int32_t n, uint64_t seed,
                                 const uint64_t *index, const uint32_t *hit, size_t count,
                                 rbti_draws *d, double *states)
{
    rbti_fill_words(n <= 2 ? 1 : n <= 6 ? 2 : 3, seed, index, hit, count, d);
    rbti_locate_block(&table->alpha, d->alpha1, d->alpha_node, d->alpha_weight);
    rbti_locate_block(&table->speed, d->speed, d->speed_node, d->speed_weight);
    rbti_choose_block(table, d);
    for (int32_t row = 0; row < n; row++)
        rbti_fill_normals(table->normals, d->words[row < 6 ? 2 + row : 3 + row], d->values[row]);
    rbti_mix_block(table, n, d);
    for (int channel = 0; channel < 6; channel++)
        RBTI_EACH_DRAW(r)
        {
            d->channels[channel][r] = 0.0;
        }
    for (int32_t row = 0; row < n; row++)
        if (table->marginals[row] >= 0)
            rbti_quantile_block(table, row, d, d->channels[table->channels[row]]);
    rbti_finish_block(d, count, states);
}

/* Copy the conditions of a block; how many rows come before the first error, whose code is given.
   Where no row is left a condition of the table stands, so that all of the block can be drawn. */
RBTI_INLINE size_t rbti_conditions(const rbt_table *table, const double *alpha1,
                                   const double *speed, size_t first, size_t most, rbti_draws *d,
                                   int *code, rbt_report *report)
{
    const rbt_axis alpha = table->alpha, velocity = table->speed;
    int outside = 0;
    RBTI_EACH_DRAW(r)
    {
        const size_t k = first + (r < most ? r : most - 1);
        const double a = alpha1[k], v = speed[k];
        const int off_alpha = (a < alpha.low) + (a > alpha.high);
        const int off_speed = (v < velocity.low) + (v > velocity.high);
        outside |= off_alpha | off_speed | (1 - rbti_finite(a) * rbti_finite(v));
        d->alpha1[r] = a;
        d->speed[r] = v;
    }
    for (size_t r = 0; r < most && outside; r++) {
        const int status = rbti_status(table, d->alpha1[r], d->speed[r]);
        if (status < RBT_OK) {
            report->row = first + r;
            *code = status;
            for (size_t k = r; k < RBTI_BLOCK; k++) {
                d->alpha1[k] = alpha.first;
                d->speed[k] = velocity.first;
            }
            return r;
        }
        if (status == RBT_CLAMPED && report->clamped++ == 0)
            report->clamped_row = first + r;
    }
    return most;
}

RBTI_CLONES
RBT_API int rbt_draw_batch(const rbt_table *table, size_t n, const double *alpha1,
                           const double *speed, uint64_t seed, const uint64_t *index,
                           const uint32_t *hit, double *states, rbt_report *report)
{
    rbti_draws draws RBTI_ALIGNED;
    rbt_report found = {n, n, 0};
    int code = RBT_OK;
    for (size_t first = 0; first < n && code == RBT_OK; first += RBTI_BLOCK) {
        const size_t most = n - first < RBTI_BLOCK ? n - first : RBTI_BLOCK;
        const size_t count =
            rbti_conditions(table, alpha1, speed, first, most, &draws, &code, &found);
        if (count == 0)
            break;
        if (table->n_channels == 6)
            rbti_draw_block(table, 6, seed, index + first, hit + first, count, &draws,
                            states + 6 * first);
        else
            rbti_draw_block(table, table->n_channels, seed, index + first, hit + first, count,
                            &draws, states + 6 * first);
    }
    if (report)
        *report = found;
    return code == RBT_OK && found.clamped > 0 ? RBT_CLAMPED : code;
}

/* -- between the lab frame and the frame of the impact: sampler/drawing/frames.py ----------------------- */

RBTI_INLINE RBT_DEVICE double rbti_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

RBTI_INLINE RBT_DEVICE void rbti_cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* out = p a + q b; out may be a or b. */
RBTI_INLINE RBT_DEVICE void rbti_combine(double p, const double a[3], double q, const double b[3],
                                         double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = p * a[k] + q * b[k];
}

/* Unit vector along a nonzero finite vector of any magnitude; out may be a. */
RBTI_INLINE RBT_DEVICE void rbti_unit(const double a[3], double out[3])
{
    const double x = fabs(a[0]), y = fabs(a[1]), z = fabs(a[2]);
    double largest = x > y ? x : y;
    largest = largest > z ? largest : z;
    double scaled[3];
    for (int k = 0; k < 3; k++)
        scaled[k] = a[k] / largest;
    const double inverse = 1.0 / sqrt(rbti_dot(scaled, scaled));
    for (int k = 0; k < 3; k++)
        out[k] = inverse * scaled[k];
}

RBTI_INLINE RBT_DEVICE int rbti_all_finite(const double a[3])
{
    return rbti_finite(a[0]) && rbti_finite(a[1]) && rbti_finite(a[2]);
}

/* Unit vector perpendicular to e_y, at an angle about it. */
RBTI_INLINE RBT_DEVICE void rbti_perpendicular(const double e_y[3], double azimuth, double e_x[3])
{
    const double x = fabs(e_y[0]), y = fabs(e_y[1]), z = fabs(e_y[2]);
    double axis[3] = {0.0, 0.0, 0.0}, zero[3], side[3];
    axis[x <= y && x <= z ? 0 : y <= z ? 1 : 2] = 1.0;
    rbti_combine(1.0, axis, -rbti_dot(axis, e_y), e_y, zero);
    rbti_unit(zero, zero);
    rbti_cross(e_y, zero, side);
    rbti_combine(cos(azimuth), zero, sin(azimuth), side, e_x);
}

/* Unit vector along the tangential part of a velocity, projected twice against rounding. */
RBTI_INLINE RBT_DEVICE void rbti_along_wall(const double relative[3], const double e_y[3],
                                            double e_x[3])
{
    rbti_combine(1.0, relative, -rbti_dot(relative, e_y), e_y, e_x);
    rbti_unit(e_x, e_x);
    rbti_combine(1.0, e_x, -rbti_dot(e_x, e_y), e_y, e_x);
    rbti_unit(e_x, e_x);
}

RBTI_INLINE RBT_DEVICE void rbti_turned(const double state[3], const double e_x[3],
                                        const double e_y[3], const double e_z[3], double scale,
                                        double out[3])
{
    double plane[3];
    rbti_combine(state[0], e_x, state[1], e_y, plane);
    rbti_combine(scale, plane, scale * state[2], e_z, out);
}

RBT_API RBT_DEVICE int rbt_rebound(const rbt_table *table, const double velocity[3],
                                   const double normal[3], double half_size,
                                   const double wall_velocity[3], uint64_t seed, uint64_t index,
                                   uint32_t hit, double new_velocity[3], double omega[3])
{
    double wall[3] = {0.0, 0.0, 0.0};
    for (int k = 0; k < 3 && wall_velocity; k++)
        wall[k] = wall_velocity[k];
    if (!(rbti_all_finite(velocity) && rbti_all_finite(wall) && rbti_all_finite(normal) &&
          rbti_finite(half_size)))
        return RBT_NOT_FINITE;
    if (normal[0] == 0.0 && normal[1] == 0.0 && normal[2] == 0.0)
        return RBT_NORMAL_NOT_USABLE;
    if (half_size <= 0.0)
        return RBT_HALF_SIZE_NOT_POSITIVE;
    double relative[3], along[3], e_x[3], e_y[3], e_z[3], values[RBT_VALUES];
    rbti_combine(1.0, velocity, -1.0, wall, relative);
    const double speed = sqrt(rbti_dot(relative, relative));
    if (speed == 0.0)
        return RBT_SPEED_NOT_POSITIVE;
    rbti_unit(normal, e_y);
    const double approach = -rbti_dot(relative, e_y);
    rbti_combine(1.0, relative, approach, e_y, along);
    const double tangential = sqrt(rbti_dot(along, along));
    const double alpha1 = atan2(approach, tangential);
    const int status = rbti_draw(table, alpha1, speed, seed, index, hit, values);
    if (status < RBT_OK)
        return status;
    if (tangential <= RBTI_NORMAL_IMPACT * speed) {
        uint32_t words[4];
        rbti_block_of(seed, index, hit, 2, words);
        rbti_perpendicular(e_y, RBTI_TWO_PI * (((double)words[0] + 0.5) * (1.0 / 4294967296.0)),
                           e_x);
    } else {
        rbti_along_wall(relative, e_y, e_x);
    }
    rbti_cross(e_x, e_y, e_z);
    rbti_turned(values, e_x, e_y, e_z, speed, new_velocity);
    rbti_turned(values + 3, e_x, e_y, e_z, speed / half_size, omega);
    for (int k = 0; k < 3; k++)
        new_velocity[k] += wall[k];
    return status;
}

/* -- SHA-256 (FIPS 180-4) ----------------------------------------------------------------------- */

typedef struct rbti_sha {
    uint32_t state[8];
    uint8_t block[64];
    uint64_t bytes;
} rbti_sha;

RBTI_INLINE uint32_t rbti_rotated(uint32_t x, unsigned n)
{
    return x >> n | x << (32 - n);
}

static void rbti_sha_block(uint32_t state[8], const uint8_t *block)
{
    static const uint32_t constants[64] = {
        0x428a2f98u, 0x71374491u, 0xb5c0fbcfu, 0xe9b5dba5u, 0x3956c25bu, 0x59f111f1u, 0x923f82a4u,
        0xab1c5ed5u, 0xd807aa98u, 0x12835b01u, 0x243185beu, 0x550c7dc3u, 0x72be5d74u, 0x80deb1feu,
        0x9bdc06a7u, 0xc19bf174u, 0xe49b69c1u, 0xefbe4786u, 0x0fc19dc6u, 0x240ca1ccu, 0x2de92c6fu,
        0x4a7484aau, 0x5cb0a9dcu, 0x76f988dau, 0x983e5152u, 0xa831c66du, 0xb00327c8u, 0xbf597fc7u,
        0xc6e00bf3u, 0xd5a79147u, 0x06ca6351u, 0x14292967u, 0x27b70a85u, 0x2e1b2138u, 0x4d2c6dfcu,
        0x53380d13u, 0x650a7354u, 0x766a0abbu, 0x81c2c92eu, 0x92722c85u, 0xa2bfe8a1u, 0xa81a664bu,
        0xc24b8b70u, 0xc76c51a3u, 0xd192e819u, 0xd6990624u, 0xf40e3585u, 0x106aa070u, 0x19a4c116u,
        0x1e376c08u, 0x2748774cu, 0x34b0bcb5u, 0x391c0cb3u, 0x4ed8aa4au, 0x5b9cca4fu, 0x682e6ff3u,
        0x748f82eeu, 0x78a5636fu, 0x84c87814u, 0x8cc70208u, 0x90befffau, 0xa4506cebu, 0xbef9a3f7u,
        0xc67178f2u};
    uint32_t w[64], a[8];
    for (int k = 0; k < 16; k++)
        w[k] = (uint32_t)block[4 * k] << 24 | (uint32_t)block[4 * k + 1] << 16 |
               (uint32_t)block[4 * k + 2] << 8 | (uint32_t)block[4 * k + 3];
    for (int k = 16; k < 64; k++) {
        const uint32_t x = w[k - 15], y = w[k - 2];
        w[k] = w[k - 16] + w[k - 7] + (rbti_rotated(x, 7) ^ rbti_rotated(x, 18) ^ x >> 3) +
               (rbti_rotated(y, 17) ^ rbti_rotated(y, 19) ^ y >> 10);
    }
    memcpy(a, state, sizeof a);
    for (int k = 0; k < 64; k++) {
        const uint32_t s1 = rbti_rotated(a[4], 6) ^ rbti_rotated(a[4], 11) ^ rbti_rotated(a[4], 25);
        const uint32_t s0 = rbti_rotated(a[0], 2) ^ rbti_rotated(a[0], 13) ^ rbti_rotated(a[0], 22);
        const uint32_t t1 = a[7] + s1 + ((a[4] & a[5]) ^ (~a[4] & a[6])) + constants[k] + w[k];
        const uint32_t t2 = s0 + ((a[0] & a[1]) ^ (a[0] & a[2]) ^ (a[1] & a[2]));
        for (int m = 7; m > 0; m--)
            a[m] = a[m - 1];
        a[4] += t1;
        a[0] = t1 + t2;
    }
    for (int k = 0; k < 8; k++)
        state[k] += a[k];
}

static void rbti_sha_start(rbti_sha *sha)
{
    static const uint32_t start[8] = {0x6a09e667u, 0xbb67ae85u, 0x3c6ef372u, 0xa54ff53au,
                                      0x510e527fu, 0x9b05688cu, 0x1f83d9abu, 0x5be0cd19u};
    memcpy(sha->state, start, sizeof start);
    sha->bytes = 0;
}

static void rbti_sha_add(rbti_sha *sha, const uint8_t *bytes, size_t size)
{
    while (size > 0) {
        const size_t filled = (size_t)(sha->bytes % 64);
        if (filled == 0 && size >= 64) {
            rbti_sha_block(sha->state, bytes);
            sha->bytes += 64;
            bytes += 64;
            size -= 64;
            continue;
        }
        const size_t part = size < 64 - filled ? size : 64 - filled;
        memcpy(sha->block + filled, bytes, part);
        sha->bytes += part;
        bytes += part;
        size -= part;
        if (filled + part == 64)
            rbti_sha_block(sha->state, sha->block);
    }
}

static void rbti_sha_end(rbti_sha *sha, uint8_t digest[32])
{
    static const uint8_t padding[64] = {0x80};
    const uint64_t bits = sha->bytes * 8;
    const size_t filled = (size_t)(sha->bytes % 64);
    uint8_t length[8];
    for (int k = 0; k < 8; k++)
        length[k] = (uint8_t)(bits >> (56 - 8 * k));
    rbti_sha_add(sha, padding, filled < 56 ? 56 - filled : 120 - filled);
    rbti_sha_add(sha, length, 8);
    for (int k = 0; k < 32; k++)
        digest[k] = (uint8_t)(sha->state[k / 4] >> (24 - 8 * (k % 4)));
}

/* -- reading an image: sampler/formats/binary_layout.py, sampler/formats/binary_checks.py ------------------------- */

/* The header of the file: every field naturally aligned, no padding. */
typedef struct rbti_header {
    char magic[8];
    uint16_t major, minor;
    uint32_t header_bytes;
    uint64_t file_bytes;
    uint8_t sha256[32], content_sha256[32];
    char pair[128];
    uint32_t n_alpha, n_speed, n_alpha_grid, n_speed_grid, n_knots, n_components;
    uint32_t n_classes, n_channels, n_marginals, n_columns, stride, flags;
    int8_t channels[8], marginals[8], columns[8];
    int32_t alpha_offset, speed_offset;
    double alpha_first, alpha_last, alpha_origin, alpha_scale;
    double speed_first, speed_last, speed_origin, speed_scale, variate_max;
    uint64_t at_alpha_coordinate, at_speed_coordinate, at_normals, at_alias;
    uint64_t at_first_of_class, at_components, at_spans, at_quantiles;
} rbti_header;

#define RBTI_MOST_BYTES 0x80000000u
#define RBTI_SPEED_INDEPENDENT 1u /* in flags: rebounds do not depend on the speed */
#define RBTI_NEED(holds, code)                                                                     \
    do {                                                                                           \
        if (!(holds))                                                                              \
            return (code);                                                                         \
    } while (0)

static uint64_t rbti_cells(const rbti_header *header)
{
    const uint64_t rows = header->n_alpha > 1 ? header->n_alpha - 1 : 1;
    return rows * (header->n_speed > 1 ? header->n_speed - 1 : 1);
}

static uint64_t rbti_nodes(const rbti_header *header)
{
    return (uint64_t)header->n_alpha * header->n_speed;
}

static int rbti_check_start(const char *image, size_t size, rbti_header *header)
{
    static const char magic[8] = {(char)0x89, 'R', 'B', 'T', '\r', '\n', 0x1a, '\n'};
    const uint32_t one = 1;
    uint8_t least;
    memcpy(&least, &one, 1);
    RBTI_NEED(least == 1, RBT_BIG_ENDIAN);
    RBTI_NEED(size >= sizeof magic && memcmp(image, magic, sizeof magic) == 0, RBT_FORMAT);
    RBTI_NEED(size >= sizeof *header, RBT_SIZE);
    memcpy(header, image, sizeof *header);
    RBTI_NEED(header->major == 1, RBT_VERSION);
    RBTI_NEED(header->file_bytes == size && size < RBTI_MOST_BYTES, RBT_SIZE);
    return RBT_OK;
}

static int rbti_check_sum(const char *image, size_t size, const rbti_header *header)
{
    const size_t at = offsetof(rbti_header, sha256);
    uint8_t digest[32];
    rbti_sha sha;
    rbti_sha_start(&sha);
    rbti_sha_add(&sha, (const uint8_t *)image, at);
    rbti_sha_add(&sha, (const uint8_t *)image + at + 32, size - at - 32);
    rbti_sha_end(&sha, digest);
    return memcmp(digest, header->sha256, 32) == 0 ? RBT_OK : RBT_CHECKSUM;
}

static int rbti_within(uint32_t value, uint32_t least, uint32_t most)
{
    return value >= least && value <= most;
}

static int rbti_check_dimensions(const rbti_header *h)
{
    RBTI_NEED(rbti_within(h->n_alpha, 1, 65536) && rbti_within(h->n_speed, 1, 65536),
              RBT_DIMENSIONS);
    RBTI_NEED(rbti_within(h->n_alpha_grid, 2, 1u << 24), RBT_DIMENSIONS);
    RBTI_NEED(rbti_within(h->n_speed_grid, 2, 1u << 24), RBT_DIMENSIONS);
    RBTI_NEED(rbti_within(h->n_knots, 2, 65536), RBT_DIMENSIONS);
    RBTI_NEED(rbti_within(h->n_components, 1, 65536), RBT_DIMENSIONS);
    RBTI_NEED(rbti_within(h->n_classes, 1, 65536), RBT_DIMENSIONS);
    RBTI_NEED(rbti_within(h->n_channels, 1, RBT_VALUES), RBT_DIMENSIONS);
    RBTI_NEED(rbti_within(h->n_marginals, 1, RBT_VALUES), RBT_DIMENSIONS);
    RBTI_NEED(rbti_within(h->n_columns, 1, RBT_VALUES), RBT_DIMENSIONS);
    const uint32_t needed = 1 + h->n_channels + h->n_channels * (h->n_channels + 1) / 2;
    uint32_t stride = 1;
    while (stride < needed)
        stride *= 2;
    RBTI_NEED(h->stride == stride, RBT_DIMENSIONS);
    return RBT_OK;
}

/* Bits of n names that are known and all different, followed by -1 only; 0 if they are not. */
static unsigned rbti_name_bits(const int8_t names[RBT_VALUES], uint32_t n)
{
    unsigned bits = 0;
    for (uint32_t k = 0; k < RBT_VALUES; k++) {
        if (k >= n) {
            if (names[k] != -1)
                return 0;
            continue;
        }
        if (names[k] < 0 || names[k] >= RBT_VALUES || (bits >> names[k] & 1u))
            return 0;
        bits |= 1u << names[k];
    }
    return bits;
}

static int rbti_check_names(const rbti_header *h)
{
    /* channels (bits) from which each component is made; channels v, u_hat, omega_z, w_hat,
       omega_x, omega_y, energy_hat, collisions */
    static const unsigned needs[RBT_VALUES] = {0x03, 0x01, 0x0b, 0x10, 0x20, 0x04, 0x4b, 0x80};
    RBTI_NEED(rbti_name_bits(h->channels, h->n_channels), RBT_NAMES);
    RBTI_NEED(rbti_name_bits(h->columns, h->n_columns), RBT_NAMES);
    unsigned needed = 0, held = 0;
    uint32_t marginals = 0;
    for (uint32_t k = 0; k < RBT_VALUES; k++) {
        if (h->marginals[k] != -1) {
            RBTI_NEED(k < h->n_channels && h->marginals[k] == (int)marginals, RBT_NAMES);
            marginals++;
            held |= 1u << h->channels[k];
        }
        if (k < h->n_columns)
            needed |= needs[h->columns[k]];
    }
    RBTI_NEED(marginals == h->n_marginals && held == needed, RBT_NAMES);
    return RBT_OK;
}

/* Whether a x b x c numbers of some bytes each lie in the file at an aligned offset. */
static int rbti_lies(const rbti_header *h, uint64_t at, uint64_t a, uint64_t b, uint64_t c,
                     uint64_t bytes)
{
    if (at % 64 != 0 || at < sizeof *h || at > h->file_bytes)
        return 0;
    /* a, b, c and bytes are below 2^33, and quotients rounded down cannot mislead */
    uint64_t room = h->file_bytes - at;
    return a <= room / bytes && b <= room / bytes / a && c <= room / bytes / a / b;
}

static int rbti_check_offsets(const rbti_header *h)
{
    const uint64_t nodes = rbti_nodes(h), cells = rbti_cells(h);
    const uint64_t functions = (uint64_t)h->n_classes * h->n_marginals;
    RBTI_NEED(rbti_lies(h, h->at_alpha_coordinate, h->n_alpha_grid, 1, 1, 8), RBT_OFFSETS);
    RBTI_NEED(rbti_lies(h, h->at_speed_coordinate, h->n_speed_grid, 1, 1, 8), RBT_OFFSETS);
    RBTI_NEED(rbti_lies(h, h->at_normals, 257, 4, 1, 4), RBT_OFFSETS);
    RBTI_NEED(rbti_lies(h, h->at_alias, nodes, h->n_components, 1, 4), RBT_OFFSETS);
    RBTI_NEED(rbti_lies(h, h->at_first_of_class, nodes, h->n_classes, 1, 2), RBT_OFFSETS);
    /* a draw reads eight numbers at once, up to seven behind the last record */
    RBTI_NEED(rbti_lies(h, h->at_components, nodes, h->n_components, h->stride, 2), RBT_OFFSETS);
    RBTI_NEED(rbti_lies(h, h->at_components, nodes * h->n_components * h->stride + RBTI_LANES, 1, 1,
                        2),
              RBT_OFFSETS);
    RBTI_NEED(rbti_lies(h, h->at_spans, cells, functions, 2, 8), RBT_OFFSETS);
    RBTI_NEED(rbti_lies(h, h->at_quantiles, cells, functions, h->n_knots, 8), RBT_OFFSETS);
    return RBT_OK;
}

static int rbti_axis_holds(const rbt_axis *a, double largest)
{
    const int one = a->first == a->last;
    return rbti_finite(a->first) && rbti_finite(a->last) && rbti_finite(a->origin) &&
           rbti_finite(a->scale) && 0.0 < a->first && a->first <= a->last && a->last <= largest &&
           a->origin <= a->first && a->scale >= 0.0 && (a->nodes == 1) == one &&
           (a->scale > 0.0 || (one && a->origin == a->first && a->offset == 0)) &&
           (a->last - a->origin) * a->scale <= (a->grid - 1.0) * (1.0 + 1e-9);
}

static int rbti_check_axes(const rbt_table *table)
{
    RBTI_NEED(rbti_axis_holds(&table->alpha, RBTI_HALF_PI * (1.0 + RBTI_ROUNDING)), RBT_AXES);
    RBTI_NEED(rbti_axis_holds(&table->speed, DBL_MAX), RBT_AXES);
    RBTI_NEED(rbti_finite(table->variate_max) && table->variate_max >= 1e-3 &&
                  table->variate_max <= 1e6,
              RBT_AXES);
    return RBT_OK;
}

/* Whether the coordinate at a value of the axis is a certain whole number, but for rounding. */
static int rbti_number_holds(const rbt_axis *axis, double value, double number)
{
    const double last = axis->grid - 1.0;
    double position = (value - axis->origin) * axis->scale;
    position = position < last ? position : last;
    const int32_t k = (int32_t)position < axis->grid - 2 ? (int32_t)position : axis->grid - 2;
    const double below = axis->coordinate[k];
    const double found = below + (position - k) * (axis->coordinate[k + 1] - below);
    return fabs(found - number) <= 0.02;
}

static int rbti_coordinate_holds(const rbt_axis *axis)
{
    const double *values = axis->coordinate;
    int holds = 1;
    for (int32_t k = 0; k < axis->grid && holds; k++) {
        holds = rbti_finite(values[k]) && fabs(values[k]) <= 1e6;
        if (axis->scale > 0.0)
            holds = holds && (k == 0 || values[k] > values[k - 1]);
        else
            holds = holds && values[k] == 0.0;
    }
    const double first = axis->offset, last = first + axis->nodes - 1.0;
    return holds && (axis->scale == 0.0 || (rbti_number_holds(axis, axis->first, first) &&
                                            rbti_number_holds(axis, axis->last, last)));
}

static int rbti_check_normals(const float *normals)
{
    for (int row = 0; row < 257; row++) {
        double sum = 0.0;
        for (int k = 0; k < 4; k++) {
            const double number = (double)normals[4 * row + k];
            RBTI_NEED(rbti_finite(number), RBT_NORMALS);
            sum += fabs(number);
        }
        RBTI_NEED(sum <= 16.0, RBT_NORMALS);
    }
    return RBT_OK;
}

static int rbti_check_classes(const rbt_table *table, size_t nodes)
{
    const size_t classes = (size_t)table->n_classes;
    for (size_t node = 0; node < nodes; node++) {
        const uint16_t *first = table->first_of_class + node * classes;
        RBTI_NEED(first[0] == 0, RBT_CLASSES);
        for (size_t k = 0; k < classes; k++)
            RBTI_NEED(first[k] <= table->n_components && (k == 0 || first[k] >= first[k - 1]),
                      RBT_CLASSES);
    }
    return RBT_OK;
}

static int rbti_check_components(const rbt_table *table, size_t components)
{
    for (size_t k = 0; k < components; k++) {
        const int16_t *record = table->components + k * (size_t)table->stride;
        RBTI_NEED(record[0] >= 0 && record[0] <= 4096, RBT_COMPONENTS);
        const int16_t *diagonal = record + 1 + table->n_channels;
        for (int32_t left = table->n_channels; left > 0; left--) {
            RBTI_NEED(*diagonal > 0, RBT_COMPONENTS);
            diagonal += left;
        }
    }
    return RBT_OK;
}

/* Every quantile finite and, of v, u_hat, w_hat and energy_hat, within what is physical. */
static int rbti_check_spans(const rbt_table *table, size_t groups)
{
    for (int32_t row = 0; row < table->n_channels; row++) {
        const int channel = table->channels[row];
        const int share = channel == 0 || channel == 6, even = channel == 1 || channel == 3;
        if (table->marginals[row] < 0)
            continue;
        for (size_t k = 0; k < groups; k++) {
            const double *span =
                table->spans + 2 * (k * (size_t)table->n_marginals + (size_t)table->marginals[row]);
            const double least = span[0], most = span[0] + span[1] * (65535.0 * (1.0 + 1e-6));
            RBTI_NEED(rbti_finite(least) && rbti_finite(span[1]) && rbti_finite(most), RBT_SPANS);
            RBTI_NEED(span[1] >= 0.0, RBT_SPANS);
            RBTI_NEED(!(share || even) || (least > (share ? 0.0 : -1.0) && most < 1.0), RBT_SPANS);
        }
    }
    return RBT_OK;
}

static int rbti_check_quantiles(const rbt_table *table, size_t functions)
{
    const size_t numbers = 4 * (size_t)table->n_knots;
    for (size_t k = 0; k < functions; k++) {
        const uint16_t *steps = table->quantiles + k * numbers;
        unsigned falls = 0;
        for (size_t m = 4; m < numbers; m++)
            falls |= steps[m] < steps[m - 4];
        RBTI_NEED(!falls, RBT_QUANTILES);
    }
    return RBT_OK;
}

static int rbti_check_values(const rbt_table *table, const rbti_header *header)
{
    const size_t nodes = (size_t)rbti_nodes(header);
    const size_t components = nodes * header->n_components;
    const size_t groups = (size_t)rbti_cells(header) * header->n_classes;
    RBTI_NEED(rbti_coordinate_holds(&table->alpha), RBT_COORDINATES);
    RBTI_NEED(rbti_coordinate_holds(&table->speed), RBT_COORDINATES);
    int code = rbti_check_normals(table->normals);
    for (size_t k = 0; k < components && code == RBT_OK; k++)
        code = (table->alias[k] & 0xffffu) < header->n_components ? RBT_OK : RBT_ALIAS;
    if (code == RBT_OK)
        code = rbti_check_classes(table, nodes);
    if (code == RBT_OK)
        code = rbti_check_components(table, components);
    if (code == RBT_OK)
        code = rbti_check_spans(table, groups);
    return code == RBT_OK ? rbti_check_quantiles(table, groups * header->n_marginals) : code;
}

static void rbti_fill_axis(rbt_axis *axis, const double ends_origin_scale[4], int32_t offset,
                           uint32_t nodes, uint32_t grid)
{
    axis->first = ends_origin_scale[0];
    axis->last = ends_origin_scale[1];
    axis->low = axis->first * (1.0 - RBTI_ROUNDING);
    axis->high = axis->last * (1.0 + RBTI_ROUNDING);
    axis->origin = ends_origin_scale[2];
    axis->scale = ends_origin_scale[3];
    axis->offset = offset;
    axis->nodes = (int32_t)nodes;
    axis->grid = (int32_t)grid;
}

static void rbti_fill_table(rbt_table *table, const rbti_header *h)
{
    const double alpha[4] = {h->alpha_first, h->alpha_last, h->alpha_origin, h->alpha_scale};
    const double speed[4] = {h->speed_first, h->speed_last, h->speed_origin, h->speed_scale};
    rbti_fill_axis(&table->alpha, alpha, h->alpha_offset, h->n_alpha, h->n_alpha_grid);
    rbti_fill_axis(&table->speed, speed, h->speed_offset, h->n_speed, h->n_speed_grid);
    if (h->flags & RBTI_SPEED_INDEPENDENT) { /* any that is positive and finite */
        table->speed.low = 1e-300;
        table->speed.high = 1e300;
    }
    table->variate_max = h->variate_max;
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
    for (uint32_t row = 0; row < RBT_VALUES; row++) {
        const int channel = h->channels[row];
        const int mirrored = channel >= RBTI_FIRST_MIRRORED && channel < RBTI_END_MIRRORED;
        table->units[0][row] = RBTI_UNIT;
        table->units[1][row] = mirrored ? -RBTI_UNIT : RBTI_UNIT;
    }
    memcpy(table->pair, h->pair, sizeof table->pair);
    table->pair[sizeof table->pair - 1] = 0;
}

/* Let a table read the arrays of an image at some address. */
static void rbti_point(rbt_table *table, const rbti_header *h, const char *image)
{
    table->image = image;
    table->alpha.coordinate = (const double *)(const void *)(image + h->at_alpha_coordinate);
    table->speed.coordinate = (const double *)(const void *)(image + h->at_speed_coordinate);
    table->normals = (const float *)(const void *)(image + h->at_normals);
    table->alias = (const uint32_t *)(const void *)(image + h->at_alias);
    table->first_of_class = (const uint16_t *)(const void *)(image + h->at_first_of_class);
    table->components = (const int16_t *)(const void *)(image + h->at_components);
    table->spans = (const double *)(const void *)(image + h->at_spans);
    table->quantiles = (const uint16_t *)(const void *)(image + h->at_quantiles);
}

/* Check an image and fill a table from it. */
static int rbti_read(const char *image, size_t size, rbt_table *table)
{
    rbti_header header;
    memset(table, 0, sizeof *table);
    int code = rbti_check_start(image, size, &header);
    if (code == RBT_OK)
        code = rbti_check_sum(image, size, &header);
    if (code == RBT_OK)
        code = rbti_check_dimensions(&header);
    if (code == RBT_OK)
        code = rbti_check_names(&header);
    if (code == RBT_OK)
        code = rbti_check_offsets(&header);
    if (code != RBT_OK)
        return code;
    table->image_size = size;
    rbti_fill_table(table, &header);
    code = rbti_check_axes(table);
    if (code != RBT_OK)
        return code;
    rbti_point(table, &header, image);
    return rbti_check_values(table, &header);
}

RBT_API int rbt_open_memory(const void *image, size_t size, rbt_table **table)
{
    *table = NULL;
    if ((uintptr_t)image % 64 != 0)
        return RBT_OFFSETS;
    rbt_table *made = (rbt_table *)malloc(sizeof *made);
    if (!made)
        return RBT_NO_MEMORY;
    const int code = rbti_read((const char *)image, size, made);
    if (code == RBT_OK)
        *table = made;
    else
        free(made);
    return code;
}

#ifdef RBTI_MMAP

RBT_API int rbt_open(const char *path, rbt_table **table)
{
    *table = NULL;
    const int file = open(path, O_RDONLY);
    if (file < 0)
        return RBT_NOT_OPENED;
    struct stat about;
    if (fstat(file, &about) != 0 || !S_ISREG(about.st_mode)) {
        close(file);
        return RBT_NOT_READ;
    }
    if (about.st_size <= 0 || about.st_size >= (off_t)RBTI_MOST_BYTES) {
        close(file);
        return about.st_size <= 0 ? RBT_FORMAT : RBT_SIZE;
    }
    const size_t size = (size_t)about.st_size;
    void *image = mmap(NULL, size, PROT_READ, MAP_PRIVATE, file, 0);
    close(file);
    if (image == MAP_FAILED)
        return RBT_NOT_READ;
    const int code = rbt_open_memory(image, size, table);
    if (code == RBT_OK)
        (*table)->to_unmap = image;
    else
        munmap(image, size);
    return code;
}

#else

/* Read a whole file to an address that is a multiple of 64. */
static int rbti_read_file(FILE *file, void **memory, char **image, size_t *size)
{
    if (fseek(file, 0, SEEK_END) != 0)
        return RBT_NOT_READ;
    const long end = ftell(file);
    if (end < 0 || fseek(file, 0, SEEK_SET) != 0)
        return RBT_NOT_READ;
    if ((unsigned long)end >= RBTI_MOST_BYTES)
        return RBT_SIZE;
    *size = (size_t)end;
    *memory = malloc(*size + 64);
    if (!*memory)
        return RBT_NO_MEMORY;
    *image = (char *)*memory + (64 - (uintptr_t)*memory % 64) % 64;
    return fread(*image, 1, *size, file) == *size ? RBT_OK : RBT_NOT_READ;
}

RBT_API int rbt_open(const char *path, rbt_table **table)
{
    *table = NULL;
    FILE *file = fopen(path, "rb");
    if (!file)
        return RBT_NOT_OPENED;
    void *memory = NULL;
    char *image = NULL;
    size_t size = 0;
    int code = rbti_read_file(file, &memory, &image, &size);
    fclose(file);
    if (code == RBT_OK)
        code = rbt_open_memory(image, size, table);
    if (code == RBT_OK)
        (*table)->to_free = memory;
    else
        free(memory);
    return code;
}

#endif

RBT_API void rbt_close(rbt_table *table)
{
    if (!table)
        return;
#ifdef RBTI_MMAP
    if (table->to_unmap)
        munmap(table->to_unmap, table->image_size);
#endif
    free(table->to_free);
    free(table);
}

RBT_API const char *rbt_strerror(int code)
{
    switch (code) {
    case RBT_OK:
        return "fine";
    case RBT_CLAMPED:
        return "alpha1 or speed outside the table: its nearest condition was used";
    case RBT_NOT_FINITE:
        return "arguments: allowed: finite numbers, speeds below 1e150 m/s";
    case RBT_NOT_APPROACHING:
        return "alpha1: allowed: above 0, at most pi/2 rad; velocity: allowed: towards the wall, "
               "(velocity - wall_velocity) . normal < 0";
    case RBT_SPEED_NOT_POSITIVE:
        return "speed: allowed: above 0 m/s; velocity: allowed: other than that of the wall";
    case RBT_NORMAL_NOT_USABLE:
        return "normal: allowed: any length but zero";
    case RBT_HALF_SIZE_NOT_POSITIVE:
        return "half_size: allowed: above 0 m";
    case RBT_NOT_OPENED:
        return "file: cannot be opened, allowed: a file that exists";
    case RBT_NOT_READ:
        return "file: cannot be read";
    case RBT_NO_MEMORY:
        return "memory: not enough for this table";
    case RBT_BIG_ENDIAN:
        return "machine: is big-endian, allowed: little-endian";
    case RBT_FORMAT:
        return "format: is no image of a rebound table (.rbt)";
    case RBT_VERSION:
        return "format_version: allowed: 1.x (a newer file needs a newer rebound-tables)";
    case RBT_SIZE:
        return "file_bytes: the file is truncated, or longer than it says";
    case RBT_CHECKSUM:
        return "sha256: the contents do not have this checksum";
    case RBT_DIMENSIONS:
        return "dimensions: one is 0 or too large, or does not fit the others";
    case RBT_NAMES:
        return "names: a channel or column is unknown, occurs twice or lacks what it is made of";
    case RBT_OFFSETS:
        return "offsets: an array does not lie in the file on a multiple of 64";
    case RBT_AXES:
        return "axes: allowed: finite, growing, angles above 0 to pi/2, speeds above 0";
    case RBT_COORDINATES:
        return "coordinates: allowed: growing, whole at the first and the last node";
    case RBT_NORMALS:
        return "normals: allowed: finite cubics below 16";
    case RBT_ALIAS:
        return "alias: a component is not below their number";
    case RBT_CLASSES:
        return "first_of_class: allowed: from 0, non-decreasing, at most the number of components";
    case RBT_COMPONENTS:
        return "components: allowed: reflection from 0 to 4096, diagonals positive";
    case RBT_SPANS:
        return "spans: allowed: finite and within what is physical";
    case RBT_QUANTILES:
        return "quantiles: allowed: non-decreasing from knot to knot";
    default:
        return "unknown code";
    }
}

/* -- queries ------------------------------------------------------------------------------------ */

RBT_API void rbt_alpha_range(const rbt_table *table, double range[2])
{
    range[0] = table->alpha.first;
    range[1] = table->alpha.last;
}

RBT_API void rbt_speed_range(const rbt_table *table, double range[2])
{
    range[0] = table->speed.first;
    range[1] = table->speed.last;
}

RBT_API int rbt_components(const rbt_table *table, int columns[RBT_VALUES])
{
    for (int k = 0; k < RBT_VALUES && columns; k++)
        columns[k] = table->columns[k];
    return table->n_columns;
}

RBT_API const char *rbt_pair(const rbt_table *table)
{
    return table->pair;
}

RBT_API const void *rbt_image(const rbt_table *table, size_t *size)
{
    *size = table->image_size;
    return table->image;
}

RBT_API rbt_table rbt_moved(const rbt_table *table, const void *copy)
{
    rbti_header header;
    rbt_table moved = *table;
    memcpy(&header, table->image, sizeof header);
    rbti_point(&moved, &header, (const char *)copy);
    moved.to_free = moved.to_unmap = NULL;
    return moved;
}

#ifdef __cplusplus
}
#endif

#if defined(__GNUC__) && !defined(__clang__) && !defined(__CUDACC__)
#pragma GCC pop_options
#endif

#endif /* REBOUND_SAMPLER_IMPLEMENTATION */
