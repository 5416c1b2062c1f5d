/* -- the implementation ---------------------------------------------------------------------------

   Names with rbti_ and RBTI_ are internal. The formulae are those of tables/FORMAT.md, "A draw" and "The
   spin law". In the sources each section is a file of sampler/c/src; sampler/c/build.py puts them
   together.

   How a draw goes:

     step                              first impact       with a spin        on spheres
     rows of the call                  sample, rebound    sample, rebound    sample, rebound
     facet, angle, speed, spin         rough, frame       rough, frame       rough, frame
     errors and flags                  nodes              spin               spin
     random words and normal numbers   words              words              -
     grain of the particle             -                  grains             -
     where the law is stored           nodes: node        conditions: leaf   sphere: laws of contact
     part of the mixture               nodes: component   experts: expert    -
     normal numbers to scores          nodes              experts            -
     quantiles, state                  nodes              outcomes           sphere
     back to the lab frame             rebound            rebound            rebound

   What to change for what:

     to change                                section
     a random number, its key or its block    words
     which grain a particle is                grains
     the range of the table, errors, flags    nodes, spin; their texts: sampler/errors.py
     the law of first impacts                 nodes
     the spin law                             conditions, experts, outcomes; order of steps: spin_draw
     a law of contact of spheres              sphere
     roughness                                rough; from a profile: walls
     direct simulation behind the calls       direct
     the format of binary tables              layout, check, read; sampler/formats/binary_layout.py
     opening files, memory                    open, checksum
     sizes, torque of the gas, deposits       sizes, gas, walls
     sums by wall face                        faces
     compilers and processors                 prelude
     the library of Python                    sampler/c/library.c */

#if defined(REBOUND_SAMPLER_IMPLEMENTATION) && !defined(REBOUND_SAMPLER_IMPLEMENTED)
#define REBOUND_SAMPLER_IMPLEMENTED

#ifndef RBT_DEVICE_ONLY
#include <fenv.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#if defined(__unix__) || defined(__APPLE__)
#define RBTI_POSIX 1
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#endif
#if defined(RBTI_POSIX) && !defined(RBT_NO_MMAP)
#define RBTI_MMAP 1
#include <sys/mman.h>
#else
#include <stdio.h>
#endif
#endif

/* Some machines and flags cannot give the bits of other machines, and are refused. */
#if !defined(RBT_DEVICE_ONLY) && (FLT_EVAL_METHOD == 1 || FLT_EVAL_METHOD == 2)
#error "rebound_sampler.h: this compiler computes with more digits than the types have (x87), so draws \
would differ from those of other machines. For 32-bit x86 compile with: -msse2 -mfpmath=sse"
#endif
#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
#error "rebound_sampler.h: this machine is big-endian, and binary tables are little-endian. Draw on a \
little-endian machine (x86-64, AArch64, RISC-V, ppc64le)"
#endif

/* Fusing a multiplication with an addition would change the last bit of states, so it is turned off. */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__) && !defined(RBTI_GPU)
#pragma GCC push_options
#pragma GCC optimize("fp-contract=off")
#endif

/* If RBT_API is static, a program leaves some functions unused. */
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#endif

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define RBTI_INLINE static inline __attribute__((always_inline))
#define RBTI_NOT_INLINED static __attribute__((noinline)) /* keeps its stack frame out of callers */
#define RBTI_ALIGNED __attribute__((aligned(64)))
#elif defined(RBTI_GPU)
#define RBTI_INLINE static __forceinline__
#define RBTI_NOT_INLINED static __noinline__
#define RBTI_ALIGNED
#else
#define RBTI_INLINE static inline
#define RBTI_NOT_INLINED static
#define RBTI_ALIGNED
#endif

/* On a host such a function is compiled once, which saves compilation time; on a device it is inlined. */
#if defined(RBTI_GPU)
#define RBTI_ONCE_ON_HOST RBTI_INLINE
#else
#define RBTI_ONCE_ON_HOST RBTI_NOT_INLINED
#endif

/* Versions of a function for processors with wide vectors, whatever flags the program is compiled with:
   batches then take half the time. RBTI_CLONES declares a function of which the loader takes the version.
   RBTI_BLOCK_VERSION declares one that draws a block of rows by the function NAME_body; without AVX2, rows
   are drawn one by one. Only first impacts gain from AVX-512. */
#if !defined(RBT_NO_CLONES) && defined(__x86_64__) && defined(__linux__) && defined(__GLIBC__) &&  \
    !defined(RBTI_GPU) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#if defined(__clang__) ? __clang_major__ >= 18 : defined(__GNUC__) && __GNUC__ >= 12
#define RBTI_CLONES static __attribute__((target_clones("avx2", "default"))) /* never inlined */
#define RBTI_BLOCK_VERSION(NAME, END, LEVEL, PARAMETERS, ARGUMENTS)                                \
    static __attribute__((target(LEVEL))) void NAME##END PARAMETERS { NAME##_body ARGUMENTS; }
#define RBTI_DRAWS_BLOCKS() __builtin_cpu_supports("avx2")
#endif
#endif
#ifndef RBTI_CLONES
#define RBTI_CLONES RBTI_NOT_INLINED
#define RBTI_BLOCK_VERSION(NAME, END, LEVEL, PARAMETERS, ARGUMENTS)                                \
    RBTI_NOT_INLINED void NAME##END PARAMETERS { NAME##_body ARGUMENTS; }
#define RBTI_DRAWS_BLOCKS() 1
#define RBTI_NO_VERSIONS 1
#endif

#if defined(__GNUC__) && !defined(RBTI_GPU)
#define RBTI_PREFETCH(place) __builtin_prefetch(place)
#else
#define RBTI_PREFETCH(place) ((void)(place))
#endif

/* -- numbers of the law ------------------------------------------------------------------------ */

#define RBTI_HALF_PI 1.5707963267948966
#define RBTI_ROOT_HALF 0.7071067811865476
#define RBTI_TWO_PI 6.283185307179586
#define RBTI_UNIT (1.0f / 4096.0f) /* unit of the numbers of a record */
#define RBTI_NORMAL_IMPACT 1e-12   /* tangential speed over V below which an impact is normal */
#define RBTI_LEAST_SPEED 1e-150    /* m/s; the square of a smaller speed would be 0 */

/* numbers of the spin law, from sampler/formats/bounds.py */
/* begin spin */
#define RBTI_INPUTS 9
#define RBTI_DIRECTIONS 4
#define RBTI_FEATURES 59
#define RBTI_OUTCOMES 7
#define RBTI_MOST_OUTCOMES 8
#define RBTI_GROUPS 8
#define RBTI_GROUP_SIZE 8
#define RBTI_KAPPA_QUANTILES 33
#define RBTI_SPIN_CORE 0.3
#define RBTI_PLACE_CORE 0.03
#define RBTI_LEAST_WOBBLE 1e-06
#define RBTI_WOBBLE 2.4
#define RBTI_RISE 8.0
#define RBTI_TILT_CORE 0.02
#define RBTI_LEAST_TILT 0.001
#define RBTI_ROUND_CORE 0.02
#define RBTI_LEAST_TAKEN 0.001
#define RBTI_LEAST_LEFT 1e-06
#define RBTI_EQUAL_MOMENTS 1e-09
#define RBTI_SINGLE_ROUNDING 1.2e-07
#define RBTI_INERTIA_ROUNDING 1e-06
#define RBTI_FOLD 0.1
#define RBTI_LEAST_RATIO 0.001
#define RBTI_SCORE_MAX 6.0f
#define RBTI_PER_SQUARE 0.027777778f
#define RBTI_GATE_UNIT (1.0f / 512.0f)
#define RBTI_MEAN_UNIT (1.0f / 2048.0f)
#define RBTI_FACTOR_UNIT (1.0f / 4096.0f)
#define RBTI_SLOW_TAIL_SHIFT 15.146f
#define RBTI_SLOW_TAIL_SQUARE 196.0f
#define RBTI_SLOW_TAIL_FACTOR 3.0f
#define RBTI_SLOW_TAIL_CORE 2.5f
/* rows of a draw: inputs, with the squared spin that trees compare, and outcomes */
enum { RBTI_IN_ROOT_ANGLE, RBTI_IN_SPEED, RBTI_IN_SIGMA_X, RBTI_IN_SIGMA_Y, RBTI_IN_SIGMA_Z,
       RBTI_IN_SLIP, RBTI_IN_PLACE, RBTI_IN_SQUARE, RBTI_IN_B_A, RBTI_IN_C_B, RBTI_IN_ROWS };
enum { RBTI_OUT_P_U, RBTI_OUT_P_V, RBTI_OUT_P_W, RBTI_OUT_O_X, RBTI_OUT_O_Y, RBTI_OUT_O_Z,
       RBTI_OUT_H, RBTI_OUT_A };
/* end spin */
#define RBTI_LOG2_E 1.4426950408889634f
#define RBTI_LOG_2 0.6931471805599453f
#define RBTI_SIMULATION_KEY 0x53494d554c415445u

/* NaN, made from its bits, since -ffast-math removes other ways to write it. */
RBTI_INLINE RBT_DEVICE double rbti_nan(void)
{
    const uint64_t bits = 0x7ff8000000000000u;
    double nan;
    memcpy(&nan, &bits, sizeof nan);
    return nan;
}

/* Whether a number is finite. -ffast-math removes isfinite(), so this looks at the bits. */
RBTI_INLINE RBT_DEVICE int rbti_finite(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return (bits & 0x7ff0000000000000u) != 0x7ff0000000000000u;
}

/* Whether a number lies outside a range by more than rounding to single precision can explain. The range
   of every argument is checked by this function, so that asinf(1), which is a little above pi/2, is
   head-on. */
RBTI_INLINE RBT_DEVICE int rbti_is_outside(double x, double least, double most)
{
    return (x < least * (1.0 - RBTI_SINGLE_ROUNDING)) | (x > most * (1.0 + RBTI_SINGLE_ROUNDING));
}

/* Limit a number to a range. NaN becomes `least`. */
RBTI_INLINE RBT_DEVICE double rbti_bounded(double x, double least, double most)
{
    return x > least ? (x < most ? x : most) : least;
}
