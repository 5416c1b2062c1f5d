/* rebound_sampler.h - rebounds of non-spherical particles, drawn from a table, in C.

   One file of one C program or library says

       #define REBOUND_SAMPLER_IMPLEMENTATION
       #include "rebound_sampler.h"

   and any others include the header alone. C99, C++11 or later, CUDA or HIP; needs libc and libm, and
   in device code nothing. rebound_device.h has kernels for arrays.

       rbt_table *table;
       int code = rbt_open("corundum-steel.rbt", &table);
       if (code < 0) { fprintf(stderr, "%s\n", rbt_strerror(code)); exit(1); }
       double state[6];
       code = rbt_draw(table, 0.5, 150.0, NULL, seed, particle, hits, state);
       rbt_close(table);

   The file is what `sampler export T.h5 --output T.rbt` writes. Equal arguments give the states
   that the Python package gives, with the same bits whatever the compiler flags and the processor,
   and rebounds, spheres and round grains to the last digits of the C library's functions; but with
   -ffast-math, clang's -ffp-contract=fast, and on CUDA devices without -fmad=false, the same to
   rounding in single precision.

   Angles are in radians, everything else in SI units. A state is u, v, w over V and omega_x,
   omega_y, omega_z times a/V (V: impact speed, a: largest half-size of the particle) in the frame
   of the impact: x along the tangential velocity before impact, y along the wall normal into the
   gas. Variables that a table leaves out are 0.

   Threads: a table is never written after it was opened, and a draw is a pure function of its
   arguments that allocates nothing. Any number of threads may use one table at once; rbt_open and
   rbt_close of one table must not run beside other calls with it.

   Return values: negative is an error with nothing written; else a sum of the flags RBT_CLAMPED and
   RBT_EXTRAPOLATED, 0 if there is none. rbt_strerror says what each means. Test for an error with
   code < 0 and for a flag with code & RBT_CLAMPED; count both, as rbt_report does, and tell your user.
   Nothing is printed. A table of a law that does not depend on the speed covers every speed.

   Part of rebound-tables; MIT licence. */

#ifndef REBOUND_SAMPLER_H
#define REBOUND_SAMPLER_H

#if defined(__CUDACC__) || defined(__HIPCC__) || defined(__HIP__)
#define RBTI_GPU 1 /* a compiler of programs for host and device */
#endif

/* Without the functions that only the host can have, which a compiler that knows no host (NVRTC,
   HIPRTC) must not see. */
#if !defined(RBT_DEVICE_ONLY) && (defined(__CUDACC_RTC__) || defined(__HIPCC_RTC__))
#define RBT_DEVICE_ONLY
#endif

#if defined(__CUDACC_RTC__) /* has no headers, and size_t of its own */
typedef signed char int8_t;
typedef unsigned char uint8_t;
typedef short int16_t;
typedef unsigned short uint16_t;
typedef int int32_t;
typedef unsigned int uint32_t;
typedef unsigned long long uint64_t;
#elif !defined(__HIPCC_RTC__)
#include <stddef.h>
#include <stdint.h>
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Functions that may be called on a device too; empty but in CUDA and HIP. */
#ifndef RBT_DEVICE
#if defined(RBTI_GPU)
#define RBT_DEVICE __host__ __device__
#else
#define RBT_DEVICE
#endif
#endif

/* Where the memory of tables comes from: define both to have it from elsewhere. */
#ifndef RBT_MALLOC
#define RBT_MALLOC(size) malloc(size)
#define RBT_FREE(memory) free(memory)
#endif

/* How functions are declared; define as `static` to keep them within one file. */
#ifndef RBT_API
#define RBT_API extern
#endif

/* Version of this library; codes that functions return, on which rbt_strerror says more; most
   variables that a state can have. Written by
   `python -m sampler.formats.generated_code`, as are all parts between such marks. */
/* begin constants */
#define RBT_VERSION_MAJOR 1
#define RBT_VERSION_MINOR 0
#define RBT_OK 0
#define RBT_CLAMPED 1
#define RBT_EXTRAPOLATED 2
#define RBT_ERR_NOT_FINITE (-1)
#define RBT_ERR_NOT_APPROACHING (-2)
#define RBT_ERR_SPEED_NOT_POSITIVE (-3)
#define RBT_ERR_NORMAL_NOT_USABLE (-4)
#define RBT_ERR_HALF_SIZE_NOT_POSITIVE (-5)
#define RBT_ERR_TILT_NOT_FOUND (-6)
#define RBT_ERR_CASCADE_NOT_ENDED (-7)
#define RBT_ERR_ROUGHNESS_NOT_USABLE (-8)
#define RBT_ERR_NO_SPIN_LAW (-9)
#define RBT_ERR_NOT_OPENED (-10)
#define RBT_ERR_NOT_READ (-11)
#define RBT_ERR_NO_MEMORY (-12)
#define RBT_ERR_BIG_ENDIAN (-13)
#define RBT_ERR_FORMAT (-14)
#define RBT_ERR_VERSION (-15)
#define RBT_ERR_SIZE (-16)
#define RBT_ERR_CHECKSUM (-17)
#define RBT_ERR_DIMENSIONS (-18)
#define RBT_ERR_NAMES (-19)
#define RBT_ERR_OFFSETS (-20)
#define RBT_ERR_AXES (-21)
#define RBT_ERR_COORDINATES (-22)
#define RBT_ERR_NORMALS (-23)
#define RBT_ERR_ALIAS (-24)
#define RBT_ERR_CLASSES (-25)
#define RBT_ERR_COMPONENTS (-26)
#define RBT_ERR_SPANS (-27)
#define RBT_ERR_QUANTILES (-28)
#define RBT_ERR_GRAINS (-29)
#define RBT_ERR_TREES (-30)
#define RBT_ERR_LEAVES (-31)
#define RBT_ERR_GRAIN_NOT_KNOWN (-32)
#define RBT_VALUES 10 /* u, v, w, omega_x, omega_y, omega_z, rotational_energy, collisions,
                        work_normal, work_shear */
#define RBTI_CHANNELS 9 /* in which these are stored */
#define RBTI_NAMES 8 /* most of either that a table has */
/* end constants */

/* Largest roughness of a wall, rad: beyond it a normal law of tilts describes no surface. */
#define RBT_MOST_ROUGHNESS 0.5

/* A result that must not be ignored, where compilers can say so. */
#if defined(__GNUC__)
#define RBT_MUST_USE __attribute__((warn_unused_result))
#else
#define RBT_MUST_USE
#endif

/* A table in memory. Its fields are for the functions below. */
typedef struct rbt_table rbt_table;

#ifndef RBT_DEVICE_ONLY

/* Open a binary table (.rbt) and check everything in it, its checksum included.

   The file is mapped where the system can do that, so that all programs of a machine share one copy
   in memory, and read otherwise. A mapped file must not be overwritten in place while it is open, as
   cp and rsync --inplace do: draws would be wrong, or the program would end (SIGBUS). `sampler export`
   and mv put a new file in its place, which is safe. With RBT_NO_MMAP the file is read into memory.

   On success *table belongs to the caller, who ends it with rbt_close. On an error *table is NULL.
   A folder, pipe or device is refused at once. */
RBT_API RBT_MUST_USE int rbt_open(const char *path, rbt_table **table);

/* The same for the bytes of such a file in memory, at an address that is a multiple of 64. The bytes
   stay the caller's, and must not change or go before rbt_close. */
RBT_API RBT_MUST_USE int rbt_open_memory(const void *image, size_t size, rbt_table **table);

/* End a table; NULL is allowed. */
RBT_API void rbt_close(rbt_table *table);

/* One line on a return code; a constant string, never NULL. */
RBT_API const char *rbt_strerror(int code);

#endif

/* Range of the table: impact angles in rad, impact speeds in m/s; {smallest, largest}. Spheres
   rebound by their laws of contact beyond it as well. */
RBT_API RBT_DEVICE void rbt_alpha_range(const rbt_table *table, double range[2]);
RBT_API RBT_DEVICE void rbt_speed_range(const rbt_table *table, double range[2]);

/* Impact speeds, m/s, at which the law of the material pair was measured: beyond them it is
   extrapolated. {0, 1e300} if the table does not say. */
RBT_API RBT_DEVICE void rbt_valid_speed(const rbt_table *table, double range[2]);

/* Whether the table has a spin law, the law of particles that arrive spinning, which depends on their
   spin and on their grain, a shape and its ratios: 1 or 0. */
RBT_API RBT_DEVICE int rbt_has_spin_law(const rbt_table *table);

/* Whether a particle keeps its grain from hit to hit, the one of (seed, index), as it does unless told
   otherwise; with 0 it has another one at each hit, and a rebound without omega is from the law of first
   impacts. Must not run beside other calls with the table. */
RBT_API RBT_DEVICE void rbt_keep_grains(rbt_table *table, int kept);

/* Grain with which a particle meets a wall in the spin law: code of the shape (0 ellipsoid, 1 prism,
   2 truncated prism, 3 tetrahedron, 4 sphere, from 6 on meshes), b/a and c/b. `hit` counts only if
   grains are not kept. RBT_OK or RBT_ERR_NO_SPIN_LAW. */
RBT_API RBT_DEVICE int rbt_grain(const rbt_table *table, uint64_t seed, uint64_t index,
                                 uint32_t hit, double grain[3]);

/* The grain of a particle that has another one at each hit. RBT_OK or RBT_ERR_NO_SPIN_LAW. */
RBT_API RBT_DEVICE int rbt_fresh_grain(const rbt_table *table, uint64_t seed, uint64_t index,
                                       uint32_t hit, double grain[3]);

/* Grains of n particles that keep them, 3 n numbers. RBT_OK or RBT_ERR_NO_SPIN_LAW. */
RBT_API RBT_DEVICE int rbt_grains_batch(const rbt_table *table, size_t n, uint64_t seed,
                                        const uint64_t *index, double *grains);

/* Variables that the table gives: how many, and which (0: u, ... 9: work of tangential impulses).
   Others are 0 in every state. `columns` may be NULL. */
RBT_API RBT_DEVICE int rbt_components(const rbt_table *table, int columns[RBT_VALUES]);

/* Name of the material pair, UTF-8; lives as long as the table. */
RBT_API RBT_DEVICE const char *rbt_pair(const rbt_table *table);

/* Draw one state.

   alpha1: impact angle from the wall, in (0, pi/2]. speed: impact speed V > 0. spin: angular
   velocity before the impact times a/V, in the frame of the impact, three numbers; NULL: the law of
   first impacts, of particles of any grain that do not spin. (seed, index, hit): seed of the run, identity of the particle,
   and how many walls it has met before; they select the random numbers.

   RBT_OK, flags, or RBT_ERR_NOT_FINITE, RBT_ERR_NOT_APPROACHING,
   RBT_ERR_SPEED_NOT_POSITIVE, RBT_ERR_NO_SPIN_LAW. */
RBT_API RBT_DEVICE int rbt_draw(const rbt_table *table, double alpha1, double speed,
                                const double *spin, uint64_t seed, uint64_t index, uint32_t hit,
                                double state[6]);

/* Draw all variables that a table can have, of a given grain, three numbers as rbt_grain gives them;
   NULL: as rbt_draw. With a grain and without spin the particle does not spin. A draw with the keys of
   a rebound, at its angle, speed and spin, has the works of that rebound. Codes as rbt_draw; also
   RBT_ERR_GRAIN_NOT_KNOWN. */
RBT_API RBT_DEVICE int rbt_draw_all(const rbt_table *table, double alpha1, double speed,
                                    const double *spin, const double *grain, uint64_t seed,
                                    uint64_t index, uint32_t hit, double values[RBT_VALUES]);

#ifndef RBT_DEVICE_ONLY

/* Report of a batch. Rows count from 0; a row that there is none of is the number of rows. Counts are
   of the rows before the error if there is one. */
typedef struct rbt_report {
    size_t row;              /* first row with an error */
    size_t clamped_row;      /* first row with RBT_CLAMPED */
    size_t clamped;          /* number of them */
    size_t extrapolated;     /* number of rows with RBT_EXTRAPOLATED */
    size_t extrapolated_row; /* first of them */
} rbt_report;

/* Draw n states, row by row into states[6 * n]: the same as n calls of rbt_draw with (alpha1[k],
   speed[k], spin + 3 k, seed, index[k], hit[k]), and faster, because many draws wait for memory
   together. spin has 3 n numbers, or is NULL.

   RBT_OK, the flags of any row, or the code of the first row with an error; then rows before it may be
   written, rows from it on are not. `report` may be NULL. */
RBT_API int rbt_draw_batch(const rbt_table *table, size_t n, const double *alpha1,
                           const double *speed, const double *spin, uint64_t seed,
                           const uint64_t *index, const uint32_t *hit, double *states,
                           rbt_report *report);

/* Conditions of a batch of draws: arrays of n numbers, of 3 n where they are vectors. Begin with all
   fields 0, as `= {0}` does: later versions may have further ones, for which that means "none". */
typedef struct rbt_conditions {
    const double *alpha1;  /* n: impact angles from the wall, rad */
    const double *speed;   /* n: impact speeds V, m/s */
    const double *spin;    /* 3 n: angular velocities before the impact times a/V; NULL: the law of
                              first impacts, of any grain */
    const double *grain;   /* 3 n: shape code, b/a and c/b; NULL: the grains of the keys */
    const uint64_t *index; /* n: identities of the particles */
    const uint32_t *hit;   /* n: how many walls they have met before */
    int fresh_grains;      /* 1: a particle has another grain at each hit; 0: one, of (seed, index) */
} rbt_conditions;

/* Draw n states of the table's own variables (rbt_components): n rows of so many numbers into `states`
   or, in single precision, into `singles`; the other is NULL. All else as rbt_draw_batch; also
   RBT_ERR_GRAIN_NOT_KNOWN. */
RBT_API int rbt_sample_batch(const rbt_table *table, size_t n, const rbt_conditions *conditions,
                             uint64_t seed, double *states, float *singles, rbt_report *report);

#endif

/* Rebound one particle, in the lab frame.

   velocity, wall_velocity: of particle and wall at the contact, m/s; a wall_velocity of NULL is a
   wall at rest. normal: from the wall into the gas, any length but zero. half_size: largest
   half-size a of the particle, 1e-30 m or more. omega: angular velocity before the impact, rad/s;
   NULL: the particle does not spin, the same as zeros; but with rbt_keep_grains(table, 0), and of a
   table without a spin law, from the law of first impacts, of any grain. new_velocity, new_omega:
   velocity, m/s, and angular velocity, rad/s, after the rebound; they may be velocity and omega
   themselves. At exactly normal impact the direction along the wall is uniform.

   Codes as rbt_draw; also RBT_ERR_NORMAL_NOT_USABLE, RBT_ERR_HALF_SIZE_NOT_POSITIVE. */
RBT_API RBT_DEVICE int rbt_rebound(const rbt_table *table, const double velocity[3],
                                   const double normal[3], double half_size,
                                   const double wall_velocity[3], const double omega[3],
                                   uint64_t seed, uint64_t index, uint32_t hit,
                                   double new_velocity[3], double new_omega[3]);

/* Works of the impulses of that rebound, of the same arguments: energies in J for each kg of the
   particle that impulses along the normal and along the wall take, zeros without works in the table.
   Codes as rbt_rebound. Not for a rough wall, where there are several rebounds. */
RBT_API RBT_DEVICE int rbt_works(const rbt_table *table, const double velocity[3],
                                 const double normal[3], double half_size,
                                 const double wall_velocity[3], const double omega[3],
                                 uint64_t seed, uint64_t index, uint32_t hit, double works[2]);

/* Standard deviation of the tilt of facets, rad, of a rough wall with a measured profile: for the
   `roughness` of the functions below.

   ra, rq: mean and root mean square of the height, rsm: mean width of the profile's elements (ISO
   21920-2, ISO 4287); diameter: of the particle; all four in the same unit. *tilt becomes atan(2 ra /
   rsm) if diameter < rsm / sin(atan(2 ra / rsm)), else atan(2 rq / rsm): a particle that is small
   beside the elements meets their flanks. Source: Sommerfeld & Huber, Int. J. Multiphase Flow 25
   (1999) 1457-1489, as codes take it.

   RBT_OK, RBT_ERR_NOT_FINITE, or RBT_ERR_ROUGHNESS_NOT_USABLE: ra or rq negative, rsm or diameter not
   positive, or a tilt beyond 0.5 rad. rq below ra, which no profile has, is not refused. */
RBT_API RBT_DEVICE int rbt_wall_tilt(double ra, double rq, double rsm, double diameter,
                                     double *tilt);

/* Rebound one particle from a rough wall, in the lab frame.

   roughness: standard deviation of the tilt of facets, rad, from 0, a smooth wall, to 0.5. The
   particle meets a facet whose normal is tilted at random in the plane of incidence, as it sees
   them: by their projected area, none in the shadow of others. A particle that a facet sends back into the
   wall meets further facets within the same hit, with the spin that the one before has left. normal is
   that of the mean wall; all others as rbt_rebound.

   Codes as rbt_rebound, with the flags of any facet. Also
   RBT_ERR_ROUGHNESS_NOT_USABLE; RBT_ERR_TILT_NOT_FOUND and RBT_ERR_CASCADE_NOT_ENDED, with
   probabilities below 1e-50 and 1e-30 a hit. */
RBT_API RBT_DEVICE int rbt_rough_rebound(const rbt_table *table, const double velocity[3],
                                         const double normal[3], double half_size,
                                         const double wall_velocity[3], double roughness,
                                         const double omega[3], uint64_t seed, uint64_t index,
                                         uint32_t hit, double new_velocity[3],
                                         double new_omega[3]);

/* Rebound one particle of a given grain: as rbt_rough_rebound, and with a grain of NULL and 0 for
   isotropic the same; 1: facets are also tilted across the plane of incidence, with the same standard
   deviation. A roughness of 0 is a smooth wall. Also RBT_ERR_GRAIN_NOT_KNOWN. */
RBT_API RBT_DEVICE int rbt_rebound_grain(const rbt_table *table, const double velocity[3],
                                         const double normal[3], double half_size,
                                         const double wall_velocity[3], double roughness,
                                         int isotropic, const double omega[3],
                                         const double grain[3], uint64_t seed, uint64_t index,
                                         uint32_t hit, double new_velocity[3],
                                         double new_omega[3]);

#ifndef RBT_DEVICE_ONLY

/* Impacts of a batch of rebounds: arrays of n numbers, of 3 n where they are vectors. Begin with
   all fields 0, as `= {0}` does: later versions may have further ones, for which that means
   "none". */
typedef struct rbt_impacts {
    const double *velocity;      /* 3 n: of the particles at the contact, m/s */
    const double *normal;        /* 3 n: from the wall into the gas, any length but zero */
    const double *half_size;     /* n: largest half-sizes a, m */
    const double *wall_velocity; /* 3 n: of the wall at the contact, m/s; NULL: walls at rest */
    const uint64_t *index;       /* n: identities of the particles */
    const uint32_t *hit;         /* n: how many walls they have met before */
    const double *omega;         /* 3 n: angular velocities before the impact, rad/s; NULL: as zeros,
                                    but with fresh grains the law of first impacts */
    const double *roughness;     /* n: standard deviations of the tilt of facets, rad, 0 to 0.5; NULL:
                                    smooth walls */
    const double *grain;         /* 3 n: shape code, b/a and c/b; NULL: the grains of the keys. With
                                    grains and without omega particles do not spin */
    int fresh_grains;            /* 1: a particle has another grain at each hit; 0: one, of (seed,
                                    index), unless rbt_keep_grains says otherwise */
    int isotropic;               /* 1: facets of rough walls are tilted across the plane of incidence
                                    as well; 0: in it only */
} rbt_impacts;

/* Rebound n particles: the same as n calls of rbt_rebound, or of rbt_rough_rebound, and faster.
   new_velocity and new_omega have 3 n numbers; they may be impacts->velocity and impacts->omega. Any
   number of threads may share out the rows of an array: each calls with its part of the arrays.

   RBT_OK, the flags of any row, or the code of the first row with an error; then the rows before it
   are written, and rows from it on are not. `report` may be NULL. */
RBT_API int rbt_rebound_batch(const rbt_table *table, size_t n, const rbt_impacts *impacts,
                              uint64_t seed, double *new_velocity, double *new_omega,
                              rbt_report *report);

#endif

/* Torque of the gas on a spinning particle, N m, and the angular velocity, rad/s, that it leaves after
   a time, s; omega: as a rebound gives it, the mean over the particle's tumbling.

   diameter: of the sphere of equal volume, m; density, kg/m3, and viscosity, Pa s: of the gas; all
   above 0. gas_rotation: half the curl of the gas velocity, rad/s; NULL: 0. The torque is that on a
   sphere that turns in a gas at rest,

       (density / 2) (diameter / 2)^5 C |slip| slip,  slip = gas_rotation - omega,
       C = 64 pi / Re below Re = density diameter^2 |slip| / viscosity = 32,
       C = 12.9 / sqrt(Re) + 128.4 / Re from there on

   (Dennis, Singh & Ingham, J. Fluid Mech. 101 (1980) 257-279), up to Re = 1000; beyond, the formula
   extrapolates. For grains that feel another multiple of the torque, divide the inertia by it.

   inertia: moment of inertia, kg m2; mass diameter^2 / 10 for a sphere. omega decays along the law
   exactly, so time steps of any size give the same, and never overshoots. A negative time goes back,
   to Re = 1e6 at most. Results may be the same arrays as omega. */
RBT_API RBT_DEVICE void rbt_gas_torque(const double omega[3], double diameter, double density,
                                       double viscosity, const double gas_rotation[3],
                                       double torque[3]);
RBT_API RBT_DEVICE void rbt_spin_after(const double omega[3], double time, double inertia,
                                       double diameter, double density, double viscosity,
                                       const double gas_rotation[3], double new_omega[3]);

/* -- sizes, and particles that stay on the wall --

   Largest half-size, m, of a grain (rbt_grain) whose volume is that of a sphere of a diameter, m; 0: a
   mesh, whose volume nobody knows. And its mean over the particles of a table; 0: a table without a
   spin law, or with meshes. */
RBT_API RBT_DEVICE double rbt_half_size(double diameter, const double grain[3]);
RBT_API RBT_DEVICE double rbt_mean_half_size(const rbt_table *table, double diameter);

/* Whether a particle that meets a wall stays there: 1, if it approaches at less than a critical normal
   speed, m/s; else 0. Ask before the draw. Arguments as of rbt_rebound; with NaN it is 0. */
RBT_API RBT_DEVICE int rbt_deposits(const double velocity[3], const double normal[3],
                                    double critical_speed, const double wall_velocity[3]);

/* An axis of the node grid, rad or m/s. A value from low to high is inside: the ends with the rounding
   of a unit conversion. coordinate[grid] is the fractional number of the node at equal steps from
   origin on, scale of them per rad or m/s; offset is the number of the first of the nodes. */
typedef struct rbt_axis {
    double first, last, low, high, origin, scale;
    int32_t offset, nodes, grid;
    const double *coordinate;
} rbt_axis;

/* The spin law. The arrays and their units are those of tables/FORMAT.md. */
typedef struct rbt_spin_law {
    int32_t n_shapes, n_nodes, n_leaves, n_knots, n_outcomes; /* 0 shapes: no law */
    int32_t fresh_grains; /* whether a particle has another grain at each hit */
    int32_t for_first;    /* whether it stands for the law of first impacts, of another population */
    double least_spin, most_spin; /* squares of the sizes of the spin that it covers */
    double alpha_first, alpha_last, alpha_low, alpha_high;
    double speed_first, speed_last, speed_low, speed_high, speed_scale, speed_exponent;
    double aspect[8];
    const int32_t *shape_codes;
    const double *shape_shares, *shape_ratios, *shape_inertia; /* the last may be NULL */
    const int32_t *roots;
    const int8_t *node_axis;
    const double *node_cut;
    const int32_t *node_child;
    const float *inputs;
    const int16_t *group_gates, *gates, *experts;
    const float *spans;
    const uint16_t *quantiles;
} rbt_spin_law;

struct rbt_table {
    rbt_axis alpha, speed;
    rbt_spin_law spin;
    double valid_speed[2], least_inertia;
    double variate_max, variate_scale;
    int32_t n_knots, n_components, n_classes, n_channels, n_marginals, n_columns, stride;
    int32_t spheres; /* whether rebounds follow from laws of contact; then there are no nodes */
    int32_t n_laws;  /* numbers of them; 0: none */
    const double *laws;
    int8_t channels[RBTI_NAMES], marginals[RBTI_NAMES], columns[RBTI_NAMES];
    uint32_t held; /* bits of the variables among the columns */
    int8_t mirrored[RBTI_NAMES]; /* whether reflection turns the sign of a row of a factor */
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
   table whose draws read a copy of them at another address, a multiple of 64, to be passed by value. */
RBT_API RBT_DEVICE const void *rbt_image(const rbt_table *table, size_t *size);
RBT_API RBT_DEVICE rbt_table rbt_moved(const rbt_table *table, const void *copy);

/* Table of an image that rbt_open would accept, or has accepted, where there is only the image, at an
   address that is a multiple of 64: nothing is checked. */
RBT_API RBT_DEVICE rbt_table rbt_unchecked(const void *image, size_t size);

#ifdef __cplusplus
}
#endif

#endif /* REBOUND_SAMPLER_H */

/* ---------------------------------------------------------------------------------------------- */

#if defined(REBOUND_SAMPLER_IMPLEMENTATION) && !defined(REBOUND_SAMPLER_IMPLEMENTED)
#define REBOUND_SAMPLER_IMPLEMENTED

#ifndef RBT_DEVICE_ONLY
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

/* No multiplication is fused with an addition, so that states have the bits of Python's. */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__) && !defined(RBTI_GPU)
#pragma GCC push_options
#pragma GCC optimize("fp-contract=off")
#endif

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define RBTI_INLINE static inline __attribute__((always_inline))
#define RBTI_APART static __attribute__((noinline)) /* its memory is no other function's burden */
#define RBTI_ALIGNED __attribute__((aligned(64)))
#elif defined(RBTI_GPU)
#define RBTI_INLINE static __forceinline__
#define RBTI_APART static __noinline__
#define RBTI_ALIGNED
#else
#define RBTI_INLINE static inline
#define RBTI_APART static
#define RBTI_ALIGNED
#endif

/* Versions of a function for processors with wide vectors; the loader takes the one for the processor
   at hand: batches take half the time, whatever flags the program is compiled with. */
#if !defined(RBT_NO_CLONES) && defined(__x86_64__) && defined(__linux__) && defined(__GLIBC__) &&  \
    !defined(RBTI_GPU) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#if defined(__clang__) && __clang_major__ >= 18
#define RBTI_CLONES __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))
#define RBTI_APART_CLONES RBTI_CLONES static /* clang inlines none anyway */
#elif !defined(__clang__) && defined(__GNUC__) && __GNUC__ >= 12
#define RBTI_CLONES                                                                                \
    __attribute__((optimize("O3", "fp-contract=off"),                                              \
                   target_clones("arch=x86-64-v4", "avx2", "default")))
#endif
#endif
#ifndef RBTI_CLONES
#define RBTI_CLONES
#endif
#ifndef RBTI_APART_CLONES
#define RBTI_APART_CLONES RBTI_CLONES RBTI_APART
#endif

#if defined(__GNUC__) && !defined(RBTI_GPU)
#define RBTI_PREFETCH(place) __builtin_prefetch(place)
#else
#define RBTI_PREFETCH(place) ((void)(place))
#endif

/* -- numbers of the law ------------------------------------------------------------------------ */

#define RBTI_HALF_PI 1.5707963267948966
#define RBTI_TWO_PI 6.283185307179586
#define RBTI_ROUNDING 1e-12
#define RBTI_UNIT (1.0f / 4096.0f) /* of the numbers of a record */
#define RBTI_NORMAL_IMPACT 1e-12
#define RBTI_LEAST_HALF_SIZE 1e-30 /* m, and m/s: beyond them squares and quotients overflow */
#define RBTI_LEAST_SPEED 1e-150

/* numbers of the spin law, from sampler/formats/bounds.py */
/* begin spin */
#define RBTI_CONDITIONS 5
#define RBTI_INPUTS 7
#define RBTI_FEATURES 23
#define RBTI_OUTCOMES 6
#define RBTI_MOST_OUTCOMES 8
#define RBTI_GROUPS 8
#define RBTI_GROUP_SIZE 16
#define RBTI_INERTIA 0.6666666666666666
#define RBTI_LEAST_RATIO 0.001
#define RBTI_LEAST_FLATNESS 0.002
#define RBTI_LEAST_REST 1e-06
#define RBTI_MOST_POWER 20.0
#define RBTI_SCORE_MAX 6.0f
#define RBTI_PER_SQUARE 0.027777778f
#define RBTI_GATE_UNIT (1.0f / 512.0f)
#define RBTI_MEAN_UNIT (1.0f / 2048.0f)
#define RBTI_FACTOR_UNIT (1.0f / 4096.0f)
/* end spin */
#define RBTI_LOG2_E 1.4426950408889634f
#define RBTI_SIMULATION_KEY 0x53494d554c415445u

/* Not isfinite(), which some compiler flags remove. */
RBTI_INLINE RBT_DEVICE int rbti_finite(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return (bits & 0x7ff0000000000000u) != 0x7ff0000000000000u;
}

/* -- the first-impact draw -----------------------------------------------------------------------

   The law of particles that arrive without spin. A table has nodes of impact angle and speed, and a cell
   between each four of them. A node has a mixture of components, each of one of the classes of
   rebounds. The arrays are those of tables/FORMAT.md, "Binary table", the steps those of "A draw":

     words  rbti_fill_words        Philox4x32-10 of (seed, index, hit)
     1      rbti_locate            cell of the condition, weights of its nodes
     2      rbti_choose_node       one of the four nodes, by word 1
     3      rbti_choose_component  one of its components, by word 0, and the class of it
     4      rbti_fill_normals      words to normals n
            rbti_mix               variates mean + L n, reflected or not, to places among knots
     5      rbti_fill_channel      quantiles at these places, averaged over the nodes
            rbti_to_states         channels to variables of the state

   Each step is written once, for m draws side by side; the compiler knows m, which is 1 for a
   single draw and RBTI_BLOCK for a batch. A step is a loop over arrays of fixed length without
   branches, which compilers turn into vector instructions. Memory that it reads at scattered places
   was prefetched by the step before, so that the draws of a block wait for memory together.
   Number k of draw r of an array stands at k m + r. */

#if defined(RBTI_GPU)
#define RBTI_BLOCK ((size_t)1) /* threads of a device draw one by one, with little memory each */
#else
#define RBTI_BLOCK ((size_t)32)
#endif
#define RBTI_EACH_DRAW(r) for (size_t r = 0; r < m; r++)

typedef struct rbti_draws {
    double alpha1[RBTI_BLOCK], speed[RBTI_BLOCK];
    uint32_t words[12 * RBTI_BLOCK];
    double alpha_weight[RBTI_BLOCK], speed_weight[RBTI_BLOCK];
    float weights[4 * RBTI_BLOCK]; /* of the nodes of the cell */
    int32_t alpha_node[RBTI_BLOCK], speed_node[RBTI_BLOCK];
    int32_t record[RBTI_BLOCK];    /* first number of the mixture component's record */
    int32_t functions[RBTI_BLOCK]; /* first quantile function of the cell and class */
    float values[RBTI_NAMES * RBTI_BLOCK];    /* normals, then fractions, by row of the factor */
    int32_t entries[RBTI_NAMES * RBTI_BLOCK]; /* quantiles at the knot below, by row */
    double channels[RBTI_CHANNELS * RBTI_BLOCK];
} rbti_draws;

/* RBT_EXTRAPOLATED at a speed at which the pair was not measured, else 0. */
RBTI_INLINE RBT_DEVICE int rbti_extrapolates(const rbt_table *table, double speed)
{
    const int off = (speed < table->valid_speed[0]) | (speed > table->valid_speed[1]);
    return off * RBT_EXTRAPOLATED;
}

RBTI_INLINE RBT_DEVICE int rbti_status(const rbt_table *table, double alpha1, double speed)
{
    if (!(rbti_finite(alpha1) && rbti_finite(speed)))
        return RBT_ERR_NOT_FINITE;
    const int flags = rbti_extrapolates(table, speed);
    if (alpha1 >= table->alpha.low && alpha1 <= table->alpha.high && speed >= table->speed.low &&
        speed <= table->speed.high)
        return flags;
    if (alpha1 <= 0.0 || alpha1 > RBTI_HALF_PI + RBTI_ROUNDING)
        return RBT_ERR_NOT_APPROACHING;
    return speed <= 0.0 ? RBT_ERR_SPEED_NOT_POSITIVE : RBT_CLAMPED | flags;
}

/* Uniform number in (0, 1) from a random word. */
RBTI_INLINE RBT_DEVICE double rbti_uniform(uint32_t word)
{
    return ((double)word + 0.5) * (1.0 / 4294967296.0);
}

/* Four random words of each draw, Philox4x32-10. A block that is not full repeats its last draw. */
RBTI_INLINE RBT_DEVICE void rbti_fill_words(size_t m, uint32_t block, uint64_t seed,
                                            const uint64_t *index, const uint32_t *hit,
                                            size_t count, uint32_t *words)
{
    uint32_t *c0 = words, *c1 = words + m, *c2 = words + 2 * m, *c3 = words + 3 * m;
    uint32_t key0 = (uint32_t)seed, key1 = (uint32_t)(seed >> 32);
    RBTI_EACH_DRAW(r) {
        const size_t k = r < count ? r : count - 1;
        c0[r] = (uint32_t)index[k];
        c1[r] = (uint32_t)(index[k] >> 32);
        c2[r] = hit[k];
        c3[r] = block;
    }
    for (int round = 0; round < 10; round++) {
        RBTI_EACH_DRAW(r) {
            const uint64_t p0 = (uint64_t)c0[r] * 0xD2511F53u, p1 = (uint64_t)c2[r] * 0xCD9E8D57u;
            c0[r] = (uint32_t)(p1 >> 32) ^ c1[r] ^ key0;
            c1[r] = (uint32_t)p1;
            c2[r] = (uint32_t)(p0 >> 32) ^ c3[r] ^ key1;
            c3[r] = (uint32_t)p0;
        }
        key0 += 0x9E3779B9u;
        key1 += 0xBB67AE85u;
    }
}

/* Lower nodes of the cell on an axis; weights of the upper ones. */
RBTI_INLINE RBT_DEVICE void rbti_locate(size_t m, const rbt_axis *of, const double *values,
                                        int32_t *nodes, double *weights)
{
    const rbt_axis axis = *of;
    RBTI_EACH_DRAW(r) {
        double value = values[r] > axis.first ? values[r] : axis.first;
        value = value < axis.last ? value : axis.last;
        double position = (value - axis.origin) * axis.scale;
        position = position > 0.0 ? position : 0.0;
        position = position < axis.grid - 1.0 ? position : axis.grid - 1.0;
        int32_t k = (int32_t)position;
        k = k < axis.grid - 2 ? k : axis.grid - 2;
        const double below = axis.coordinate[k];
        const double x = below + (position - k) * (axis.coordinate[k + 1] - below);
        /* on an axis of one node both neighbours are that node, with weight 0 for the upper one */
        int32_t lower = (int32_t)x - axis.offset;
        lower = lower < axis.nodes - 2 ? lower : axis.nodes - 2;
        lower = lower > 0 ? lower : 0;
        const double most = axis.nodes > 1 ? 1.0 : 0.0;
        double rest = x - (lower + axis.offset);
        rest = rest > 0.0 ? rest : 0.0;
        weights[r] = rest < most ? rest : most;
        nodes[r] = lower;
    }
}

/* Weights of the four nodes; one of them with these weights, by the upper 20 bits of word 1; column
   of its alias table and place in it in units of 2^-16: integer and fractional part of word 0 times
   the number of columns over 2^32, in 32 bits. */
RBTI_INLINE RBT_DEVICE void rbti_choose_node(size_t m, const rbt_table *table, rbti_draws *d,
                                             int32_t *node, int32_t *column, uint32_t *fraction)
{
    const int32_t last_alpha = table->alpha.nodes - 1, last_speed = table->speed.nodes - 1;
    const uint32_t columns = (uint32_t)table->n_components;
    RBTI_EACH_DRAW(r) {
        const double t = d->alpha_weight[r], s = d->speed_weight[r];
        const double w0 = (1.0 - t) * (1.0 - s), w1 = (1.0 - t) * s, w2 = t * (1.0 - s);
        d->weights[r] = (float)w0;
        d->weights[m + r] = (float)w1;
        d->weights[2 * m + r] = (float)w2;
        d->weights[3 * m + r] = (float)(t * s);
        const double c = ((double)(int32_t)(d->words[m + r] >> 12) + 0.5) * (1.0 / 1048576.0);
        const double half = w0 + w1;
        const int32_t upper_alpha = c >= half;
        const double limit = upper_alpha ? half + w2 : w0;
        const int32_t upper_speed = c >= limit;
        const int32_t i = d->alpha_node[r] + upper_alpha, j = d->speed_node[r] + upper_speed;
        node[r] = (i < last_alpha ? i : last_alpha) * (last_speed + 1) +
                  (j < last_speed ? j : last_speed);
        const uint32_t word = d->words[r];
        const uint32_t product = (word >> 16) * columns + ((word & 0xffffu) * columns >> 16);
        fraction[r] = product & 0xffffu;
        column[r] = (int32_t)(product >> 16);
    }
}

/* One mixture component of the node, by the alias method, and its class. */
RBTI_INLINE RBT_DEVICE void rbti_choose_component(size_t m, const rbt_table *table, rbti_draws *d)
{
    const int32_t components = table->n_components, classes = table->n_classes;
    const int32_t cells_of_row = table->speed.nodes > 1 ? table->speed.nodes - 1 : 1;
    int32_t node[RBTI_BLOCK] RBTI_ALIGNED, column[RBTI_BLOCK] RBTI_ALIGNED;
    int32_t kind[RBTI_BLOCK] RBTI_ALIGNED, first[RBTI_BLOCK] RBTI_ALIGNED;
    uint32_t fraction[RBTI_BLOCK] RBTI_ALIGNED, entry[RBTI_BLOCK] RBTI_ALIGNED;
    rbti_choose_node(m, table, d, node, column, fraction);
    RBTI_EACH_DRAW(r)
        RBTI_PREFETCH(table->alias + node[r] * components + column[r]);
    RBTI_EACH_DRAW(r)
        entry[r] = table->alias[node[r] * components + column[r]];
    RBTI_EACH_DRAW(r) {
        const int32_t other = (int32_t)(entry[r] & 0xffffu);
        column[r] = fraction[r] >= entry[r] >> 16 ? other : column[r];
        kind[r] = 0;
    }
    for (int32_t k = 1; k < classes; k++) {
        RBTI_EACH_DRAW(r)
            first[r] = table->first_of_class[node[r] * classes + k];
        RBTI_EACH_DRAW(r)
            kind[r] = column[r] >= first[r] ? k : kind[r];
    }
    RBTI_EACH_DRAW(r) {
        const int32_t cell = d->alpha_node[r] * cells_of_row + d->speed_node[r];
        d->record[r] = (node[r] * components + column[r]) * table->stride;
        d->functions[r] = (cell * classes + kind[r]) * table->n_marginals;
    }
    RBTI_EACH_DRAW(r)
        RBTI_PREFETCH(table->components + d->record[r]);
}

/* Normal numbers from words by a table of cubics. The octave of the distance from the nearer end of the
   words is found by the exponent of a floating-point number, which unlike a count of leading zeros can be
   vectorised. */
RBTI_INLINE RBT_DEVICE void rbti_fill_normals(size_t m, const float *table, const uint32_t *words,
                                              float *normals)
{
    int32_t rows[RBTI_BLOCK] RBTI_ALIGNED;
    float t[RBTI_BLOCK] RBTI_ALIGNED, sign[RBTI_BLOCK] RBTI_ALIGNED;
    float cubic[4 * RBTI_BLOCK] RBTI_ALIGNED;
    RBTI_EACH_DRAW(r) {
        const int32_t upper = (int32_t)(words[r] >> 31);
        const uint32_t mask = (uint32_t)-upper;
        /* half the distance from the nearer end, in units of 2^-32: from 1/2 to 2^31 */
        float half = (float)(int32_t)((words[r] ^ mask) & 0x7fffffffu) + 0.5f;
        uint32_t bits;
        memcpy(&bits, &half, sizeof bits);
        rows[r] = (int32_t)(bits >> 20) - 8 * 126;
        bits = (bits << 3 & 0x7fffffu) | 0x3f800000u;
        memcpy(&half, &bits, sizeof half);
        t[r] = half - 1.0f;
        sign[r] = 1.0f - 2.0f * (float)upper;
    }
    RBTI_EACH_DRAW(r) {
        const float *row = table + 4 * rows[r];
        cubic[r] = row[0];
        cubic[m + r] = row[1];
        cubic[2 * m + r] = row[2];
        cubic[3 * m + r] = row[3];
    }
    RBTI_EACH_DRAW(r) {
        const float *c = cubic + r;
        normals[r] = sign[r] * (c[0] + t[r] * (c[m] + t[r] * (c[2 * m] + t[r] * c[3 * m])));
    }
}

/* Pairs of 16-bit numbers in the longest record, of 8 channels. */
#define RBTI_PAIRS 23

/* Records, number by number: factors[k][r] is number k of the record of draw r. */
RBTI_INLINE RBT_DEVICE void rbti_fill_factors(size_t m, const rbt_table *table, int32_t n,
                                              const int32_t *records, float *factors)
{
    const int32_t pairs = (2 + n + n * (n + 1) / 2) / 2;
    uint32_t raw[RBTI_PAIRS * RBTI_BLOCK] RBTI_ALIGNED;
    RBTI_EACH_DRAW(r) {
        const int16_t *record = table->components + records[r];
        for (int32_t k = 0; k < pairs; k++)
            memcpy(raw + (size_t)k * m + r, record + 2 * k, sizeof *raw);
    }
    for (size_t k = 0; k < (size_t)pairs; k++) {
        RBTI_EACH_DRAW(r) {
            const uint32_t pair = raw[k * m + r];
            factors[2 * k * m + r] = (float)((int32_t)(pair << 16) >> 16);
            factors[(2 * k + 1) * m + r] = (float)((int32_t)pair >> 16);
        }
    }
}

/* Normals to variates mean + L n, reflected or not, and these to fractions between knots. */
RBTI_INLINE RBT_DEVICE void rbti_mix(size_t m, const rbt_table *table, int32_t n, rbti_draws *d)
{
    const float variate_max = (float)table->variate_max, scale = (float)table->variate_scale;
    const float last = (float)(table->n_knots - 1);
    const int32_t last_but_one = table->n_knots - 2, knots = table->n_knots;
    float factors[2 * RBTI_PAIRS * RBTI_BLOCK] RBTI_ALIGNED;
    float unit[2 * RBTI_BLOCK] RBTI_ALIGNED;
    rbti_fill_factors(m, table, n, d->record, factors);
    RBTI_EACH_DRAW(r) {
        const float limit = (float)(int32_t)(d->words[m + r] & 4095u);
        unit[r] = RBTI_UNIT;
        unit[m + r] = limit < factors[r] ? -RBTI_UNIT : RBTI_UNIT;
    }
    for (int32_t row = n - 1; row >= 0; row--) {
        /* from the last row upwards, so that each row still finds the normals it needs */
        const float *units = table->mirrored[row] ? unit + m : unit;
        const float *factor = factors + (size_t)(1 + row) * m;
        float *values = d->values + (size_t)row * m;
        int32_t *entries = d->entries + (size_t)row * m;
        float z[RBTI_BLOCK] RBTI_ALIGNED;
        RBTI_EACH_DRAW(r)
            z[r] = factor[r];
        factor += (size_t)n * m;
        for (int32_t column = 0; column <= row; column++) {
            RBTI_EACH_DRAW(r)
                z[r] += factor[r] * d->values[(size_t)column * m + r];
            factor += (size_t)(n - column - 1) * m;
        }
        RBTI_EACH_DRAW(r) {
            float position = (z[r] * units[r] + variate_max) * scale;
            position = position > 0.0f ? position : 0.0f;
            position = position < last ? position : last;
            int32_t k = (int32_t)position;
            k = k < last_but_one ? k : last_but_one;
            values[r] = position - (float)k;
            entries[r] = ((d->functions[r] + table->marginals[row]) * knots + k) * 4;
        }
        if (table->marginals[row] >= 0) {
            RBTI_EACH_DRAW(r)
                RBTI_PREFETCH(table->quantiles + entries[r]);
        }
    }
}

/* Quantiles of one channel between knots, averaged over the four nodes. */
RBTI_INLINE RBT_DEVICE void rbti_fill_channel(size_t m, const rbt_table *table, int32_t row,
                                              const rbti_draws *d, double *channel)
{
    uint32_t raw[4 * RBTI_BLOCK] RBTI_ALIGNED;
    const float *fractions = d->values + (size_t)row * m;
    const int32_t *entries = d->entries + (size_t)row * m;
    double least[RBTI_BLOCK] RBTI_ALIGNED, step[RBTI_BLOCK] RBTI_ALIGNED;
    RBTI_EACH_DRAW(r) {
        uint32_t eight[4];
        memcpy(eight, table->quantiles + entries[r], sizeof eight);
        raw[r] = eight[0];
        raw[m + r] = eight[1];
        raw[2 * m + r] = eight[2];
        raw[3 * m + r] = eight[3];
    }
    RBTI_EACH_DRAW(r) {
        const double *span = table->spans + 2 * (d->functions[r] + table->marginals[row]);
        least[r] = span[0];
        step[r] = span[1];
    }
    RBTI_EACH_DRAW(r) {
        const float f = fractions[r];
        float mean[2];
        for (size_t half = 0; half < 2; half++) {
            const uint32_t low = raw[half * m + r], high = raw[(2 + half) * m + r];
            const float *weights = d->weights + 2 * half * m + r;
            const float low0 = (float)(int32_t)(low & 0xffffu);
            const float low1 = (float)(int32_t)(low >> 16);
            const float high0 = (float)(int32_t)(high & 0xffffu);
            const float high1 = (float)(int32_t)(high >> 16);
            mean[half] = weights[0] * (low0 + f * (high0 - low0)) +
                         weights[m] * (low1 + f * (high1 - low1));
        }
        channel[r] = least[r] + step[r] * (double)(mean[0] + mean[1]);
    }
}

/* The same in its place among the channels. In registers, which a device has in place of memory, no
   place can be looked up. */
RBTI_INLINE RBT_DEVICE void rbti_fill_place(size_t m, const rbt_table *table, int32_t row,
                                            rbti_draws *d)
{
#if defined(RBTI_GPU)
    double channel;
    rbti_fill_channel(m, table, row, d, &channel);
    for (int k = 0; k < RBTI_CHANNELS; k++)
        d->channels[k] = k == table->channels[row] ? channel : d->channels[k];
#else
    rbti_fill_channel(m, table, row, d, d->channels + (size_t)table->channels[row] * m);
#endif
}

/* Channels to variables of the state, as tables/FORMAT.md gives them: the first six, or all ten, of
   `count` draws. */
RBTI_INLINE RBT_DEVICE void rbti_to_states(size_t m, size_t count, int variables,
                                           const rbt_table *table, const rbti_draws *d,
                                           double *states)
{
    const double least = table->least_inertia;
    const double *v = d->channels, *u_hat = v + m, *omega_z = v + 2 * m, *w_hat = v + 3 * m;
    const double *omega_x = v + 4 * m, *omega_y = v + 5 * m;
    const double *energy_hat = v + 6 * m, *collisions = v + 7 * m, *normal_hat = v + 8 * m;
    double u[RBTI_BLOCK] RBTI_ALIGNED, w[RBTI_BLOCK] RBTI_ALIGNED, rest[RBTI_BLOCK] RBTI_ALIGNED;
    double normal[RBTI_BLOCK] RBTI_ALIGNED, left[RBTI_BLOCK] RBTI_ALIGNED;
    double shorter[RBTI_BLOCK] RBTI_ALIGNED;
    RBTI_EACH_DRAW(r) {
        const double n = normal_hat[r], square = n * n, fourth = square * square;
        const double x = omega_x[r], y = omega_y[r], z = omega_z[r];
        const double after_v = (1.0 - v[r]) * (1.0 + v[r]);
        /* the factor is exactly 1 where a table has no works */
        const double after_n = after_v * ((1.0 - n) * (1.0 + n) * (1.0 + square + fourth));
        normal[r] = fourth * square * after_v;
        rest[r] = after_n * ((1.0 - u_hat[r]) * (1.0 + u_hat[r]));
        u[r] = u_hat[r] * sqrt(after_n);
        w[r] = w_hat[r] * sqrt(rest[r]);
        left[r] = rest[r] * ((1.0 - w_hat[r]) * (1.0 + w_hat[r]));
        /* no rotation with more energy than is there, whatever the quantiles are; mostly exactly 1 */
        const double energy = left[r] + normal[r], turns = least * (x * x + y * y + z * z);
        shorter[r] = sqrt(energy / (turns > energy ? turns : energy));
    }
    for (size_t r = 0; r < count; r++) {
        double *state = states + (size_t)variables * r;
        state[0] = u[r];
        state[1] = v[r];
        state[2] = w[r];
        state[3] = omega_x[r] * shorter[r];
        state[4] = omega_y[r] * shorter[r];
        state[5] = omega_z[r] * shorter[r];
        if (variables > 6) {
            state[6] = energy_hat[r] * left[r];
            state[7] = floor(collisions[r]);
            state[8] = table->held >> 8 & 1u ? normal[r] : 0.0;
            state[9] = table->held >> 9 & 1u ? (1.0 - energy_hat[r]) * left[r] : 0.0;
        }
    }
}

/* Draws with conditions that may be drawn at; n is the number of channels. Words 8 and 11 belong to
   no channel: the azimuth of a normal impact is made of word 8. */
RBTI_INLINE RBT_DEVICE void rbti_take_steps(size_t m, const rbt_table *table, int32_t n,
                                            uint64_t seed, const uint64_t *index,
                                            const uint32_t *hit, size_t count, int variables,
                                            rbti_draws *d, double *states)
{
    const uint32_t blocks = n <= 2 ? 1 : n <= 6 ? 2 : 3;
    for (uint32_t block = 0; block < blocks; block++)
        rbti_fill_words(m, block, seed, index, hit, count, d->words + 4 * block * m);
    rbti_locate(m, &table->alpha, d->alpha1, d->alpha_node, d->alpha_weight);
    rbti_locate(m, &table->speed, d->speed, d->speed_node, d->speed_weight);
    rbti_choose_component(m, table, d);
    for (int32_t row = 0; row < n; row++)
        rbti_fill_normals(m, table->normals, d->words + (size_t)(row < 6 ? 2 + row : 3 + row) * m,
                          d->values + (size_t)row * m);
    rbti_mix(m, table, n, d);
    memset(d->channels, 0, RBTI_CHANNELS * m * sizeof *d->channels);
    for (int32_t row = 0; row < n; row++)
        if (table->marginals[row] >= 0)
            rbti_fill_place(m, table, row, d);
    rbti_to_states(m, count, variables, table, d, states);
}

#ifndef RBT_DEVICE_ONLY

/* The same with a number of channels that the compiler knows, for the commonest tables. */
RBTI_INLINE RBT_DEVICE void rbti_draw_block(size_t m, const rbt_table *table, uint64_t seed,
                                            const uint64_t *index, const uint32_t *hit,
                                            size_t count, int variables, rbti_draws *d,
                                            double *states)
{
    if (table->n_channels == 6)
        rbti_take_steps(m, table, 6, seed, index, hit, count, variables, d, states);
    else
        rbti_take_steps(m, table, table->n_channels, seed, index, hit, count, variables, d, states);
}

#endif

/* One draw from a table with any number of channels. It stands apart because it needs memory on a
   device; where the compiler knows the number of channels, registers are enough. */
RBTI_APART RBT_DEVICE void rbti_draw_any(const rbt_table *table, double alpha1, double speed,
                                         uint64_t seed, uint64_t index, uint32_t hit,
                                         int variables, double *state)
{
    rbti_draws draws;
    draws.alpha1[0] = alpha1;
    draws.speed[0] = speed;
    rbti_take_steps(1, table, table->n_channels, seed, &index, &hit, 1, variables, &draws, state);
}

/* -- spheres --------------------------------------------------------------------------------------

   A rebound of a sphere has a formula. Its laws of contact (tables/LAWS.md) are these numbers, then
   those of the law of restitution, then those of the law of resistance. A table begins with its numbers
   of angles and speeds, has these, and its values by angle. */
enum {
    RBTI_RESOLUTION, RBTI_RESTITUTION, RBTI_COEFFICIENT, RBTI_EXPONENT, RBTI_RESISTANCE,
    RBTI_STRENGTH, RBTI_FACTOR, RBTI_LENGTH, RBTI_NUMBERS
};
enum { RBTI_EXPONENTIAL, RBTI_POLYNOMIAL, RBTI_CONSTANT, RBTI_POWER, RBTI_TABULATED };
enum { RBTI_ORIENTATION, RBTI_CONSTANT_RESISTANCE, RBTI_TABULATED_RESISTANCE, RBTI_COULOMB };
#define RBTI_SPHERE_INERTIA 0.4
#define RBTI_MOBILITY 3.5 /* of the contact of a sphere, along the wall */
#define RBTI_GRAZING 0.0087 /* sine of the impact angle from which on the resolution is the whole */
#define RBTI_LEAST_ANGLE 1e-300

/* A number within bounds; the least of NaN. */
RBTI_INLINE RBT_DEVICE double rbti_bounded(double x, double least, double most)
{
    return x > least ? (x < most ? x : most) : least;
}

/* Lower one of two neighbours among growing numbers, and the weight of the other. */
RBTI_INLINE RBT_DEVICE int rbti_neighbour(const double *nodes, int count, double x, double *weight)
{
    int k = 0;
    while (k < count - 2 && nodes[k + 1] <= x)
        k++;
    *weight = count > 1 ? rbti_bounded((x - nodes[k]) / (nodes[k + 1] - nodes[k]), 0.0, 1.0) : 0.0;
    return k;
}

/* Value of a table: bilinear, constant beyond its ends. */
RBTI_INLINE RBT_DEVICE double rbti_tabulated(const double *table, double angle, double speed)
{
    const int n = (int)table[0], m = (int)table[1], right = m > 1;
    double p, q;
    const int i = rbti_neighbour(table + 2, n, angle, &p);
    const int j = rbti_neighbour(table + 2 + n, m, speed, &q);
    const double *low = table + 2 + n + m + i * m + j, *high = low + (n > 1 ? m : 0);
    return (1.0 - p) * ((1.0 - q) * low[0] + q * low[right]) +
           p * ((1.0 - q) * high[0] + q * high[right]);
}

/* Ratio of the normal contact velocities after and before, from 0 to 1 whatever the numbers are. */
RBTI_INLINE RBT_DEVICE double rbti_restitution(const double *law, double speed, double sine)
{
    const double c = law[RBTI_COEFFICIENT], exponent = law[RBTI_EXPONENT], angle = asin(sine);
    const int kind = (int)law[RBTI_RESTITUTION];
    double e = c;
    if (kind == RBTI_EXPONENTIAL)
        e = 1.0 + (exp(-c * pow(speed, exponent)) - 1.0) * sine;
    else if (kind == RBTI_POWER)
        e = c / pow(speed * sine, exponent);
    else if (kind == RBTI_TABULATED)
        e = rbti_tabulated(law + RBTI_NUMBERS, angle, speed);
    else if (kind == RBTI_POLYNOMIAL) {
        e = 0.0;
        for (int k = (int)law[RBTI_LENGTH] - 1; k >= 0; k--)
            e = e * angle + law[RBTI_NUMBERS + k];
    }
    return rbti_bounded(e, 0.0, 1.0);
}

/* Tangential impulse over minus the tangential contact velocity, of this size. `normal` is the normal
   impulse; `size` and `sine` are of the contact velocity, `ahead` is the sine of the impact angle. */
RBTI_INLINE RBT_DEVICE double rbti_pull(const rbt_table *table, double normal, double slide,
                                        double size, double sine, double ahead)
{
    const double *law = table->laws;
    const int kind = (int)law[RBTI_RESISTANCE], before = RBTI_NUMBERS + (int)law[RBTI_LENGTH];
    const double number =
        before < table->n_laws ? rbti_tabulated(law + before, asin(sine), 1.0) : 0.0;
    if (kind == RBTI_COULOMB) {
        const double back = (1.0 + rbti_bounded(number, -1.0, 1.0)) / RBTI_MOBILITY;
        return slide > 0.0 ? rbti_bounded(law[RBTI_FACTOR] * normal / slide, 0.0, back) : 0.0;
    }
    double c = kind == RBTI_TABULATED_RESISTANCE ? number : law[RBTI_FACTOR];
    if (kind == RBTI_ORIENTATION)
        c *= exp(law[RBTI_STRENGTH] * ahead);
    c = rbti_bounded(c, 0.0, 1e9) / size * normal;
    return c / (1.0 + 0.5 * RBTI_MOBILITY * c);
}

/* Rebound of a sphere: all variables of its state; spin may be NULL. The rotational energy is over all
   energy before, works are over m V^2 / 2. None is gained, whatever the numbers of the laws are. */
RBTI_INLINE RBT_DEVICE void rbti_sphere(const rbt_table *table, double alpha1, double speed,
                                        const double *spin, double values[RBT_VALUES])
{
    const double angle = rbti_bounded(alpha1, RBTI_LEAST_ANGLE, RBTI_HALF_PI);
    const double j = RBTI_SPHERE_INERTIA, *law = table->laws;
    const double x = spin ? spin[0] : 0.0, y = spin ? spin[1] : 0.0, z = spin ? spin[2] : 0.0;
    const double u = cos(angle), v = sin(angle), slide = sqrt((u + z) * (u + z) + x * x);
    const double size = sqrt(slide * slide + v * v), sine = v < size ? v / size : 1.0;
    const double bounce = rbti_restitution(law, speed * size, sine) * v;
    const double least = law[RBTI_RESOLUTION] * rbti_bounded(v / RBTI_GRAZING, 0.0, 1.0);
    const double away = bounce > least ? bounce : least;
    const double pull = rbti_pull(table, away + v, slide, size, sine, v);
    const double turn_x = x - pull / j * x, turn_z = z - pull / j * (u + z);
    const double energy = 1.0 + j * (x * x + y * y + z * z);
    const double found[RBT_VALUES] = {
        u - pull * (u + z), away, pull * x, turn_x, y, turn_z,
        j * (turn_x * turn_x + y * y + turn_z * turn_z) / energy, 1.0,
        (v - away) * (v + away), pull * (2.0 - pull * RBTI_MOBILITY) * slide * slide};
    memcpy(values, found, sizeof found);
}

/* The first variables of a sphere's state, those that the table has. */
RBTI_APART RBT_DEVICE void rbti_sphere_state(const rbt_table *table, double alpha1, double speed,
                                             const double *spin, int variables, double *state)
{
    double values[RBT_VALUES];
    rbti_sphere(table, alpha1, speed, spin, values);
    for (int k = 0; k < variables; k++)
        state[k] = (table->held >> k & 1u) ? values[k] : 0.0;
}

/* One draw of the first six or of all variables. */
RBTI_INLINE RBT_DEVICE int rbti_draw(const rbt_table *table, double alpha1, double speed,
                                     uint64_t seed, uint64_t index, uint32_t hit, int variables,
                                     double *state)
{
    const int status = rbti_status(table, alpha1, speed);
    if (status < RBT_OK)
        return status;
    if (table->spheres) {
        rbti_sphere_state(table, alpha1, speed, NULL, variables, state);
        return status;
    }
    if (table->n_channels != 6) {
        double values[RBT_VALUES]; /* whose address is known elsewhere, is in no register */
        rbti_draw_any(table, alpha1, speed, seed, index, hit, variables, values);
        for (int k = 0; k < variables; k++)
            state[k] = values[k];
        return status;
    }
    rbti_draws draws;
    draws.alpha1[0] = alpha1;
    draws.speed[0] = speed;
    rbti_take_steps(1, table, 6, seed, &index, &hit, 1, variables, &draws, state);
    return status;
}

/* -- the spin draw --------------------------------------------------------------------------------

   The law of particles that arrive spinning, given their spin and their grain: shape, b/a and c/b. Each
   shape has a tree of conditions; a leaf has 8 groups of 16 experts and the quantile functions of O = 6
   outcomes, p_u, p_v, p_w and omega_x, omega_y, omega_z times a/V_e, or of O = 8, with two for the
   works. The steps are those of tables/FORMAT.md, "The spin law":

     words  rbti_fill_words, rbti_fill_grains  random words; the grain, from words of its own
     1      rbti_fill_inputs     effective speed V_e = V (1 + 2/3 s^2)^(1/2), mirror image, conditions
     2      rbti_find_leaves     leaf of the shape's tree
     3      rbti_fill_features   1, inputs less the leaf's middle, products of two conditions
     4      rbti_choose_expert   a group, then an expert of it, with weights exp(gates . features)
     5      rbti_fill_scores     mean and factor of the expert: scores of O normals
     6      rbti_find_knots, rbti_fill_outcomes  bounded scores to outcomes by the leaf's quantiles
     7      rbti_to_spin_states  outcomes to the state, with no more energy than before, whatever the
                                 outcomes are

   Steps 3 to 6 are in single precision. Coefficients of a leaf or an expert that are multiplied by the
   features of a draw lie side by side in the table, and are taken draw by draw. The compiler knows O:
   it is written where a law is drawn from, and laws of 8 outcomes pay for them alone. */

/* Rows of the inputs of a draw: the conditions, the squared spin, which trees compare too, the ratios. */
#define RBTI_SQUARE RBTI_CONDITIONS
#define RBTI_RATIO (RBTI_CONDITIONS + 1)
#define RBTI_LINE 32 /* 16-bit numbers of a cache line */

typedef struct rbti_spin_draws {
    double alpha1[RBTI_BLOCK], speed[RBTI_BLOCK], spin[3 * RBTI_BLOCK];
    double inputs[(RBTI_INPUTS + 1) * RBTI_BLOCK];
    double factor[RBTI_BLOCK], turn[RBTI_BLOCK]; /* root of the energy before; -1: mirror image */
    double smallest[RBTI_BLOCK];                 /* moment of inertia of the grain, over m a^2 */
    uint32_t words[12 * RBTI_BLOCK];
    int32_t shape[RBTI_BLOCK], leaf[RBTI_BLOCK], group[RBTI_BLOCK], expert[RBTI_BLOCK];
    float features[RBTI_FEATURES * RBTI_BLOCK];
    float scores[RBTI_MOST_OUTCOMES * RBTI_BLOCK]; /* normals, then scores, then fractions of knots */
    int32_t entries[RBTI_MOST_OUTCOMES * RBTI_BLOCK];
    float outcomes[RBTI_MOST_OUTCOMES * RBTI_BLOCK];
} rbti_spin_draws;

/* Numbers of an expert with some outcomes, whole cache lines. */
RBTI_INLINE RBT_DEVICE size_t rbti_expert_stride(size_t outcomes)
{
    const size_t numbers = RBTI_FEATURES * outcomes + outcomes * (outcomes + 1) / 2;
    return (numbers + RBTI_LINE - 1) / RBTI_LINE * RBTI_LINE;
}

RBTI_INLINE RBT_DEVICE double rbti_spin_factor(double x, double y, double z)
{
    return sqrt(1.0 + RBTI_INERTIA * (x * x + y * y + z * z));
}

RBTI_INLINE RBT_DEVICE int rbti_spin_status(const rbt_table *table, double alpha1, double speed,
                                            double x, double y, double z)
{
    const rbt_spin_law *law = &table->spin;
    if (!(rbti_finite(alpha1) && rbti_finite(speed)))
        return RBT_ERR_NOT_FINITE;
    const double factor = rbti_spin_factor(x, y, z), effective = speed * factor;
    const double square = x * x + y * y + z * z;
    const int finite = rbti_finite(factor) && rbti_finite(effective);
    const int flags = rbti_extrapolates(table, speed);
    if (finite && law->n_shapes > 0 && alpha1 >= law->alpha_low && alpha1 <= law->alpha_high &&
        effective >= law->speed_low && effective <= law->speed_high &&
        square >= law->least_spin && square <= law->most_spin)
        return flags;
    if (alpha1 <= 0.0 || alpha1 > RBTI_HALF_PI + RBTI_ROUNDING)
        return RBT_ERR_NOT_APPROACHING;
    if (speed <= 0.0)
        return RBT_ERR_SPEED_NOT_POSITIVE;
    if (law->n_shapes == 0)
        return RBT_ERR_NO_SPIN_LAW;
    return finite ? RBT_CLAMPED | flags : RBT_ERR_NOT_FINITE;
}

RBTI_INLINE RBT_DEVICE double rbti_horner(const double c[8], double x)
{
    double sum = c[0];
    for (int k = 1; k < 8; k++)
        sum = sum * x + c[k];
    return sum;
}

/* Standard normal quantile, algorithm AS 241: for |p - 1/2| <= 0.425 in q = p - 1/2, and beyond. */
RBTI_INLINE RBT_DEVICE double rbti_central_quantile(double q)
{
    const double num[8] = {2.5090809287301226727e3, 3.3430575583588128105e4,
                           6.7265770927008700853e4, 4.5921953931549871457e4,
                           1.3731693765509461125e4, 1.9715909503065514427e3,
                           1.3314166789178437745e2, 3.3871328727963666080e0};
    const double den[8] = {5.2264952788528545610e3, 2.8729085735721942674e4,
                           3.9307895800092710610e4, 2.1213794301586595867e4,
                           5.3941960214247511077e3, 6.8718700749205790830e2,
                           4.2313330701600911252e1, 1.0};
    const double r = 0.180625 - q * q;
    return q * (rbti_horner(num, r) / rbti_horner(den, r));
}

RBTI_INLINE RBT_DEVICE double rbti_outer_quantile(double p)
{
    const double near_num[8] = {7.74545014278341407640e-4, 2.27238449892691845833e-2,
                                2.41780725177450611770e-1, 1.27045825245236838258e0,
                                3.64784832476320460504e0,  5.76949722146069140550e0,
                                4.63033784615654529590e0,  1.42343711074968357734e0};
    const double near_den[8] = {1.05075007164441684324e-9, 5.47593808499534494600e-4,
                                1.51986665636164571966e-2, 1.48103976427480074590e-1,
                                6.89767334985100004550e-1, 1.67638483018380384940e0,
                                2.05319162663775882187e0,  1.0};
    const double far_num[8] = {2.01033439929228813265e-7, 2.71155556874348757815e-5,
                               1.24266094738807843860e-3, 2.65321895265761230930e-2,
                               2.96560571828504891230e-1, 1.78482653991729133580e0,
                               5.46378491116411436990e0,  6.65790464350110377720e0};
    const double far_den[8] = {2.04426310338993978564e-15, 1.42151175831644588870e-7,
                               1.84631831751005468180e-5,  7.86869131145613259100e-4,
                               1.48753612908506148525e-2,  1.36929880922735805310e-1,
                               5.99832206555887937690e-1,  1.0};
    double r = sqrt(-log(p < 0.5 ? p : 1.0 - p));
    const int is_near = r <= 5.0;
    r -= is_near ? 1.6 : 5.0;
    const double tail = rbti_horner(is_near ? near_num : far_num, r) /
                        rbti_horner(is_near ? near_den : far_den, r);
    return p < 0.5 ? -tail : tail;
}

/* Ratios of one kind, b/a or c/b, from words. */
RBTI_INLINE RBT_DEVICE void rbti_fill_ratios(size_t m, const double law[4], const uint32_t *words,
                                             double *ratios)
{
    const double mean = law[0], deviation = law[1], low = law[2], high = law[3];
    double p[RBTI_BLOCK] RBTI_ALIGNED;
    RBTI_EACH_DRAW(r) {
        p[r] = low + rbti_uniform(words[r]) * (high - low);
        ratios[r] = rbti_central_quantile(p[r] - 0.5);
    }
    RBTI_EACH_DRAW(r)
        if (fabs(p[r] - 0.5) > 0.425 && deviation > 0.0)
            ratios[r] = rbti_outer_quantile(p[r]);
    RBTI_EACH_DRAW(r) {
        double ratio = deviation > 0.0 ? mean + deviation * ratios[r] : mean;
        /* no law that was simulated goes beyond; whatever stands in a file is finite so */
        ratio = ratio > RBTI_LEAST_RATIO ? ratio : RBTI_LEAST_RATIO;
        ratios[r] = ratio < 1.0 ? ratio : 1.0;
    }
}

/* Grains of the particles of a batch: given ones, or those of a seed. All bounces of one hit have the
   same, though each has a seed of its own. */
typedef struct rbti_grains {
    const double *given; /* 3 numbers a particle: shape code, b/a, c/b; NULL: grains of the seed */
    uint64_t seed;
    int fresh; /* whether a particle has another grain at each hit */
} rbti_grains;

/* Row of a shape among those of the law, or their number if it has no such shape. */
RBTI_INLINE RBT_DEVICE int32_t rbti_row_of_shape(const rbt_spin_law *law, double code)
{
    int32_t row = 0;
    while (row < law->n_shapes && (double)law->shape_codes[row] != code)
        row++;
    return row;
}

/* Whether a given grain has a shape of the law, and ratios that are some. */
RBTI_INLINE RBT_DEVICE int rbti_grain_holds(const rbt_spin_law *law, const double grain[3])
{
    const int ratios = grain[1] >= RBTI_LEAST_RATIO && grain[1] <= 1.0 &&
                       grain[2] >= RBTI_LEAST_RATIO && grain[2] <= 1.0;
    return ratios && rbti_row_of_shape(law, grain[0]) < law->n_shapes;
}

/* Given grains; a block that is not full repeats its last one. */
RBTI_INLINE RBT_DEVICE void rbti_take_grains(size_t m, const rbt_spin_law *law,
                                             const double *given, size_t count, int32_t *shapes,
                                             double *ratios)
{
    RBTI_EACH_DRAW(r) {
        const double *grain = given + 3 * (r < count ? r : count - 1);
        shapes[r] = rbti_row_of_shape(law, grain[0]);
        ratios[r] = grain[1];
        ratios[m + r] = grain[2];
    }
}

/* Grains of a seed, from words of their own. */
RBTI_INLINE RBT_DEVICE void rbti_fill_grains(size_t m, const rbt_spin_law *law, uint64_t seed,
                                             int fresh, const uint64_t *index,
                                             const uint32_t *hit, size_t count, int32_t *shapes,
                                             double *ratios)
{
    uint32_t own[RBTI_BLOCK] RBTI_ALIGNED, words[8 * RBTI_BLOCK] RBTI_ALIGNED;
    RBTI_EACH_DRAW(r)
        own[r] = 0;
    const uint32_t *hits = fresh ? hit : own;
    for (uint32_t block = 0; block < 2; block++)
        rbti_fill_words(m, block, seed ^ RBTI_SIMULATION_KEY, index, hits, count,
                        words + 4 * block * m);
    rbti_fill_ratios(m, law->aspect, words, ratios);
    rbti_fill_ratios(m, law->aspect + 4, words + m, ratios + m);
    RBTI_EACH_DRAW(r) {
        const double u = rbti_uniform(words[5 * m + r]);
        int32_t row = 0;
        for (int32_t k = 0; k < law->n_shapes - 1; k++)
            row += u >= law->shape_shares[k];
        shapes[r] = row;
        if (law->shape_ratios[2 * row] > 0.0) {
            ratios[r] = law->shape_ratios[2 * row];
            ratios[m + r] = law->shape_ratios[2 * row + 1];
        }
    }
}

/* No weight counts below 2^-126. A clamped number is used in a loop of its own: compilers branch on a
   number that may be a constant. */
RBTI_INLINE RBT_DEVICE float rbti_least_power(float y)
{
    return y > -126.0f ? y : -126.0f;
}

/* 2^y of a number from -126 to 0; no library's, and the same in every language. */
RBTI_INLINE RBT_DEVICE float rbti_power_of_two(float y)
{
    const int32_t n = (int32_t)(y - 0.5f);
    const float r = y - (float)n;
    const float p =
        1.0f +
        r * (0.6931471805599453f +
             r * (0.2402265069591007f +
                  r * (0.05550410866482158f +
                       r * (0.009618129107628477f +
                            r * (0.0013333558146428443f + r * 0.00015403530393381608f)))));
    const uint32_t bits = (uint32_t)(n + 127) << 23;
    float power;
    memcpy(&power, &bits, sizeof power);
    return p * power;
}

/* Logarithm to the base 2 of a positive number. */
RBTI_INLINE RBT_DEVICE float rbti_logarithm_to_two(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    bits -= 0x3f3504f3u; /* 1 / sqrt(2) */
    const float exponent = (float)((int32_t)bits >> 23);
    bits = (bits & 0x7fffffu) + 0x3f3504f3u;
    float mantissa;
    memcpy(&mantissa, &bits, sizeof mantissa);
    const float s = (mantissa - 1.0f) / (mantissa + 1.0f), q = s * s;
    return exponent +
           s * (2.8853900817779268f +
                q * (0.9617966939259757f +
                     q * (0.5770780163555854f +
                          q * (0.41219858311113243f + q * 0.3205988979753252f))));
}

/* exp(-k V_e^n), from V_e. */
RBTI_INLINE RBT_DEVICE void rbti_fill_speed_coordinate(size_t m, const rbt_spin_law *law,
                                                       const double *effective, double *values)
{
    const float exponent = (float)law->speed_exponent, scale = -(float)law->speed_scale;
    const double last = law->speed_last;
    float y[RBTI_BLOCK] RBTI_ALIGNED;
    RBTI_EACH_DRAW(r) {
        const float power = exponent * rbti_logarithm_to_two((float)(effective[r] / last));
        y[r] = rbti_least_power(power < 0.0f ? power : 0.0f);
    }
    RBTI_EACH_DRAW(r) {
        const float x = scale * rbti_power_of_two(y[r]);
        y[r] = rbti_least_power(x * RBTI_LOG2_E);
    }
    RBTI_EACH_DRAW(r)
        values[r] = (double)rbti_power_of_two(y[r]);
}

/* Moments of inertia of the grains over m a^2, the smallest and the largest: those of the file, else
   the bounds 0 and 2/3, which hold for every grain. */
RBTI_INLINE RBT_DEVICE void rbti_fill_moments(size_t m, const rbt_spin_law *law,
                                              rbti_spin_draws *d, double *largest)
{
    const double *ratios = d->inputs + RBTI_RATIO * m;
    RBTI_EACH_DRAW(r) {
        const double *of = law->shape_inertia ? law->shape_inertia + 2 * d->shape[r] : NULL;
        const double b = ratios[r] * ratios[r], c = ratios[m + r] * ratios[m + r];
        largest[r] = of ? of[0] * (1.0 + b) : RBTI_INERTIA;
        d->smallest[r] = of ? of[1] * b * (1.0 + c) : 0.0;
    }
}

/* Conditions of the mirror image with sigma_x >= 0. */
RBTI_INLINE RBT_DEVICE void rbti_fill_inputs(size_t m, const rbt_spin_law *law, rbti_spin_draws *d)
{
    double effective[RBTI_BLOCK] RBTI_ALIGNED, *inputs = d->inputs;
    double largest[RBTI_BLOCK] RBTI_ALIGNED;
    const double first = law->alpha_first, last = law->alpha_last, most = law->most_spin;
    const int by_root = law->shape_inertia != NULL; /* from version 1.3 on */
    rbti_fill_moments(m, law, d, largest);
    RBTI_EACH_DRAW(r) {
        const double sx = d->spin[r], sy = d->spin[m + r], sz = d->spin[2 * m + r];
        const double factor = rbti_spin_factor(sx, sy, sz), turn = sx < 0.0 ? -1.0 : 1.0;
        const double square = sx * sx + sy * sy + sz * sz, held = square < most ? square : most;
        /* the coordinate of a spin beyond the law is that of the largest */
        const double beyond = square > most ? sqrt(square / most) : 1.0;
        const double divisor = by_root ? sqrt(sqrt(1.0 + held)) * beyond : factor;
        const double tx = turn * sx / divisor, ty = turn * sy / divisor, tz = sz / divisor;
        double angle = d->alpha1[r] > first ? d->alpha1[r] : first;
        angle = angle < last ? angle : last;
        double speed = d->speed[r] * factor;
        speed = speed > law->speed_first ? speed : law->speed_first;
        effective[r] = speed < law->speed_last ? speed : law->speed_last;
        inputs[r] = sqrt(angle);
        inputs[2 * m + r] = tx;
        inputs[3 * m + r] = ty;
        inputs[4 * m + r] = tz;
        inputs[RBTI_SQUARE * m + r] = tx * tx + ty * ty + tz * tz;
        d->factor[r] = sqrt(1.0 + largest[r] * square);
        d->turn[r] = turn;
    }
    rbti_fill_speed_coordinate(m, law, effective, inputs + m);
}

/* Leaf of each draw in the tree of its shape. */
RBTI_INLINE RBT_DEVICE void rbti_find_leaves(size_t m, const rbt_spin_law *law, rbti_spin_draws *d)
{
    RBTI_EACH_DRAW(r) {
        int32_t node = law->roots[d->shape[r]];
        while (node >= 0) {
            const double value = d->inputs[(size_t)law->node_axis[node] * m + r];
            node = law->node_child[2 * node + (value >= law->node_cut[node])];
        }
        d->leaf[r] = -1 - node;
        RBTI_PREFETCH(law->inputs + 2 * RBTI_INPUTS * (size_t)d->leaf[r]);
    }
    RBTI_EACH_DRAW(r) {
        const size_t numbers = RBTI_FEATURES * RBTI_GROUPS;
        const int16_t *gates = law->group_gates + numbers * (size_t)d->leaf[r];
        for (size_t k = 0; k < numbers; k += RBTI_LINE)
            RBTI_PREFETCH(gates + k);
    }
}

/* Features: 1, the inputs less the middle of the leaf, the products of two conditions. */
RBTI_INLINE RBT_DEVICE void rbti_fill_features(size_t m, const rbt_spin_law *law,
                                               rbti_spin_draws *d)
{
    float *features = d->features;
    RBTI_EACH_DRAW(r)
        features[r] = 1.0f;
    for (size_t k = 0; k < RBTI_INPUTS; k++) {
        const double *inputs = d->inputs + (k < RBTI_CONDITIONS ? k : k + 1) * m;
        float middle[RBTI_BLOCK] RBTI_ALIGNED, scale[RBTI_BLOCK] RBTI_ALIGNED;
        RBTI_EACH_DRAW(r) {
            const float *of = law->inputs + 2 * RBTI_INPUTS * (size_t)d->leaf[r] + k;
            middle[r] = of[0];
            scale[r] = of[RBTI_INPUTS];
        }
        RBTI_EACH_DRAW(r)
            features[(1 + k) * m + r] = ((float)inputs[r] - middle[r]) * scale[r];
    }
    float *product = features + (1 + RBTI_INPUTS) * m;
    for (size_t i = 1; i <= RBTI_CONDITIONS; i++) {
        for (size_t j = i; j <= RBTI_CONDITIONS; j++) {
            RBTI_EACH_DRAW(r)
                product[r] = features[i * m + r] * features[j * m + r] - (i == j ? 0.5f : 0.0f);
            product += m;
        }
    }
}

/* Eight numbers that one instruction takes, where compilers have them. */
#if defined(__GNUC__) && !defined(RBTI_GPU) && (defined(__clang__) || __GNUC__ >= 9)
#define RBTI_VECTORS 1
typedef int16_t rbti_shorts __attribute__((vector_size(16)));
typedef int32_t rbti_longs __attribute__((vector_size(32)));
typedef float rbti_singles __attribute__((vector_size(32)));
#endif

/* Sums of eight numbers side by side, times a factor, over `rows` of them; row k begins `stride` k
   numbers behind the first, less `shrink` k (k + 1) / 2. Its first `shrink` k sums are left as they
   are. As a loop over an array the sums would wait for memory in every row. */
RBTI_INLINE RBT_DEVICE void rbti_sum_eight(size_t m, size_t rows, const int16_t *numbers,
                                           size_t stride, size_t shrink, const float *factors,
                                           float *sums)
{
#ifdef RBTI_VECTORS
    static const float window[15] = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f,
                                     1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f};
    rbti_singles total;
    memcpy(&total, sums, sizeof total);
    for (size_t row = 0; row < rows; row++) {
        rbti_shorts raw;
        memcpy(&raw, numbers + (row * stride - shrink * (row * (row + 1) / 2)), sizeof raw);
        const rbti_longs wide = __builtin_convertvector(raw, rbti_longs);
        rbti_singles factor = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
        factor = factors[row * m] - factor;
        if (shrink > 0) {
            rbti_singles ones;
            memcpy(&ones, window + 7 - row, sizeof ones);
            factor *= ones;
        }
        total += __builtin_convertvector(wide, rbti_singles) * factor;
    }
    memcpy(sums, &total, sizeof total);
#else
    for (size_t row = 0; row < rows; row++)
        for (size_t k = shrink * row; k < 8; k++)
            sums[k] += factors[row * m] *
                       (float)numbers[row * stride - shrink * (row * (row + 1) / 2) + k];
#endif
}

/* Sums over the features of each draw times `count` coefficients that lie side by side. */
RBTI_INLINE RBT_DEVICE void rbti_fill_logits(size_t m, size_t count, const int16_t *gates,
                                             const int32_t *places, const float *features,
                                             float *logits)
{
    RBTI_EACH_DRAW(r) {
        const int16_t *gate = gates + RBTI_FEATURES * count * (size_t)places[r];
        float sums[RBTI_GROUP_SIZE] RBTI_ALIGNED;
        for (size_t k = 0; k < count; k++)
            sums[k] = 0.0f;
        for (size_t k = 0; k < count; k += 8)
            rbti_sum_eight(m, RBTI_FEATURES, gate + k, count, 0, features + r, sums + k);
        for (size_t k = 0; k < count; k++)
            logits[k * m + r] = sums[k];
    }
}

/* A number below `count` for each draw, by weights that are exponentials, from words. */
RBTI_INLINE RBT_DEVICE void rbti_choose(size_t m, size_t count, const int16_t *gates,
                                        const int32_t *places, const float *features,
                                        const uint32_t *words, int32_t *chosen)
{
    float weights[RBTI_GROUP_SIZE * RBTI_BLOCK] RBTI_ALIGNED;
    float most[RBTI_BLOCK] RBTI_ALIGNED, share[RBTI_BLOCK] RBTI_ALIGNED;
    rbti_fill_logits(m, count, gates, places, features, weights);
    RBTI_EACH_DRAW(r)
        most[r] = weights[r];
    for (size_t k = 1; k < count; k++) {
        RBTI_EACH_DRAW(r)
            most[r] = weights[k * m + r] > most[r] ? weights[k * m + r] : most[r];
    }
    for (size_t k = 0; k < count; k++) {
        RBTI_EACH_DRAW(r) {
            const float x = (weights[k * m + r] - most[r]) * RBTI_GATE_UNIT;
            weights[k * m + r] = rbti_least_power(x * RBTI_LOG2_E);
        }
        RBTI_EACH_DRAW(r)
            weights[k * m + r] = rbti_power_of_two(weights[k * m + r]);
    }
    for (size_t k = 1; k < count; k++) {
        RBTI_EACH_DRAW(r)
            weights[k * m + r] += weights[(k - 1) * m + r];
    }
    RBTI_EACH_DRAW(r) {
        share[r] = ((float)(int32_t)(words[r] >> 8) + 0.5f) * (1.0f / 16777216.0f);
        share[r] *= weights[(count - 1) * m + r];
        chosen[r] = 0;
    }
    for (size_t k = 0; k + 1 < count; k++) {
        RBTI_EACH_DRAW(r)
            chosen[r] += share[r] >= weights[k * m + r];
    }
}

/* Group of experts and expert of each draw, numbered through all leaves. */
RBTI_INLINE RBT_DEVICE void rbti_choose_expert(size_t m, size_t outcomes, const rbt_spin_law *law,
                                               rbti_spin_draws *d)
{
    const size_t numbers = RBTI_FEATURES * RBTI_GROUP_SIZE, stride = rbti_expert_stride(outcomes);
    rbti_choose(m, RBTI_GROUPS, law->group_gates, d->leaf, d->features, d->words, d->group);
    RBTI_EACH_DRAW(r) {
        d->group[r] += d->leaf[r] * RBTI_GROUPS;
        const int16_t *gates = law->gates + numbers * (size_t)d->group[r];
        for (size_t k = 0; k < numbers; k += RBTI_LINE)
            RBTI_PREFETCH(gates + k);
    }
    rbti_choose(m, RBTI_GROUP_SIZE, law->gates, d->group, d->features, d->words + m, d->expert);
    RBTI_EACH_DRAW(r) {
        d->expert[r] += d->group[r] * RBTI_GROUP_SIZE;
        const int16_t *record = law->experts + stride * (size_t)d->expert[r];
        for (size_t k = 0; k < stride; k += RBTI_LINE)
            RBTI_PREFETCH(record + k);
    }
}

/* Normals to scores: mean and factor of the expert. Eight rows are read, of which the outcomes count. */
RBTI_INLINE RBT_DEVICE void rbti_fill_scores(size_t m, size_t outcomes, const rbt_spin_law *law,
                                             rbti_spin_draws *d)
{
    const size_t stride = rbti_expert_stride(outcomes);
    for (size_t k = 0; k < outcomes; k++) {
        RBTI_EACH_DRAW(r)
            d->scores[k * m + r] *= RBTI_FACTOR_UNIT;
    }
    RBTI_EACH_DRAW(r) {
        const int16_t *record = law->experts + stride * (size_t)d->expert[r];
        const int16_t *factors = record + RBTI_FEATURES * outcomes;
        float sums[8] RBTI_ALIGNED;
        for (size_t k = 0; k < 8; k++)
            sums[k] = 0.0f;
        rbti_sum_eight(m, RBTI_FEATURES, record, outcomes, 0, d->features + r, sums);
        for (size_t k = 0; k < 8; k++)
            sums[k] *= RBTI_MEAN_UNIT;
        rbti_sum_eight(m, outcomes, factors, outcomes, 1, d->scores + r, sums);
        for (size_t k = 0; k < outcomes; k++)
            d->scores[k * m + r] = sums[k];
    }
}

/* Scores to places among the knots of the leaf's quantiles. */
RBTI_INLINE RBT_DEVICE void rbti_find_knots(size_t m, int32_t outcomes, const rbt_spin_law *law,
                                            rbti_spin_draws *d)
{
    const int32_t last = law->n_knots - 2, knots = law->n_knots;
    const float scale = (float)(law->n_knots - 1) / (RBTI_SCORE_MAX + RBTI_SCORE_MAX);
    for (int32_t row = 0; row < outcomes; row++) {
        float *scores = d->scores + (size_t)row * m;
        int32_t *entries = d->entries + (size_t)row * m;
        RBTI_EACH_DRAW(r) {
            const float z = scores[r];
            const float bounded = z / sqrtf(1.0f + z * z * RBTI_PER_SQUARE);
            float position = (bounded + RBTI_SCORE_MAX) * scale;
            /* above the first knot, so that v stays positive */
            position = position > 1.0f / 1048576.0f ? position : 1.0f / 1048576.0f;
            int32_t knot = (int32_t)position;
            knot = knot < last ? knot : last;
            position -= (float)knot;
            scores[r] = position < 1.0f ? position : 1.0f;
            entries[r] = (d->leaf[r] * outcomes + row) * knots + knot;
        }
        RBTI_EACH_DRAW(r)
            RBTI_PREFETCH(law->quantiles + entries[r]);
    }
}

/* Places among knots to outcomes. */
RBTI_INLINE RBT_DEVICE void rbti_fill_outcomes(size_t m, int32_t outcomes, const rbt_spin_law *law,
                                               rbti_spin_draws *d)
{
    for (int32_t row = 0; row < outcomes; row++) {
        const size_t at = (size_t)row * m;
        uint32_t pair[RBTI_BLOCK] RBTI_ALIGNED;
        float least[RBTI_BLOCK] RBTI_ALIGNED, step[RBTI_BLOCK] RBTI_ALIGNED;
        RBTI_EACH_DRAW(r) {
            const float *span = law->spans + 2 * (d->leaf[r] * outcomes + row);
            memcpy(pair + r, law->quantiles + d->entries[at + r], sizeof *pair);
            least[r] = span[0];
            step[r] = span[1];
        }
        RBTI_EACH_DRAW(r) {
            const float low = (float)(int32_t)(pair[r] & 0xffffu);
            const float high = (float)(int32_t)(pair[r] >> 16);
            d->outcomes[at + r] = least[r] + step[r] * (low + d->scores[at + r] * (high - low));
        }
    }
}

/* Outcomes of a table with laws of contact are less those of a sphere, over 1 - c/a: add these. The
   sphere has the mean moment of inertia of the grain. */
RBTI_APART RBT_DEVICE void rbti_add_spheres(size_t m, const rbt_table *table, rbti_spin_draws *d)
{
    const rbt_spin_law *law = &table->spin;
    RBTI_EACH_DRAW(r) {
        const double *root = d->inputs + r, *ratios = d->inputs + RBTI_RATIO * m + r;
        const double b = ratios[0], c = b * ratios[m], radius = sqrt((1.0 + b * b + c * c) / 3.0);
        const double flat = rbti_bounded(1.0 - c, RBTI_LEAST_FLATNESS, 1.0);
        const double x = d->spin[r], y = d->spin[m + r], z = d->spin[2 * m + r];
        const double square = x * x + y * y + z * z, most = law->most_spin;
        /* a spin beyond the law is the largest, of less energy */
        const double held = square > most ? sqrt(most / square) : 1.0, size = radius * held;
        const double energy = 1.0 + held * held * (d->factor[r] * d->factor[r] - 1.0);
        const double spin[3] = {d->turn[r] * size * x, d->turn[r] * size * y, size * z};
        const double fast = d->speed[r] * rbti_spin_factor(x, y, z);
        const double speed = rbti_bounded(fast, law->speed_first, law->speed_last) /
                             rbti_spin_factor(held * x, held * y, held * z);
        double of[RBT_VALUES];
        rbti_sphere(table, root[0] * root[0], speed, spin, of);
        const double left = energy - (of[0] * of[0] + of[1] * of[1] + of[2] * of[2]);
        const double scale = 1.0 / sqrt(rbti_bounded(left, RBTI_LEAST_REST * energy, left));
        const double per_spin = radius * sqrt(energy);
        float *found = d->outcomes + r;
        const double raised = rbti_bounded(flat * (double)found[m], -RBTI_MOST_POWER, RBTI_MOST_POWER);
        found[0] = (float)(scale * of[0] + flat * (double)found[0]);
        found[m] = (float)(scale * of[1] * exp(raised));
        found[2 * m] = (float)(scale * of[2] + flat * (double)found[2 * m]);
        for (size_t k = 3; k < 6; k++)
            found[k * m] = (float)(of[k] / per_spin + flat * (double)found[k * m]);
    }
}

/* Outcomes to states of `count` draws, the first six variables or all. With E, the square of `factor`,
   the most energy that the grain can have before, E / (1 + |p|^2) is left for the rotation after: an
   angular velocity with more is shortened. The works are the share b of what both leave; of them the
   normal work has the share a^6. */
RBTI_INLINE RBT_DEVICE void rbti_to_spin_states(size_t m, size_t count, size_t outcomes,
                                                int variables, const rbt_table *table,
                                                const rbti_spin_draws *d, double *states)
{
    double values[RBTI_MOST_OUTCOMES * RBTI_BLOCK] RBTI_ALIGNED;
    RBTI_EACH_DRAW(r) {
        const float *found = d->outcomes + r;
        const double p = (double)found[0], q = (double)found[m];
        const double s = (double)found[2 * m], factor = d->factor[r], turn = d->turn[r];
        const double x = (double)found[3 * m], y = (double)found[4 * m];
        const double z = (double)found[5 * m], whole = 1.0 + (p * p + q * q + s * s);
        const double scale = factor / sqrt(whole);
        const double turns = d->smallest[r] * (x * x + y * y + z * z) * whole;
        const double turning = factor / sqrt(turns > 1.0 ? turns : 1.0);
        values[r] = p * scale;
        values[m + r] = q * scale;
        values[2 * m + r] = turn * s * scale;
        values[3 * m + r] = turn * turning * x;
        values[4 * m + r] = turn * turning * y;
        values[5 * m + r] = turning * z;
        if (outcomes == RBTI_MOST_OUTCOMES) {
            const double a = (double)found[6 * m], b = (double)found[7 * m], cube = a * a * a;
            const double left = scale * scale * (turns > 1.0 ? 0.0 : 1.0 - turns);
            const double sum = left * (b > 1.0 ? 1.0 : b < 0.0 ? 0.0 : b);
            const double normal = sum * (cube * cube > 1.0 ? 1.0 : cube * cube);
            values[6 * m + r] = normal;
            values[7 * m + r] = sum - normal;
        }
    }
    const size_t width = (size_t)variables;
    for (size_t k = 0; k < RBT_VALUES; k++) { /* a number that compilers know */
        if (k >= width)
            break;
        const size_t row = k < 6 ? k : k - 2; /* 6 and 7 are not of this law */
        const int known = k < 6 || (k > 7 && outcomes == RBTI_MOST_OUTCOMES);
        const int held = known && (table->held >> k & 1u);
        for (size_t r = 0; r < count; r++)
            states[width * r + k] = held ? values[row * m + r] : 0.0;
    }
}

/* Draws with conditions that may be drawn at. Word 8 belongs to no outcome. */
RBTI_INLINE RBT_DEVICE void rbti_spin_steps(size_t m, size_t outcomes, const rbt_table *table,
                                            uint64_t seed, const rbti_grains *grains,
                                            const uint64_t *index, const uint32_t *hit,
                                            size_t count, int variables, rbti_spin_draws *d,
                                            double *states)
{
    const rbt_spin_law *law = &table->spin;
    for (uint32_t block = 0; block < (outcomes > 6 ? 3u : 2u); block++)
        rbti_fill_words(m, block, seed, index, hit, count, d->words + 4 * block * m);
    if (grains->given)
        rbti_take_grains(m, law, grains->given, count, d->shape, d->inputs + RBTI_RATIO * m);
    else
        rbti_fill_grains(m, law, grains->seed, grains->fresh, index, hit, count, d->shape,
                         d->inputs + RBTI_RATIO * m);
    rbti_fill_inputs(m, law, d);
    rbti_find_leaves(m, law, d);
    rbti_fill_features(m, law, d);
    rbti_choose_expert(m, outcomes, law, d);
    for (size_t row = 0; row < outcomes; row++)
        rbti_fill_normals(m, table->normals, d->words + (row < 6 ? 2 + row : 3 + row) * m,
                          d->scores + row * m);
    rbti_fill_scores(m, outcomes, law, d);
    rbti_find_knots(m, (int32_t)outcomes, law, d);
    rbti_fill_outcomes(m, (int32_t)outcomes, law, d);
    if (table->n_laws > 0)
        rbti_add_spheres(m, table, d);
    rbti_to_spin_states(m, count, outcomes, variables, table, d, states);
}

/* The same with the number of outcomes of the law, which the compiler knows. */
RBTI_INLINE RBT_DEVICE void rbti_spin_block(size_t m, const rbt_table *table, uint64_t seed,
                                            const rbti_grains *grains, const uint64_t *index,
                                            const uint32_t *hit, size_t count, int variables,
                                            rbti_spin_draws *d, double *states)
{
    if (table->spin.n_outcomes == RBTI_OUTCOMES)
        rbti_spin_steps(m, RBTI_OUTCOMES, table, seed, grains, index, hit, count, variables, d,
                        states);
    else
        rbti_spin_steps(m, RBTI_MOST_OUTCOMES, table, seed, grains, index, hit, count, variables, d,
                        states);
}

/* Grains of the keys of a table. */
RBTI_INLINE RBT_DEVICE rbti_grains rbti_own_grains(const rbt_table *table, uint64_t seed)
{
    const rbti_grains own = {NULL, seed, table->spin.fresh_grains};
    return own;
}

RBTI_APART_CLONES RBT_DEVICE int rbti_spin_draw(const rbt_table *table, double alpha1,
                                                double speed, const double *given_spin,
                                                uint64_t seed, const rbti_grains *grains,
                                                uint64_t index, uint32_t hit, int variables,
                                                double *state)
{
    const double none[3] = {0.0, 0.0, 0.0}, *spin = given_spin ? given_spin : none;
    const int status = rbti_spin_status(table, alpha1, speed, spin[0], spin[1], spin[2]);
    if (status < RBT_OK)
        return status;
    if (grains->given && !rbti_grain_holds(&table->spin, grains->given))
        return RBT_ERR_GRAIN_NOT_KNOWN;
    if (table->spheres) {
        rbti_sphere_state(table, alpha1, speed, spin, variables, state);
        return status;
    }
    rbti_spin_draws draws;
    draws.alpha1[0] = alpha1;
    draws.speed[0] = speed;
    memcpy(draws.spin, spin, 3 * sizeof *spin);
    rbti_spin_block(1, table, seed, grains, &index, &hit, 1, variables, &draws, state);
    return status;
}

RBTI_INLINE RBT_DEVICE int rbti_grain(const rbt_table *table, uint64_t seed, int fresh,
                                      uint64_t index, uint32_t hit, double grain[3])
{
    int32_t shape[RBTI_BLOCK];
    double ratios[2 * RBTI_BLOCK];
    if (table->spin.n_shapes == 0)
        return RBT_ERR_NO_SPIN_LAW;
    rbti_fill_grains(1, &table->spin, seed, fresh, &index, &hit, 1, shape, ratios);
    grain[0] = (double)table->spin.shape_codes[shape[0]];
    grain[1] = ratios[0];
    grain[2] = ratios[1];
    return RBT_OK;
}

RBT_API RBT_DEVICE int rbt_grain(const rbt_table *table, uint64_t seed, uint64_t index,
                                 uint32_t hit, double grain[3])
{
    return rbti_grain(table, seed, table->spin.fresh_grains, index, hit, grain);
}

RBT_API RBT_DEVICE int rbt_fresh_grain(const rbt_table *table, uint64_t seed, uint64_t index,
                                       uint32_t hit, double grain[3])
{
    return rbti_grain(table, seed, 1, index, hit, grain);
}

RBT_API RBT_DEVICE int rbt_grains_batch(const rbt_table *table, size_t n, uint64_t seed,
                                        const uint64_t *index, double *grains)
{
    int code = RBT_OK;
    for (size_t k = 0; k < n && code == RBT_OK; k++)
        code = rbt_grain(table, seed, index[k], 0, grains + 3 * k);
    return code;
}

#ifndef RBT_DEVICE_ONLY

/* Count the flags of a row. */
RBTI_INLINE void rbti_count_flags(int flags, size_t row, rbt_report *report)
{
    if ((flags & RBT_CLAMPED) && report->clamped++ == 0)
        report->clamped_row = row;
    if ((flags & RBT_EXTRAPOLATED) && report->extrapolated++ == 0)
        report->extrapolated_row = row;
}

/* As rbti_conditions; spin and given grains may be NULL. */
RBTI_INLINE size_t rbti_spin_conditions(const rbt_table *table, const rbt_conditions *given,
                                        size_t first, size_t most, rbti_spin_draws *d, int *code,
                                        rbt_report *report)
{
    const double *alpha1 = given->alpha1, *speed = given->speed, *grain = given->grain;
    const rbt_spin_law *law = &table->spin;
    const size_t m = RBTI_BLOCK;
    const double none[3] = {0.0, 0.0, 0.0};
    int outside = law->n_shapes == 0 || grain;
    RBTI_EACH_DRAW(r) {
        const size_t k = first + (r < most ? r : most - 1);
        const double a = alpha1[k], v = speed[k], *spin = given->spin ? given->spin + 3 * k : none;
        const double x = spin[0], y = spin[1], z = spin[2];
        const double effective = v * rbti_spin_factor(x, y, z);
        const int off_alpha = (a < law->alpha_low) + (a > law->alpha_high);
        const int off_speed = (effective < law->speed_low) + (effective > law->speed_high);
        const double square = x * x + y * y + z * z;
        const int off_spin = (square < law->least_spin) + (square > law->most_spin);
        outside |= off_alpha | off_speed | off_spin;
        outside |= 1 - rbti_finite(a) * rbti_finite(effective);
        d->alpha1[r] = a;
        d->speed[r] = v;
        d->spin[r] = x;
        d->spin[m + r] = y;
        d->spin[2 * m + r] = z;
    }
    for (size_t r = 0; r < most && outside; r++) {
        int status = rbti_spin_status(table, d->alpha1[r], d->speed[r], d->spin[r],
                                      d->spin[m + r], d->spin[2 * m + r]);
        if (status >= RBT_OK && grain && !rbti_grain_holds(law, grain + 3 * (first + r)))
            status = RBT_ERR_GRAIN_NOT_KNOWN;
        if (status < RBT_OK) {
            report->row = first + r;
            *code = status;
            for (size_t k = r; k < m; k++) {
                d->alpha1[k] = law->alpha_first;
                d->speed[k] = law->speed_first;
                d->spin[k] = d->spin[m + k] = d->spin[2 * m + k] = 0.0;
            }
            return r;
        }
        rbti_count_flags(status & RBT_CLAMPED, first + r, report);
    }
    return most;
}

#endif

/* One draw from the law of first impacts: of the nodes, or of the spin law where it stands for that. */
RBTI_INLINE RBT_DEVICE int rbti_first_draw(const rbt_table *table, double alpha1, double speed,
                                           uint64_t seed, uint64_t key, uint64_t index,
                                           uint32_t hit, int variables, double *state)
{
    const rbti_grains any = {NULL, key, 1};
    if (!table->spin.for_first)
        return rbti_draw(table, alpha1, speed, seed, index, hit, variables, state);
    return rbti_spin_draw(table, alpha1, speed, NULL, seed, &any, index, hit, variables, state);
}

/* One draw from the law of the spin or grain, or from that of first impacts. */
RBTI_INLINE RBT_DEVICE int rbti_any_draw(const rbt_table *table, double alpha1, double speed,
                                         const double *spin, const double *grain, uint64_t seed,
                                         uint64_t index, uint32_t hit, int variables, double *state)
{
    rbti_grains grains = rbti_own_grains(table, seed);
    grains.given = grain;
    if (spin || grain)
        return rbti_spin_draw(table, alpha1, speed, spin, seed, &grains, index, hit, variables,
                              state);
    return rbti_first_draw(table, alpha1, speed, seed, seed, index, hit, variables, state);
}

RBT_API RBT_DEVICE int rbt_draw(const rbt_table *table, double alpha1, double speed,
                                const double *spin, uint64_t seed, uint64_t index, uint32_t hit,
                                double state[6])
{
    return rbti_any_draw(table, alpha1, speed, spin, NULL, seed, index, hit, 6, state);
}

RBT_API RBT_DEVICE int rbt_draw_all(const rbt_table *table, double alpha1, double speed,
                                    const double *spin, const double *grain, uint64_t seed,
                                    uint64_t index, uint32_t hit, double values[RBT_VALUES])
{
    return rbti_any_draw(table, alpha1, speed, spin, grain, seed, index, hit, RBT_VALUES, values);
}

#ifndef RBT_DEVICE_ONLY

/* Copy the conditions of a block; how many rows come before the first error, whose code is given.
   Where no row is left a condition of the table stands, so that all of the block can be drawn. */
RBTI_INLINE size_t rbti_conditions(const rbt_table *table, const double *alpha1,
                                   const double *speed, size_t first, size_t most, rbti_draws *d,
                                   int *code, rbt_report *report)
{
    const rbt_axis alpha = table->alpha, velocity = table->speed;
    const size_t m = RBTI_BLOCK;
    int outside = 0;
    RBTI_EACH_DRAW(r) {
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
            for (size_t k = r; k < m; k++) {
                d->alpha1[k] = alpha.first;
                d->speed[k] = velocity.first;
            }
            return r;
        }
        rbti_count_flags(status & RBT_CLAMPED, first + r, report);
    }
    return most;
}

/* What a batch returns: the code of its error, else the flags of its rows. */
RBTI_INLINE int rbti_batch_code(int code, const rbt_report *found)
{
    return code < RBT_OK ? code
                         : (found->clamped > 0) * RBT_CLAMPED |
                               (found->extrapolated > 0) * RBT_EXTRAPOLATED;
}

/* Rows that a batch writes: the first six variables, or columns of the table, in one precision. */
typedef struct rbti_output {
    double *states;
    float *singles;
    const int8_t *columns; /* NULL: the first six variables, in double precision */
    int width, variables;  /* numbers of a row; 6 or all variables that are drawn */
} rbti_output;

RBTI_INLINE rbti_output rbti_output_of(const rbt_table *table, double *states, float *singles)
{
    rbti_output out = {states, singles, table->columns, table->n_columns, 6};
    int plain = states && table->n_columns == 6;
    for (int k = 0; k < table->n_columns; k++) {
        plain = plain && table->columns[k] == k;
        out.variables = table->columns[k] >= 6 ? RBT_VALUES : out.variables;
    }
    if (plain)
        out.columns = NULL;
    return out;
}

/* Copy the columns of `count` drawn rows to their place from row `first` on. */
RBTI_INLINE void rbti_put(const rbti_output *out, size_t first, size_t count, int given,
                          const double *values)
{
    for (size_t r = 0; r < count; r++) {
        const double *row = values + (size_t)given * r;
        const size_t at = (first + r) * (size_t)out->width;
        for (int k = 0; k < out->width && out->states; k++)
            out->states[at + (size_t)k] = row[out->columns[k]];
        for (int k = 0; k < out->width && out->singles; k++)
            out->singles[at + (size_t)k] = (float)row[out->columns[k]];
    }
}

/* Draws from the spin law of a block of rows: how many come before the first error. */
RBTI_INLINE size_t rbti_sample_spins(const rbt_table *table, const rbt_conditions *given,
                                     size_t first, size_t most, uint64_t seed, int variables,
                                     double *states, int *code, rbt_report *report)
{
    const int any = given->fresh_grains || table->spin.fresh_grains || !given->spin;
    const rbti_grains grains = {given->grain ? given->grain + 3 * first : NULL, seed, any};
    rbti_spin_draws draws RBTI_ALIGNED;
    const size_t count = rbti_spin_conditions(table, given, first, most, &draws, code, report);
    for (size_t r = 0; r < count && table->spheres; r++)
        rbti_sphere_state(table, draws.alpha1[r], draws.speed[r],
                          given->spin ? given->spin + 3 * (first + r) : NULL, variables,
                          states + (size_t)variables * r);
    if (count > 0 && !table->spheres)
        rbti_spin_block(RBTI_BLOCK, table, seed, &grains, given->index + first,
                        given->hit + first, count, variables, &draws, states);
    return count;
}

/* The same from the law of particles that arrive without spin. */
RBTI_INLINE size_t rbti_sample_nodes(const rbt_table *table, const rbt_conditions *given,
                                     size_t first, size_t most, uint64_t seed, int variables,
                                     double *states, int *code, rbt_report *report)
{
    rbti_draws draws RBTI_ALIGNED;
    const size_t count = rbti_conditions(table, given->alpha1, given->speed, first, most, &draws,
                                         code, report);
    for (size_t r = 0; r < count && table->spheres; r++)
        rbti_sphere_state(table, draws.alpha1[r], draws.speed[r], NULL, variables,
                          states + (size_t)variables * r);
    if (count > 0 && !table->spheres)
        rbti_draw_block(RBTI_BLOCK, table, seed, given->index + first, given->hit + first, count,
                        variables, &draws, states);
    return count;
}

/* All batches of draws. */
RBTI_CLONES
static int rbti_sample_rows(const rbt_table *table, size_t n, const rbt_conditions *given,
                            uint64_t seed, const rbti_output *out, rbt_report *report)
{
    rbt_report found = {n, n, 0, 0, n};
    int code = RBT_OK;
    const int spins = given->spin || given->grain || table->spin.for_first;
    for (size_t first = 0; first < n && code == RBT_OK; first += RBTI_BLOCK) {
        const size_t most = n - first < RBTI_BLOCK ? n - first : RBTI_BLOCK;
        double values[RBT_VALUES * RBTI_BLOCK] RBTI_ALIGNED;
        double *states = out->columns ? values : out->states + 6 * first;
        size_t count;
        if (spins)
            count = rbti_sample_spins(table, given, first, most, seed, out->variables, states,
                                      &code, &found);
        else
            count = rbti_sample_nodes(table, given, first, most, seed, out->variables, states,
                                      &code, &found);
        if (out->columns)
            rbti_put(out, first, count, out->variables, values);
        for (size_t k = first; k < first + count; k++)
            rbti_count_flags(rbti_extrapolates(table, given->speed[k]), k, &found);
    }
    if (report)
        *report = found;
    return rbti_batch_code(code, &found);
}

RBT_API int rbt_draw_batch(const rbt_table *table, size_t n, const double *alpha1,
                           const double *speed, const double *spin, uint64_t seed,
                           const uint64_t *index, const uint32_t *hit, double *states,
                           rbt_report *report)
{
    const rbt_conditions given = {alpha1, speed, spin, NULL, index, hit, 0};
    const rbti_output out = {states, NULL, NULL, 6, 6};
    return rbti_sample_rows(table, n, &given, seed, &out, report);
}

RBT_API int rbt_sample_batch(const rbt_table *table, size_t n, const rbt_conditions *conditions,
                             uint64_t seed, double *states, float *singles, rbt_report *report)
{
    const rbti_output out = rbti_output_of(table, states, singles);
    return rbti_sample_rows(table, n, conditions, seed, &out, report);
}

#endif

/* -- rebounds: the lab frame and the frame of the impact ------------------------------------------

   The frame of the impact has y along the wall normal into the gas, x along the tangential part of the
   velocity relative to the wall, and z = x cross y. At normal impact, where there is no tangential
   part, the direction of x is drawn from word 8. */

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

/* An impact: condition, frame and wall. */
typedef struct rbti_impact {
    double relative[3], wall[3], e_x[3], e_y[3], e_z[3], alpha1, speed, half_size;
} rbti_impact;

/* Negative code for numbers from which no impact can be made, else RBT_OK. */
RBTI_INLINE RBT_DEVICE int rbti_impact_status(const double velocity[3], const double normal[3],
                                              double half_size, const double wall[3])
{
    if (!(rbti_all_finite(velocity) && rbti_all_finite(wall) && rbti_all_finite(normal) &&
          rbti_finite(half_size)))
        return RBT_ERR_NOT_FINITE;
    if (normal[0] == 0.0 && normal[1] == 0.0 && normal[2] == 0.0)
        return RBT_ERR_NORMAL_NOT_USABLE;
    return half_size < RBTI_LEAST_HALF_SIZE ? RBT_ERR_HALF_SIZE_NOT_POSITIVE : RBT_OK;
}

/* Impact angle from the wall, rad, not positive if receding; and the tangential speed. */
RBTI_INLINE RBT_DEVICE double rbti_impact_angle(const double relative[3], const double e_y[3],
                                                double *tangential)
{
    const double approach = -rbti_dot(relative, e_y);
    double along[3];
    rbti_combine(1.0, relative, approach, e_y, along);
    *tangential = sqrt(rbti_dot(along, along));
    return atan2(approach, *tangential);
}

/* Unit vector along the tangential velocity; at normal impact its azimuth is drawn. */
RBTI_INLINE RBT_DEVICE void rbti_tangent(const double relative[3], const double e_y[3],
                                         double tangential, double speed, uint64_t seed,
                                         uint64_t index, uint32_t hit, double e_x[3])
{
    if (tangential <= RBTI_NORMAL_IMPACT * speed) {
        uint32_t words[4];
        rbti_fill_words(1, 2, seed, &index, &hit, 1, words);
        rbti_perpendicular(e_y, RBTI_TWO_PI * rbti_uniform(words[0]), e_x);
    } else {
        rbti_along_wall(relative, e_y, e_x);
    }
}

/* Angle, speed and frame of an impact. */
RBTI_INLINE RBT_DEVICE int rbti_meet(const double velocity[3], const double normal[3],
                                     double half_size, const double *wall_velocity, uint64_t seed,
                                     uint64_t index, uint32_t hit, rbti_impact *impact)
{
    for (int k = 0; k < 3; k++)
        impact->wall[k] = wall_velocity ? wall_velocity[k] : 0.0;
    const int code = rbti_impact_status(velocity, normal, half_size, impact->wall);
    if (code != RBT_OK)
        return code;
    impact->half_size = half_size;
    rbti_combine(1.0, velocity, -1.0, impact->wall, impact->relative);
    impact->speed = sqrt(rbti_dot(impact->relative, impact->relative));
    if (impact->speed < RBTI_LEAST_SPEED)
        return RBT_ERR_SPEED_NOT_POSITIVE;
    rbti_unit(normal, impact->e_y);
    double tangential;
    impact->alpha1 = rbti_impact_angle(impact->relative, impact->e_y, &tangential);
    rbti_tangent(impact->relative, impact->e_y, tangential, impact->speed, seed, index, hit,
                 impact->e_x);
    rbti_cross(impact->e_x, impact->e_y, impact->e_z);
    return RBT_OK;
}

/* Angular velocity in the lab frame to spin in the frame of the impact. */
RBTI_INLINE RBT_DEVICE int rbti_to_spin(const rbti_impact *impact, const double omega[3],
                                        double spin[3])
{
    if (!rbti_all_finite(omega))
        return RBT_ERR_NOT_FINITE;
    const double scale = impact->half_size / impact->speed;
    spin[0] = scale * rbti_dot(omega, impact->e_x);
    spin[1] = scale * rbti_dot(omega, impact->e_y);
    spin[2] = scale * rbti_dot(omega, impact->e_z);
    return RBT_OK;
}

/* A drawn state in the lab frame. */
RBTI_INLINE RBT_DEVICE void rbti_leave(const rbti_impact *impact, const double state[6],
                                       double velocity[3], double omega[3])
{
    const double *e_x = impact->e_x, *e_y = impact->e_y, *e_z = impact->e_z;
    rbti_turned(state, e_x, e_y, e_z, impact->speed, velocity);
    rbti_turned(state + 3, e_x, e_y, e_z, impact->speed / impact->half_size, omega);
    for (int k = 0; k < 3; k++)
        velocity[k] += impact->wall[k];
}

/* Whether a rebound without angular velocity is a first impact, of any grain; else the particle meets
   the wall as its own grain, with a spin of zeros. */
RBTI_INLINE RBT_DEVICE int rbti_is_first(const rbt_table *table, const rbti_grains *grains)
{
    return !grains->given && (grains->fresh || table->spin.n_shapes == 0);
}

/* Draw `count` variables of a particle with one of these grains, in the frame of its impact. */
RBTI_INLINE RBT_DEVICE int rbti_meet_and_draw(const rbt_table *table, const double velocity[3],
                                              const double normal[3], double half_size,
                                              const double *wall_velocity, const double *omega,
                                              uint64_t seed, const rbti_grains *grains,
                                              uint64_t index, uint32_t hit, int count,
                                              rbti_impact *impact, double *values)
{
    double spin[3];
    int code = rbti_meet(velocity, normal, half_size, wall_velocity, seed, index, hit, impact);
    if (code == RBT_OK && omega)
        code = rbti_to_spin(impact, omega, spin);
    if (code != RBT_OK)
        return code;
    if (omega || !rbti_is_first(table, grains))
        return rbti_spin_draw(table, impact->alpha1, impact->speed, omega ? spin : NULL, seed,
                              grains, index, hit, count, values);
    return rbti_first_draw(table, impact->alpha1, impact->speed, seed, grains->seed, index, hit,
                           count, values);
}

/* rbt_rebound of a particle with one of these grains. */
RBTI_INLINE RBT_DEVICE int rbti_rebound(const rbt_table *table, const double velocity[3],
                                        const double normal[3], double half_size,
                                        const double *wall_velocity, const double *omega,
                                        uint64_t seed, const rbti_grains *grains, uint64_t index,
                                        uint32_t hit, double new_velocity[3], double new_omega[3])
{
    rbti_impact impact;
    double state[6];
    const int code = rbti_meet_and_draw(table, velocity, normal, half_size, wall_velocity, omega,
                                        seed, grains, index, hit, 6, &impact, state);
    if (code >= RBT_OK)
        rbti_leave(&impact, state, new_velocity, new_omega);
    return code;
}

RBT_API RBT_DEVICE int rbt_rebound(const rbt_table *table, const double velocity[3],
                                   const double normal[3], double half_size,
                                   const double wall_velocity[3], const double omega[3],
                                   uint64_t seed, uint64_t index, uint32_t hit,
                                   double new_velocity[3], double new_omega[3])
{
    const rbti_grains own = rbti_own_grains(table, seed);
    return rbti_rebound(table, velocity, normal, half_size, wall_velocity, omega, seed, &own, index,
                        hit, new_velocity, new_omega);
}

RBT_API RBT_DEVICE int rbt_works(const rbt_table *table, const double velocity[3],
                                 const double normal[3], double half_size,
                                 const double wall_velocity[3], const double omega[3],
                                 uint64_t seed, uint64_t index, uint32_t hit, double works[2])
{
    const rbti_grains own = rbti_own_grains(table, seed);
    rbti_impact impact;
    double values[RBT_VALUES];
    const int code = rbti_meet_and_draw(table, velocity, normal, half_size, wall_velocity, omega,
                                        seed, &own, index, hit, RBT_VALUES, &impact, values);
    for (int k = 0; code >= RBT_OK && k < 2; k++)
        works[k] = 0.5 * impact.speed * impact.speed * values[8 + k];
    return code;
}

/* -- rough walls ----------------------------------------------------------------------------------

   A particle that arrives at an angle alpha meets facets whose tilt g is normal with a standard
   deviation, the roughness, and which it sees by their projected area: their density is
   ~ exp(-g^2 / (2 roughness^2)) sin(alpha + g), 0 < alpha + g < pi, |g| < pi/2 (Sommerfeld & Huber,
   Int. J. Multiphase Flow 25 (1999) 1457-1489). The tangent of the sine bounds the density by
   phi(z) (c + z), z = g / roughness, c = tan(alpha) / roughness; a tilt is proposed from the bound and
   accepted with the ratio. Trials take blocks 3, 4, ... of random words. Bounce k of the same hit has
   the seed XOR k 0x9E3779B97F4A7C15.

   Where roughness is isotropic, facets are tilted by h across the plane of incidence as well: their
   normals are along e_y - tan(g) e_x + tan(h) e_z, and h has a density ~ exp(-h^2 / (2 roughness^2))
   cos(h), whatever g is (docs/method.md). Its trials take blocks 67, 68, ... */

#define RBTI_TILT_BLOCK 3u     /* of the random words of the first trial of a tilt */
#define RBTI_MAX_TRIALS 64u
#define RBTI_MAX_BOUNCES 64u
#define RBTI_SHADOW 1e-9 /* rad between path and facet from which a facet is met */
#define RBTI_STEEP 1e9
#define RBTI_BOUNCE_KEY 0x9e3779b97f4a7c15u
#define RBTI_PI 3.141592653589793
#define RBTI_PER_ROOT_TWO_PI 0.3989422804014327
#define RBTI_PER_ROOT_TWO 0.7071067811865476

RBT_API RBT_DEVICE int rbt_wall_tilt(double ra, double rq, double rsm, double diameter,
                                     double *tilt)
{
    if (!(rbti_finite(ra) && rbti_finite(rq) && rbti_finite(rsm) && rbti_finite(diameter)))
        return RBT_ERR_NOT_FINITE;
    if (ra < 0.0 || rq < 0.0 || rsm <= 0.0 || diameter <= 0.0)
        return RBT_ERR_ROUGHNESS_NOT_USABLE;
    const double flank = atan(2.0 * ra / rsm), found = diameter * sin(flank) < rsm
                                                           ? flank
                                                           : atan(2.0 * rq / rsm);
    if (found > RBT_MOST_ROUGHNESS)
        return RBT_ERR_ROUGHNESS_NOT_USABLE;
    *tilt = found;
    return RBT_OK;
}

RBTI_INLINE RBT_DEVICE double rbti_normal_cdf(double x)
{
    return 0.5 * erfc(-x * RBTI_PER_ROOT_TWO);
}

RBTI_INLINE RBT_DEVICE double rbti_normal_quantile(double p)
{
    const double q = p - 0.5;
    return fabs(q) <= 0.425 ? rbti_central_quantile(q) : rbti_outer_quantile(p);
}

/* z with a density ~ phi(z) (c + z), z > -c, from three uniform numbers. */
RBTI_INLINE RBT_DEVICE double rbti_proposed_score(double c, double u_part, double u_size,
                                                  double u_side)
{
    const double plain = c * rbti_normal_cdf(c);
    const double rayleigh = RBTI_PER_ROOT_TWO_PI * exp(-0.5 * c * c);
    if (u_part * (plain + rayleigh) >= plain)
        return sqrt(c * c - 2.0 * log(u_size)); /* z phi(z) for z > c */
    const double below = rbti_normal_cdf(-c);
    const double z = rbti_normal_quantile(below + u_size * (1.0 - below));
    /* phi(z) becomes phi(z) (1 + z / c) for |z| < c: each -z gives as much as z lacks */
    return z < c && 2.0 * u_side * c < c - z ? -z : z;
}

/* One trial of a tilt from four random words: whether it is accepted. */
RBTI_INLINE RBT_DEVICE int rbti_try_tilt(double alpha1, double roughness, const uint32_t words[4],
                                         double *tilt)
{
    const double steepness = tan(alpha1) / roughness;
    const double c = steepness < RBTI_STEEP ? steepness : RBTI_STEEP;
    *tilt = roughness * rbti_proposed_score(c, rbti_uniform(words[0]), rbti_uniform(words[1]),
                                            rbti_uniform(words[2]));
    const double local = alpha1 + *tilt;
    if (!(RBTI_SHADOW < local && local < RBTI_PI - RBTI_SHADOW) || fabs(*tilt) >= RBTI_HALF_PI)
        return 0;
    const double bound = sin(alpha1) + *tilt * cos(alpha1);
    return rbti_uniform(words[3]) * bound < sin(local);
}

/* One trial of a tilt across the plane of incidence. */
RBTI_INLINE RBT_DEVICE int rbti_try_across(double roughness, const uint32_t words[4], double *tilt)
{
    *tilt = roughness * rbti_normal_quantile(rbti_uniform(words[0]));
    return fabs(*tilt) < RBTI_HALF_PI && rbti_uniform(words[1]) < cos(*tilt);
}

/* A particle within one hit of a rough wall, seen from the wall. */
typedef struct rbti_cascade {
    double moving[3], turning[3]; /* velocity, m/s, and angular velocity, rad/s */
    double wall[3], e_y[3], half_size, roughness;
    int isotropic;
} rbti_cascade;

/* A cascade before its first bounce. */
RBTI_INLINE RBT_DEVICE int rbti_begin(const double velocity[3], const double normal[3],
                                      double half_size, const double *wall_velocity,
                                      double roughness, int isotropic, const double *omega,
                                      rbti_cascade *c)
{
    if (!rbti_finite(roughness) || roughness < 0.0 || roughness > RBT_MOST_ROUGHNESS)
        return RBT_ERR_ROUGHNESS_NOT_USABLE;
    for (int k = 0; k < 3; k++) {
        c->wall[k] = wall_velocity ? wall_velocity[k] : 0.0;
        c->turning[k] = omega ? omega[k] : 0.0;
    }
    const int code = rbti_impact_status(velocity, normal, half_size, c->wall);
    if (code != RBT_OK)
        return code;
    rbti_combine(1.0, velocity, -1.0, c->wall, c->moving);
    if (sqrt(rbti_dot(c->moving, c->moving)) < RBTI_LEAST_SPEED)
        return RBT_ERR_SPEED_NOT_POSITIVE;
    rbti_unit(normal, c->e_y);
    c->half_size = half_size;
    c->roughness = roughness;
    c->isotropic = isotropic;
    return rbti_dot(c->moving, c->e_y) < 0.0 ? RBT_OK : RBT_ERR_NOT_APPROACHING;
}

/* Tilt in the plane of incidence, or across it, from trials from a block of words on: whether one was
   accepted. */
RBTI_INLINE RBT_DEVICE int rbti_find_tilt(const rbti_cascade *c, int across, double alpha1,
                                          uint64_t seed, uint64_t index, uint32_t hit, double *tilt)
{
    const uint32_t first = RBTI_TILT_BLOCK + (across ? RBTI_MAX_TRIALS : 0u);
    int found = 0;
    for (uint32_t trial = 0; trial < RBTI_MAX_TRIALS && !found; trial++) {
        uint32_t words[4];
        rbti_fill_words(1, first + trial, seed, &index, &hit, 1, words);
        found = across ? rbti_try_across(c->roughness, words, tilt)
                       : rbti_try_tilt(alpha1, c->roughness, words, tilt);
    }
    return found;
}

/* Normal of the facet that the particle meets next, of any length but zero. */
RBTI_INLINE RBT_DEVICE int rbti_meet_facet(const rbti_cascade *c, uint64_t seed, uint64_t index,
                                           uint32_t hit, double facet[3])
{
    const double speed = sqrt(rbti_dot(c->moving, c->moving));
    double tangential, tilt = 0.0, across = 0.0, e_x[3], e_z[3];
    double alpha1 = rbti_impact_angle(c->moving, c->e_y, &tangential);
    alpha1 = alpha1 > 0.0 ? alpha1 : 0.0;
    if (!rbti_find_tilt(c, 0, alpha1, seed, index, hit, &tilt) ||
        (c->isotropic && !rbti_find_tilt(c, 1, alpha1, seed, index, hit, &across)))
        return RBT_ERR_TILT_NOT_FOUND;
    rbti_tangent(c->moving, c->e_y, tangential, speed, seed, index, hit, e_x);
    rbti_combine(cos(tilt), c->e_y, -sin(tilt), e_x, facet);
    if (c->isotropic) {
        rbti_cross(e_x, c->e_y, e_z);
        rbti_combine(cos(across), facet, cos(tilt) * sin(across), e_z, facet);
    }
    return RBT_OK;
}

/* Whether the particle leaves the mean wall. */
RBTI_INLINE RBT_DEVICE int rbti_has_left(const rbti_cascade *c)
{
    return rbti_dot(c->moving, c->e_y) > 0.0;
}

/* Bounces from a number on until the particle leaves, each with random numbers of its own; the first
   is a first impact if `any`, later ones have the spin that the one before has left, if there is a
   law for it. */
RBTI_APART RBT_DEVICE int rbti_bounces(const rbt_table *table, rbti_cascade *c, uint32_t bounce,
                                       int any, uint64_t seed, const rbti_grains *grains,
                                       uint64_t index, uint32_t hit)
{
    int flags = RBT_OK;
    for (; bounce < RBTI_MAX_BOUNCES; bounce++) {
        const uint64_t key = seed ^ ((uint64_t)bounce * RBTI_BOUNCE_KEY);
        double facet[3];
        int code = rbti_meet_facet(c, key, index, hit, facet);
        if (code == RBT_OK)
            code = rbti_rebound(table, c->moving, facet, c->half_size, NULL,
                                any ? NULL : c->turning, key, grains, index, hit, c->moving,
                                c->turning);
        if (code < RBT_OK)
            return code;
        any = any && table->spin.n_shapes == 0;
        flags |= code;
        if (rbti_has_left(c))
            return flags;
    }
    return RBT_ERR_CASCADE_NOT_ENDED;
}

/* Velocity and angular velocity after a cascade, in the lab frame. */
RBTI_INLINE RBT_DEVICE void rbti_end(const rbti_cascade *c, double velocity[3], double omega[3])
{
    for (int k = 0; k < 3; k++) {
        velocity[k] = c->moving[k] + c->wall[k];
        omega[k] = c->turning[k];
    }
}

/* Whether a wall has facets; NaN is refused later. */
RBTI_INLINE RBT_DEVICE int rbti_is_rough(double roughness)
{
    return !rbti_finite(roughness) || roughness != 0.0;
}

/* rbt_rough_rebound of a particle with one of these grains. */
RBTI_INLINE RBT_DEVICE int rbti_any_rebound(const rbt_table *table, const double velocity[3],
                                            const double normal[3], double half_size,
                                            const double *wall_velocity, double roughness,
                                            int isotropic, const double *omega, uint64_t seed,
                                            const rbti_grains *grains, uint64_t index,
                                            uint32_t hit, double new_velocity[3],
                                            double new_omega[3])
{
    if (!rbti_is_rough(roughness))
        return rbti_rebound(table, velocity, normal, half_size, wall_velocity, omega, seed, grains,
                            index, hit, new_velocity, new_omega);
    rbti_cascade c;
    int code =
        rbti_begin(velocity, normal, half_size, wall_velocity, roughness, isotropic, omega, &c);
    if (code == RBT_OK)
        code = rbti_bounces(table, &c, 0, !omega && rbti_is_first(table, grains), seed, grains,
                            index, hit);
    if (code >= RBT_OK)
        rbti_end(&c, new_velocity, new_omega);
    return code;
}

RBT_API RBT_DEVICE int rbt_rough_rebound(const rbt_table *table, const double velocity[3],
                                         const double normal[3], double half_size,
                                         const double wall_velocity[3], double roughness,
                                         const double omega[3], uint64_t seed, uint64_t index,
                                         uint32_t hit, double new_velocity[3],
                                         double new_omega[3])
{
    return rbt_rebound_grain(table, velocity, normal, half_size, wall_velocity, roughness, 0, omega,
                             NULL, seed, index, hit, new_velocity, new_omega);
}

RBT_API RBT_DEVICE int rbt_rebound_grain(const rbt_table *table, const double velocity[3],
                                         const double normal[3], double half_size,
                                         const double wall_velocity[3], double roughness,
                                         int isotropic, const double omega[3],
                                         const double grain[3], uint64_t seed, uint64_t index,
                                         uint32_t hit, double new_velocity[3],
                                         double new_omega[3])
{
    rbti_grains grains = rbti_own_grains(table, seed);
    grains.given = grain;
    return rbti_any_rebound(table, velocity, normal, half_size, wall_velocity, roughness, isotropic,
                            omega, seed, &grains, index, hit, new_velocity, new_omega);
}

#ifndef RBT_DEVICE_ONLY

/* -- batches of rebounds ------------------------------------------------------------------------- */

/* Impacts of a block of rows: with facets, where walls are rough. */
typedef struct rbti_rows {
    rbti_impact met[RBTI_BLOCK];
    rbti_cascade cascades[RBTI_BLOCK];
    int rough[RBTI_BLOCK];
    double alpha1[RBTI_BLOCK], speed[RBTI_BLOCK], spin[3 * RBTI_BLOCK], states[6 * RBTI_BLOCK];
} rbti_rows;

/* Grains of some impacts from row k on. */
RBTI_INLINE rbti_grains rbti_grains_of(const rbt_table *table, const rbt_impacts *impacts, size_t k,
                                       uint64_t seed)
{
    const rbti_grains grains = {impacts->grain ? impacts->grain + 3 * k : NULL, seed,
                                impacts->fresh_grains || table->spin.fresh_grains};
    return grains;
}

/* Impact of row k on the wall, or on the first facet, as row r of a block. */
static int rbti_meet_row(const rbt_impacts *impacts, size_t k, uint64_t seed, size_t r,
                         rbti_rows *rows)
{
    const double *velocity = impacts->velocity + 3 * k, *normal = impacts->normal + 3 * k;
    const double *wall = impacts->wall_velocity ? impacts->wall_velocity + 3 * k : NULL;
    const double *omega = impacts->omega ? impacts->omega + 3 * k : NULL;
    const double half_size = impacts->half_size[k];
    const double roughness = impacts->roughness ? impacts->roughness[k] : 0.0;
    const uint64_t index = impacts->index[k];
    const uint32_t hit = impacts->hit[k];
    rbti_impact *met = &rows->met[r];
    int code;
    rows->rough[r] = rbti_is_rough(roughness);
    if (rows->rough[r]) {
        rbti_cascade *c = &rows->cascades[r];
        double facet[3];
        code = rbti_begin(velocity, normal, half_size, wall, roughness, impacts->isotropic, omega, c);
        if (code == RBT_OK)
            code = rbti_meet_facet(c, seed, index, hit, facet);
        if (code == RBT_OK)
            code = rbti_meet(c->moving, facet, half_size, NULL, seed, index, hit, met);
    } else {
        code = rbti_meet(velocity, normal, half_size, wall, seed, index, hit, met);
    }
    for (int j = 0; j < 3; j++)
        rows->spin[3 * r + (size_t)j] = 0.0;
    if (code == RBT_OK && omega)
        code = rbti_to_spin(met, omega, rows->spin + 3 * r);
    if (code == RBT_OK) {
        rows->alpha1[r] = met->alpha1;
        rows->speed[r] = met->speed;
    }
    return code;
}

/* Flags of the first impact of a row that was drawn. */
static int rbti_row_status(const rbt_table *table, const rbti_rows *rows, int spins, size_t r)
{
    const double *spin = rows->spin + 3 * r;
    if (spins)
        return rbti_spin_status(table, rows->alpha1[r], rows->speed[r], spin[0], spin[1], spin[2]);
    return rbti_status(table, rows->alpha1[r], rows->speed[r]);
}

/* Write row r of a block as row k, after further bounces where it needs them. */
static int rbti_leave_row(const rbt_table *table, const rbt_impacts *impacts, size_t k,
                          uint64_t seed, size_t r, rbti_rows *rows, double *velocity,
                          double *omega)
{
    const double *state = rows->states + 6 * r;
    if (!rows->rough[r]) {
        rbti_leave(&rows->met[r], state, velocity, omega);
        return RBT_OK;
    }
    rbti_cascade *c = &rows->cascades[r];
    int code = RBT_OK;
    rbti_leave(&rows->met[r], state, c->moving, c->turning);
    if (!rbti_has_left(c)) {
        const rbti_grains grains = rbti_grains_of(table, impacts, k, seed);
        code = rbti_bounces(table, c, 1, table->spin.n_shapes == 0, seed, &grains,
                            impacts->index[k], impacts->hit[k]);
    }
    if (code >= RBT_OK)
        rbti_end(c, velocity, omega);
    return code;
}

/* Rebounds of a block of rows from one on: how many, and the code of the one behind them. */
static size_t rbti_rebound_block(const rbt_table *table, size_t first, size_t most,
                                 const rbt_impacts *impacts, uint64_t seed, rbti_rows *rows,
                                 double *new_velocity, double *new_omega, int *code,
                                 rbt_report *report)
{
    const rbti_grains grains = rbti_grains_of(table, impacts, first, seed);
    const int spins = impacts->omega || !rbti_is_first(table, &grains);
    const rbti_output out = {rows->states, NULL, NULL, 6, 6};
    const rbt_conditions drawn_at = {rows->alpha1,
                                     rows->speed,
                                     spins ? rows->spin : NULL,
                                     impacts->grain ? impacts->grain + 3 * first : NULL,
                                     impacts->index + first,
                                     impacts->hit + first,
                                     impacts->fresh_grains};
    rbt_report part;
    size_t count = 0, r = 0;
    while (count < most && *code == RBT_OK) {
        *code = rbti_meet_row(impacts, first + count, seed, count, rows);
        count += *code == RBT_OK;
    }
    const int drawn = rbti_sample_rows(table, count, &drawn_at, seed, &out, &part);
    *code = drawn < RBT_OK ? drawn : *code;
    for (; r < part.row; r++) {
        const size_t k = first + r;
        const int status = part.clamped + part.extrapolated > 0
                               ? rbti_row_status(table, rows, spins || table->spin.for_first, r)
                               : RBT_OK;
        const int left = rbti_leave_row(table, impacts, k, seed, r, rows, new_velocity + 3 * k,
                                        new_omega + 3 * k);
        if (left < RBT_OK) {
            *code = left;
            break;
        }
        rbti_count_flags(status | left, k, report);
    }
    return r;
}

/* A batch of one, which many trackers have: no block is filled for it. */
static int rbti_rebound_row(const rbt_table *table, const rbt_impacts *impacts, uint64_t seed,
                            double *new_velocity, double *new_omega, rbt_report *report)
{
    const rbti_grains grains = rbti_grains_of(table, impacts, 0, seed);
    const int code = rbti_any_rebound(table, impacts->velocity, impacts->normal,
                                      impacts->half_size[0], impacts->wall_velocity,
                                      impacts->roughness ? impacts->roughness[0] : 0.0,
                                      impacts->isotropic, impacts->omega, seed, &grains,
                                      impacts->index[0], impacts->hit[0], new_velocity, new_omega);
    if (report) {
        const rbt_report none = {code >= RBT_OK, 1, 0, 0, 1};
        *report = none;
        rbti_count_flags(code < RBT_OK ? RBT_OK : code, 0, report);
    }
    return code;
}

RBT_API int rbt_rebound_batch(const rbt_table *table, size_t n, const rbt_impacts *impacts,
                              uint64_t seed, double *new_velocity, double *new_omega,
                              rbt_report *report)
{
    rbti_rows rows;
    rbt_report found = {n, n, 0, 0, n};
    int code = RBT_OK;
    if (n == 1)
        return rbti_rebound_row(table, impacts, seed, new_velocity, new_omega, report);
    for (size_t first = 0; first < n && code == RBT_OK; first += RBTI_BLOCK) {
        const size_t most = n - first < RBTI_BLOCK ? n - first : RBTI_BLOCK;
        const size_t done = rbti_rebound_block(table, first, most, impacts, seed, &rows,
                                               new_velocity, new_omega, &code, &found);
        if (code != RBT_OK)
            found.row = first + done;
    }
    if (report)
        *report = found;
    return rbti_batch_code(code, &found);
}

/* -- SHA-256 (FIPS 180-4) ---------------------------------------------------------------------- */

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

/* Digest of two ranges of bytes, one behind the other. */
static void rbti_sha256(const uint8_t *first, size_t n_first, const uint8_t *rest, size_t n_rest,
                        uint8_t digest[32])
{
    uint32_t state[8] = {0x6a09e667u, 0xbb67ae85u, 0x3c6ef372u, 0xa54ff53au,
                         0x510e527fu, 0x9b05688cu, 0x1f83d9abu, 0x5be0cd19u};
    const size_t n = n_first + n_rest, padded = (n + 8) / 64 * 64 + 64;
    for (size_t at = 0; at < padded; at += 64) {
        uint8_t block[64];
        if (at >= n_first && at + 64 <= n) {
            rbti_sha_block(state, rest + (at - n_first));
            continue;
        }
        for (size_t k = at; k < at + 64; k++)
            block[k - at] = (uint8_t)(k < n_first       ? first[k]
                                      : k < n           ? rest[k - n_first]
                                      : k == n          ? 0x80
                                      : k >= padded - 8 ? (uint64_t)n * 8 >> 8 * (padded - 1 - k)
                                                        : 0);
        rbti_sha_block(state, block);
    }
    for (int k = 0; k < 32; k++)
        digest[k] = (uint8_t)(state[k / 4] >> (24 - 8 * (k % 4)));
}

#endif

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

/* Size of what is known of a header: those of older versions are shorter, those of newer ones longer. */
static RBT_DEVICE size_t rbti_header_bytes(const rbti_header *header)
{
    return header->header_bytes < sizeof *header ? header->header_bytes : sizeof *header;
}

/* Header of an image, and what older ones do not say: any speed and any spin is valid. */
static RBT_DEVICE void rbti_read_header(const char *image, rbti_header *header)
{
    const double speeds[2] = {0.0, 1e300}, spins[2] = {RBTI_ANY_SPIN_BOUNDS};
    memset(header, 0, sizeof *header);
    memcpy(header, image, RBTI_FIRST_HEADER_BYTES);
    memcpy(header->valid_speed, speeds, sizeof speeds);
    memcpy(header->spin_size, spins, sizeof spins);
    memcpy(header, image, rbti_header_bytes(header));
}

#ifndef RBT_DEVICE_ONLY

static int rbti_check_start(const char *image, size_t size, rbti_header *header)
{
    const uint32_t one = 1;
    uint8_t least;
    memcpy(&least, &one, 1);
    RBTI_NEED(least == 1, RBT_ERR_BIG_ENDIAN);
    RBTI_NEED(size >= 8 && memcmp(image, RBTI_MAGIC, 8) == 0, RBT_ERR_FORMAT);
    RBTI_NEED(size >= RBTI_FIRST_HEADER_BYTES, RBT_ERR_SIZE);
    memcpy(header, image, RBTI_FIRST_HEADER_BYTES);
    RBTI_NEED(header->major == RBTI_MAJOR, RBT_ERR_VERSION);
    RBTI_NEED(header->header_bytes >= RBTI_FIRST_HEADER_BYTES && size >= header->header_bytes,
              RBT_ERR_SIZE);
    RBTI_NEED(header->file_bytes == size && size < RBTI_MOST_BYTES, RBT_ERR_SIZE);
    rbti_read_header(image, header);
    return RBT_OK;
}

static int rbti_check_sum(const char *image, size_t size, const rbti_header *header)
{
    const size_t at = offsetof(rbti_header, sha256);
    uint8_t digest[32];
    const uint8_t *bytes = (const uint8_t *)image;
    rbti_sha256(bytes, at, bytes + at + 32, size - at - 32, digest);
    return memcmp(digest, header->sha256, 32) == 0 ? RBT_OK : RBT_ERR_CHECKSUM;
}

static int rbti_check_dimensions(const rbti_header *h)
{
#define RBTI_DO(name, least, most)                                                                 \
    RBTI_NEED(h->name >= least && h->name <= most, RBT_ERR_DIMENSIONS);
    RBTI_DIMENSIONS(RBTI_DO)
    if (h->n_shapes > 0) {
        RBTI_SPIN_DIMENSIONS(RBTI_DO)
    }
#undef RBTI_DO
    const uint32_t needed = 1 + h->n_channels + h->n_channels * (h->n_channels + 1) / 2;
    uint32_t stride = 1;
    while (stride < needed)
        stride *= 2;
    RBTI_NEED(h->stride == stride, RBT_ERR_DIMENSIONS);
    return RBT_OK;
}

/* Whether the name of the pair ends in the header, and has no bytes that control a terminal. */
static int rbti_pair_holds(const rbti_header *h)
{
    unsigned before = 0;
    for (size_t k = 0; k < sizeof h->pair; k++) {
        const unsigned byte = (unsigned char)h->pair[k];
        if (byte == 0)
            return 1;
        if (byte < 0x20 || byte == 0x7f || (before == 0xc2 && byte < 0xa0))
            return 0;
        before = byte;
    }
    return 0;
}

/* Bits of n names, all below a number and different, followed by -1 only; 0 if they are not. */
static unsigned rbti_name_bits(const int8_t names[RBTI_NAMES], uint32_t n, int known)
{
    unsigned bits = 0;
    for (uint32_t k = 0; k < RBTI_NAMES; k++) {
        if (k >= n) {
            if (names[k] != -1)
                return 0;
            continue;
        }
        if (names[k] < 0 || names[k] >= known || (bits >> names[k] & 1u))
            return 0;
        bits |= 1u << names[k];
    }
    return bits;
}

static int rbti_check_names(const rbti_header *h)
{
    static const unsigned needs[RBT_VALUES] = RBTI_NEEDS;
    RBTI_NEED(rbti_pair_holds(h), RBT_ERR_NAMES);
    RBTI_NEED(rbti_name_bits(h->channels, h->n_channels, RBTI_CHANNELS), RBT_ERR_NAMES);
    RBTI_NEED(rbti_name_bits(h->columns, h->n_columns, RBT_VALUES), RBT_ERR_NAMES);
    unsigned needed = 0, held = 0;
    uint32_t marginals = 0;
    for (uint32_t k = 0; k < RBTI_NAMES; k++) {
        if (h->marginals[k] != -1) {
            RBTI_NEED(k < h->n_channels && h->marginals[k] == (int)marginals, RBT_ERR_NAMES);
            marginals++;
            held |= 1u << h->channels[k];
        }
        if (k < h->n_columns)
            needed |= needs[h->columns[k]];
    }
    /* a table that lost its works still gives out u and w after them */
    RBTI_NEED(held == needed || held == (needed | RBTI_NORMAL_HAT), RBT_ERR_NAMES);
    RBTI_NEED(marginals == h->n_marginals, RBT_ERR_NAMES);
    return RBT_OK;
}

/* Whether rows of numbers, and extra numbers behind them, lie in the file at an aligned offset.
   Rows and numbers are below 2^38 each, and a quotient rounded down cannot mislead. */
static int rbti_lies(const rbti_header *h, uint64_t at, uint64_t rows, uint64_t numbers,
                     uint64_t extra, uint64_t bytes)
{
    if (at % 64 != 0 || at < rbti_header_bytes(h) || at > h->file_bytes)
        return 0;
    const uint64_t room = (h->file_bytes - at) / bytes;
    return extra <= room && rows <= (room - extra) / numbers;
}

static int rbti_check_offsets(const rbti_header *h)
{
#define RBTI_DO(name, member, type, rows, numbers, extra)                                          \
    RBTI_NEED(rbti_lies(h, h->at_##name, rows, numbers, extra, sizeof(type)), RBT_ERR_OFFSETS);
    RBTI_ARRAYS(RBTI_DO)
    if (h->n_shapes > 0) {
        RBTI_SPIN_ARRAYS(RBTI_DO)
        if (h->at_shape_inertia > 0)
            RBTI_INERTIA_ARRAYS(RBTI_DO)
        if (h->n_laws > 0)
            RBTI_LAW_ARRAYS(RBTI_DO)
    }
#undef RBTI_DO
    return RBT_OK;
}

/* Whether a number is finite and within bounds. */
static int rbti_within(double x, double least, double most)
{
    return rbti_finite(x) && least <= x && x <= most;
}

static int rbti_range_holds(double first, double last, double least, double largest)
{
    return rbti_within(first, least, largest) && rbti_within(last, first, largest);
}

static int rbti_axis_holds(const rbt_axis *a, double least, double largest)
{
    const int one = a->first == a->last;
    return rbti_range_holds(a->first, a->last, least, largest) &&
           rbti_within(a->origin, 0.0, a->first) && rbti_finite(a->scale) && a->scale >= 0.0 &&
           (a->nodes == 1) == one &&
           (a->scale > 0.0 || (one && a->origin == a->first && a->offset == 0)) &&
           (a->last - a->origin) * a->scale <= (a->grid - 1.0) * (1.0 + 1e-9);
}

static int rbti_check_axes(const rbt_table *table)
{
    const double variate[2] = {RBTI_VARIATE_BOUNDS};
    RBTI_NEED(rbti_axis_holds(&table->alpha, RBTI_ALPHA_BOUNDS), RBT_ERR_AXES);
    RBTI_NEED(rbti_axis_holds(&table->speed, RBTI_SPEED_BOUNDS), RBT_ERR_AXES);
    RBTI_NEED(rbti_within(table->variate_max, variate[0], variate[1]), RBT_ERR_AXES);
    RBTI_NEED(rbti_range_holds(table->valid_speed[0], table->valid_speed[1], 0.0, 1e300),
              RBT_ERR_AXES);
    RBTI_NEED(rbti_within(table->least_inertia, 0.0, RBTI_INERTIA), RBT_ERR_AXES);
    return RBT_OK;
}

/* Ranges of the spin law. */
static int rbti_check_spin_axes(const rbt_spin_law *law)
{
    const double bounds[2] = {RBTI_SPEED_COORDINATE_BOUNDS};
    RBTI_NEED(rbti_range_holds(law->alpha_first, law->alpha_last, RBTI_ALPHA_BOUNDS),
              RBT_ERR_AXES);
    RBTI_NEED(rbti_range_holds(law->speed_first, law->speed_last, RBTI_SPIN_SPEED_BOUNDS),
              RBT_ERR_AXES);
    RBTI_NEED(rbti_range_holds(law->least_spin, law->most_spin, 0.0, 1.1e300), RBT_ERR_AXES);
    RBTI_NEED(rbti_within(law->speed_scale, 0.0, RBTI_MOST_SPEED_SCALE) &&
                  rbti_within(law->speed_exponent, bounds[0], bounds[1]),
              RBT_ERR_AXES);
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
    return fabs(found - number) <= RBTI_NUMBER_ROUNDING;
}

static int rbti_coordinate_holds(const rbt_axis *axis)
{
    const double *values = axis->coordinate;
    int holds = 1;
    for (int32_t k = 0; k < axis->grid && holds; k++) {
        holds = rbti_within(values[k], 0.0, RBTI_MOST_NUMBER);
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
            RBTI_NEED(rbti_finite(number), RBT_ERR_NORMALS);
            sum += fabs(number);
        }
        RBTI_NEED(sum <= 16.0, RBT_ERR_NORMALS);
    }
    return RBT_OK;
}

static int rbti_check_classes(const rbt_table *table, size_t nodes)
{
    const size_t classes = (size_t)table->n_classes;
    for (size_t node = 0; node < nodes; node++) {
        const uint16_t *first = table->first_of_class + node * classes;
        RBTI_NEED(first[0] == 0, RBT_ERR_CLASSES);
        for (size_t k = 0; k < classes; k++)
            RBTI_NEED(first[k] <= table->n_components && (k == 0 || first[k] >= first[k - 1]),
                      RBT_ERR_CLASSES);
    }
    return RBT_OK;
}

static int rbti_check_components(const rbt_table *table, size_t components)
{
    for (size_t k = 0; k < components; k++) {
        const int16_t *record = table->components + k * (size_t)table->stride;
        RBTI_NEED(record[0] >= 0 && record[0] <= 4096, RBT_ERR_COMPONENTS);
        const int16_t *diagonal = record + 1 + table->n_channels;
        for (int32_t left = table->n_channels; left > 0; left--) {
            RBTI_NEED(*diagonal > 0, RBT_ERR_COMPONENTS);
            diagonal += left;
        }
    }
    return RBT_OK;
}

/* Every quantile within its bounds, which for v and the shares _hat are those of physics. */
static int rbti_check_spans(const rbt_table *table, size_t groups)
{
    static const double low[RBTI_CHANNELS] = RBTI_LEAST_QUANTILES;
    static const double high[RBTI_CHANNELS] = RBTI_MOST_QUANTILES;
    for (int32_t row = 0; row < table->n_channels; row++) {
        const int channel = table->channels[row];
        if (table->marginals[row] < 0)
            continue;
        for (size_t k = 0; k < groups; k++) {
            const double *span =
                table->spans + 2 * (k * (size_t)table->n_marginals + (size_t)table->marginals[row]);
            const double least = span[0], most = span[0] + span[1] * (65535.0 * (1.0 + 1e-6));
            RBTI_NEED(rbti_finite(least) && rbti_finite(span[1]) && rbti_finite(most) &&
                          span[1] >= 0.0 && low[channel] < least && most < high[channel],
                      RBT_ERR_SPANS);
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
        RBTI_NEED(!falls, RBT_ERR_QUANTILES);
    }
    return RBT_OK;
}

/* Shapes and laws of the ratios; a draw keeps ratios within their ends whatever the laws are. */
static int rbti_check_grains(const rbt_spin_law *law)
{
    double share = 0.0;
    for (int32_t k = 0; k < law->n_shapes; k++) {
        const double *ratios = law->shape_ratios + 2 * k;
        RBTI_NEED(law->shape_codes[k] >= 0, RBT_ERR_GRAINS);
        RBTI_NEED(rbti_within(law->shape_shares[k], share, 1.0), RBT_ERR_GRAINS);
        share = law->shape_shares[k];
        RBTI_NEED((ratios[0] == 0.0 && ratios[1] == 0.0) ||
                      (rbti_within(ratios[0], RBTI_LEAST_RATIO, 1.0) &&
                       rbti_within(ratios[1], RBTI_LEAST_RATIO, 1.0)),
                  RBT_ERR_GRAINS);
    }
    for (int32_t k = 0; k < 2 * law->n_shapes && law->shape_inertia; k++)
        RBTI_NEED(law->shape_inertia[k] > 0.0 && law->shape_inertia[k] <= 1.0, RBT_ERR_GRAINS);
    RBTI_NEED(share == 1.0, RBT_ERR_GRAINS);
    for (int k = 0; k < 8; k += 4) {
        const double *of = law->aspect + k;
        RBTI_NEED(rbti_within(of[0], -100.0, 100.0) && rbti_within(of[1], 0.0, 100.0) &&
                      rbti_within(of[2], 0.0, 1.0) && rbti_within(of[3], of[2], 1.0),
                  RBT_ERR_GRAINS);
    }
    return RBT_OK;
}

/* Every path through a tree goes on to later nodes, and so ends, in a leaf. */
static int rbti_check_trees(const rbt_spin_law *law)
{
    for (int32_t k = 0; k < law->n_shapes; k++)
        RBTI_NEED(law->roots[k] >= 0 && law->roots[k] < law->n_nodes, RBT_ERR_TREES);
    for (int32_t k = 0; k < law->n_nodes; k++) {
        RBTI_NEED(law->node_axis[k] >= 0 && law->node_axis[k] <= RBTI_SQUARE, RBT_ERR_TREES);
        RBTI_NEED(rbti_within(law->node_cut[k], -RBTI_MOST_CUT, RBTI_MOST_CUT), RBT_ERR_TREES);
        for (int side = 0; side < 2; side++) {
            const int32_t child = law->node_child[2 * k + side];
            RBTI_NEED(child >= 0 ? child > k && child < law->n_nodes : child >= -law->n_leaves,
                      RBT_ERR_TREES);
        }
    }
    return RBT_OK;
}

static int rbti_check_leaves(const rbt_spin_law *law)
{
    const size_t leaves = (size_t)law->n_leaves, outcomes = (size_t)law->n_outcomes;
    const size_t experts = leaves * RBTI_GROUPS * RBTI_GROUP_SIZE;
    for (size_t k = 0; k < leaves * RBTI_INPUTS; k++) {
        const float *of = law->inputs + k / RBTI_INPUTS * (2 * RBTI_INPUTS) + k % RBTI_INPUTS;
        RBTI_NEED(rbti_within((double)of[0], -RBTI_MOST_MIDDLE, RBTI_MOST_MIDDLE), RBT_ERR_LEAVES);
        RBTI_NEED(rbti_within((double)of[RBTI_INPUTS], 0.0, RBTI_MOST_SCALE), RBT_ERR_LEAVES);
    }
    for (size_t k = 0; k < experts; k++) {
        const int16_t *diagonal =
            law->experts + k * rbti_expert_stride(outcomes) + RBTI_FEATURES * outcomes;
        for (int left = law->n_outcomes; left > 0; left--) {
            RBTI_NEED(*diagonal > 0, RBT_ERR_LEAVES);
            diagonal += left;
        }
    }
    return RBT_OK;
}

/* Every outcome within bounds; that of v is not negative, and from the second knot on so far above 0
   that no draw of v is rounded to it. */
static int rbti_check_outcomes(const rbt_spin_law *law, int less_spheres)
{
    const double bounds[2] = {RBTI_OUTCOME_BOUNDS}, slack = 1.0 + 1e-6;
    const size_t knots = (size_t)law->n_knots, outcomes = (size_t)law->n_outcomes;
    const size_t functions = (size_t)law->n_leaves * outcomes;
    for (size_t k = 0; k < functions; k++) {
        const double least = (double)law->spans[2 * k], step = (double)law->spans[2 * k + 1];
        const uint16_t *steps = law->quantiles + k * knots;
        const int of_v = !less_spheres && k % outcomes == 1;
        unsigned falls = 0;
        RBTI_NEED(rbti_within(least, of_v ? 0.0 : bounds[0], bounds[1]) &&
                      rbti_within(step, 0.0, bounds[1]) && least + step * 65535.0 <= bounds[1] * slack,
                  RBT_ERR_SPANS);
        RBTI_NEED(!of_v || least + step * (double)steps[1] >= RBTI_LEAST_V, RBT_ERR_SPANS);
        for (size_t m = 1; m < knots; m++)
            falls |= steps[m] < steps[m - 1];
        RBTI_NEED(!falls, RBT_ERR_QUANTILES);
    }
    return RBT_OK;
}

/* Whether numbers are a table over angles and at most so many speeds. */
static int rbti_is_table(const double *numbers, int count, double speeds)
{
    const double n = count < 2 ? 0.0 : numbers[0], m = count < 2 ? 0.0 : numbers[1];
    int holds = n >= 1.0 && m >= 1.0 && m <= speeds && floor(n) == n && floor(m) == m &&
                (double)count == 2.0 + n + m + n * m;
    for (int k = 3; holds && k < 2 + (int)n + (int)m; k++)
        holds = k == 2 + (int)n || numbers[k] > numbers[k - 1];
    return holds;
}

/* Laws of contact, of finite numbers. */
static int rbti_check_laws(const rbt_table *table)
{
    const double *law = table->laws;
    const int32_t count = table->n_laws;
    RBTI_NEED(count >= RBTI_NUMBERS, RBT_ERR_DIMENSIONS);
    for (int32_t k = 0; k < count; k++)
        RBTI_NEED(rbti_finite(law[k]), RBT_ERR_DIMENSIONS);
    RBTI_NEED(law[RBTI_RESOLUTION] > 0.0 && law[RBTI_RESOLUTION] <= RBTI_GRAZING &&
                  rbti_within(law[RBTI_RESTITUTION], RBTI_EXPONENTIAL, RBTI_TABULATED) &&
                  rbti_within(law[RBTI_RESISTANCE], RBTI_ORIENTATION, RBTI_COULOMB) &&
                  rbti_within(law[RBTI_LENGTH], 0.0, (double)(count - RBTI_NUMBERS)),
              RBT_ERR_DIMENSIONS);
    const int length = (int)law[RBTI_LENGTH], left = count - RBTI_NUMBERS - length;
    const int needed = (int)law[RBTI_RESISTANCE] == RBTI_TABULATED_RESISTANCE || left > 0;
    RBTI_NEED(((int)law[RBTI_RESTITUTION] != RBTI_TABULATED ||
               rbti_is_table(law + RBTI_NUMBERS, length, (double)length)) &&
                  (!needed || rbti_is_table(law + RBTI_NUMBERS + length, left, 1.0)),
              RBT_ERR_DIMENSIONS);
    return RBT_OK;
}

static int rbti_check_spin_law(const rbt_table *table)
{
    const rbt_spin_law *law = &table->spin;
    if (table->n_laws > 0)
        RBTI_CHECK(rbti_check_laws(table));
    RBTI_CHECK(rbti_check_spin_axes(law));
    RBTI_CHECK(rbti_check_grains(law));
    RBTI_CHECK(rbti_check_trees(law));
    RBTI_CHECK(rbti_check_leaves(law));
    return rbti_check_outcomes(law, table->n_laws > 0);
}

static int rbti_check_values(const rbt_table *table, const rbti_header *header)
{
    const size_t nodes = (size_t)rbti_nodes(header);
    const size_t components = nodes * header->n_components;
    const size_t groups = (size_t)rbti_cells(header) * header->n_classes;
    RBTI_NEED(rbti_coordinate_holds(&table->alpha), RBT_ERR_COORDINATES);
    RBTI_NEED(rbti_coordinate_holds(&table->speed), RBT_ERR_COORDINATES);
    RBTI_CHECK(rbti_check_normals(table->normals));
    for (size_t k = 0; k < components; k++)
        RBTI_NEED((table->alias[k] & 0xffffu) < header->n_components, RBT_ERR_ALIAS);
    RBTI_CHECK(rbti_check_classes(table, nodes));
    RBTI_CHECK(rbti_check_components(table, components));
    RBTI_CHECK(rbti_check_spans(table, groups));
    RBTI_CHECK(rbti_check_quantiles(table, groups * header->n_marginals));
    return header->n_shapes > 0 ? rbti_check_spin_law(table) : RBT_OK;
}

#endif

static RBT_DEVICE void rbti_fill_axis(rbt_axis *axis, const double ends_origin_scale[4],
                                      int32_t offset, uint32_t nodes, uint32_t grid)
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

/* Numbers of the spin law; none of a table without it. */
static RBT_DEVICE void rbti_fill_spin_law(rbt_spin_law *law, const rbti_header *h)
{
    law->n_shapes = (int32_t)h->n_shapes;
    if (law->n_shapes == 0)
        return;
    law->n_nodes = (int32_t)h->n_nodes;
    law->n_leaves = (int32_t)h->n_leaves;
    law->n_knots = (int32_t)h->n_spin_knots;
    law->n_outcomes = (int32_t)rbti_outcomes(h);
    law->alpha_first = h->spin_alpha[0];
    law->alpha_last = h->spin_alpha[1];
    law->alpha_low = law->alpha_first * (1.0 - RBTI_ROUNDING);
    law->alpha_high = law->alpha_last * (1.0 + RBTI_ROUNDING);
    law->speed_first = h->spin_speed[0];
    law->speed_last = h->spin_speed[1];
    law->speed_low = law->speed_first * (1.0 - RBTI_ROUNDING);
    law->speed_high = law->speed_last * (1.0 + RBTI_ROUNDING);
    if (h->flags & RBTI_SPEED_INDEPENDENT) {
        const double any[2] = {RBTI_ANY_SPEED_BOUNDS};
        law->speed_low = any[0];
        law->speed_high = any[1];
    }
    law->speed_scale = h->spin_coordinate[0];
    law->speed_exponent = h->spin_coordinate[1];
    law->for_first = (h->flags & RBTI_OTHER_POPULATION) != 0;
    law->least_spin = h->spin_size[0] * h->spin_size[0] * (1.0 - RBTI_ROUNDING);
    law->most_spin = h->spin_size[1] * h->spin_size[1] * (1.0 + RBTI_ROUNDING);
    memcpy(law->aspect, h->aspect, sizeof law->aspect);
}

static RBT_DEVICE void rbti_fill_table(rbt_table *table, const rbti_header *h)
{
    const double alpha[4] = {h->alpha_first, h->alpha_last, h->alpha_origin, h->alpha_scale};
    const double speed[4] = {h->speed_first, h->speed_last, h->speed_origin, h->speed_scale};
    rbti_fill_axis(&table->alpha, alpha, h->alpha_offset, h->n_alpha, h->n_alpha_grid);
    rbti_fill_axis(&table->speed, speed, h->speed_offset, h->n_speed, h->n_speed_grid);
    if (h->flags & RBTI_SPEED_INDEPENDENT) { /* any that is positive and finite */
        const double any[2] = {RBTI_ANY_SPEED_BOUNDS};
        table->speed.low = any[0];
        table->speed.high = any[1];
    }
    table->spheres = (h->flags & RBTI_SPHERES) != 0;
    table->n_laws = (int32_t)(table->spheres ? h->n_alpha_grid : h->n_shapes > 0 ? h->n_laws : 0);
    table->variate_max = h->variate_max;
    if (!table->spheres)
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
    for (uint32_t k = 0; k < h->n_columns; k++)
        table->held |= 1u << h->columns[k];
    memcpy(table->valid_speed, h->valid_speed, sizeof table->valid_speed);
    table->least_inertia = h->least_inertia;
    rbti_fill_spin_law(&table->spin, h);
    if (table->spheres) { /* at any angle, speed and spin */
        const double any[2] = {RBTI_ANY_SPEED_BOUNDS};
        table->alpha.low = table->speed.low = RBTI_LEAST_ANGLE;
        table->spin.alpha_low = table->spin.speed_low = RBTI_LEAST_ANGLE;
        table->alpha.high = table->spin.alpha_high = RBTI_HALF_PI + RBTI_ROUNDING;
        table->speed.high = table->spin.speed_high = table->spin.most_spin = any[1];
    }
    for (uint32_t row = 0; row < RBTI_NAMES; row++) {
        const int channel = h->channels[row];
        const int mirrored = channel >= RBTI_FIRST_MIRRORED && channel < RBTI_END_MIRRORED;
        table->mirrored[row] = (int8_t)mirrored;
    }
    memcpy(table->pair, h->pair, sizeof table->pair);
    table->pair[sizeof table->pair - 1] = 0;
}

/* Let a table read the arrays of an image at some address. */
static RBT_DEVICE void rbti_point(rbt_table *table, const rbti_header *h, const char *image)
{
    table->image = image;
#define RBTI_DO(name, member, type, rows, numbers, extra)                                          \
    table->member = (const type *)(const void *)(image + h->at_##name);
    RBTI_ARRAYS(RBTI_DO)
    if (h->n_shapes > 0) {
        RBTI_SPIN_ARRAYS(RBTI_DO)
        if (h->at_shape_inertia > 0)
            RBTI_INERTIA_ARRAYS(RBTI_DO)
        if (h->n_laws > 0)
            RBTI_LAW_ARRAYS(RBTI_DO)
    }
#undef RBTI_DO
    if (table->spheres)
        table->laws = table->alpha.coordinate;
}

RBT_API RBT_DEVICE rbt_table rbt_unchecked(const void *image, size_t size)
{
    rbti_header header;
    rbt_table table;
    memset(&table, 0, sizeof table);
    rbti_read_header((const char *)image, &header);
    rbti_fill_table(&table, &header);
    rbti_point(&table, &header, (const char *)image);
    table.image_size = size;
    return table;
}

#ifndef RBT_DEVICE_ONLY

/* Check an image of spheres and fill a table from it. */
static int rbti_read_spheres(const char *image, const rbti_header *h, rbt_table *table)
{
    RBTI_NEED(rbti_pair_holds(h) && rbti_name_bits(h->columns, h->n_columns, RBT_VALUES),
              RBT_ERR_NAMES);
    RBTI_NEED(h->n_columns <= RBTI_NAMES && h->n_shapes == 1, RBT_ERR_DIMENSIONS);
    RBTI_NEED(rbti_lies(h, h->at_alpha_coordinate, h->n_alpha_grid, 1, 0, sizeof(double)) &&
                  rbti_lies(h, h->at_shape_codes, 1, 1, 0, sizeof(int32_t)) &&
                  rbti_lies(h, h->at_shape_shares, 1, 1, 0, sizeof(double)) &&
                  rbti_lies(h, h->at_shape_ratios, 1, 2, 0, sizeof(double)),
              RBT_ERR_OFFSETS);
    RBTI_NEED(rbti_range_holds(h->valid_speed[0], h->valid_speed[1], 0.0, 1e300), RBT_ERR_AXES);
    rbti_fill_table(table, h);
    rbti_point(table, h, image);
    RBTI_CHECK(rbti_check_laws(table));
    return rbti_check_grains(&table->spin);
}

/* Check an image and fill a table from it. */
static int rbti_read(const char *image, size_t size, rbt_table *table)
{
    rbti_header header;
    memset(table, 0, sizeof *table);
    RBTI_CHECK(rbti_check_start(image, size, &header));
    RBTI_CHECK(rbti_check_sum(image, size, &header));
    table->image_size = size;
    if (header.flags & RBTI_SPHERES)
        return rbti_read_spheres(image, &header, table);
    RBTI_CHECK(rbti_check_dimensions(&header));
    RBTI_CHECK(rbti_check_names(&header));
    RBTI_CHECK(rbti_check_offsets(&header));
    rbti_fill_table(table, &header);
    RBTI_CHECK(rbti_check_axes(table));
    rbti_point(table, &header, image);
    return rbti_check_values(table, &header);
}

RBT_API int rbt_open_memory(const void *image, size_t size, rbt_table **table)
{
    *table = NULL;
    if ((uintptr_t)image % 64 != 0)
        return RBT_ERR_OFFSETS;
    rbt_table *made = (rbt_table *)RBT_MALLOC(sizeof *made);
    if (!made)
        return RBT_ERR_NO_MEMORY;
    const int code = rbti_read((const char *)image, size, made);
    if (code == RBT_OK)
        *table = made;
    else
        RBT_FREE(made);
    return code;
}

#ifdef RBTI_MMAP

RBT_API int rbt_open(const char *path, rbt_table **table)
{
    *table = NULL;
    const int file = open(path, O_RDONLY | O_NONBLOCK); /* a pipe is not waited for */
    if (file < 0)
        return RBT_ERR_NOT_OPENED;
    struct stat about;
    if (fstat(file, &about) != 0 || !S_ISREG(about.st_mode)) {
        close(file);
        return RBT_ERR_NOT_READ;
    }
    if (about.st_size <= 0 || about.st_size >= (off_t)RBTI_MOST_BYTES) {
        close(file);
        return about.st_size <= 0 ? RBT_ERR_FORMAT : RBT_ERR_SIZE;
    }
    const size_t size = (size_t)about.st_size;
    void *image = mmap(NULL, size, PROT_READ, MAP_PRIVATE, file, 0);
    close(file);
    if (image == MAP_FAILED)
        return RBT_ERR_NOT_READ;
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
        return RBT_ERR_NOT_READ;
    const long end = ftell(file);
    if (end < 0 || fseek(file, 0, SEEK_SET) != 0)
        return RBT_ERR_NOT_READ;
    if ((unsigned long)end >= RBTI_MOST_BYTES)
        return RBT_ERR_SIZE;
    *size = (size_t)end;
    *memory = RBT_MALLOC(*size + 64);
    if (!*memory)
        return RBT_ERR_NO_MEMORY;
    *image = (char *)*memory + (64 - (uintptr_t)*memory % 64) % 64;
    return fread(*image, 1, *size, file) == *size ? RBT_OK : RBT_ERR_NOT_READ;
}

RBT_API int rbt_open(const char *path, rbt_table **table)
{
    *table = NULL;
#ifdef RBTI_POSIX
    struct stat about; /* opening a pipe would wait */
    if (stat(path, &about) == 0 && !S_ISREG(about.st_mode))
        return RBT_ERR_NOT_READ;
#endif
    FILE *file = fopen(path, "rb");
    if (!file)
        return RBT_ERR_NOT_OPENED;
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
        RBT_FREE(memory);
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
    RBT_FREE(table->to_free);
    RBT_FREE(table);
}

RBT_API const char *rbt_strerror(int code)
{
    static const struct {
        int code;
        const char *text;
    } texts[] = {
/* begin texts */
        {RBT_OK, "fine"},
        {RBT_CLAMPED, "angle or speed outside the table, whose nearest condition was "
         "used, or a spin beyond it"},
        {RBT_EXTRAPOLATED, "a speed at which the material pair was not measured"},
        {RBT_ERR_NOT_FINITE, "arguments: allowed: finite numbers, speeds below 1e150 m/s"},
        {RBT_ERR_NOT_APPROACHING, "alpha1: allowed: above 0, at most pi/2 rad; velocity: allowed:"
         " towards the wall, (velocity - wall_velocity) . normal < 0"},
        {RBT_ERR_SPEED_NOT_POSITIVE, "speed: allowed: above 0 m/s; velocity: allowed: 1e-150 m/s or "
         "more relative to the wall"},
        {RBT_ERR_NORMAL_NOT_USABLE, "normal: allowed: any length but zero"},
        {RBT_ERR_HALF_SIZE_NOT_POSITIVE, "half_size: allowed: 1e-30 m or more"},
        {RBT_ERR_TILT_NOT_FOUND, "roughness: no tilt of a facet was accepted"},
        {RBT_ERR_CASCADE_NOT_ENDED, "roughness: bounces without end"},
        {RBT_ERR_ROUGHNESS_NOT_USABLE, "roughness: allowed: 0 to 0.5 rad; of a profile: ra and rq 0 or"
         " more, rsm and diameter above 0, and a tilt within that"},
        {RBT_ERR_NO_SPIN_LAW, "spin: the table was made without it, allowed: none (NULL), or "
         "a table with a spin law"},
        {RBT_ERR_NOT_OPENED, "file: cannot be opened, allowed: a regular file that exists "
         "and may be read"},
        {RBT_ERR_NOT_READ, "file: cannot be read, or is a folder, pipe or device"},
        {RBT_ERR_NO_MEMORY, "memory: not enough for this table"},
        {RBT_ERR_BIG_ENDIAN, "machine: is big-endian, allowed: little-endian"},
        {RBT_ERR_FORMAT, "format: is no binary rebound table (.rbt)"},
        {RBT_ERR_VERSION, "format_version: allowed: 1.x (a newer file needs a newer "
         "rebound-tables)"},
        {RBT_ERR_SIZE, "file_bytes: the file is truncated, or longer than it says"},
        {RBT_ERR_CHECKSUM, "sha256: the contents do not have this checksum"},
        {RBT_ERR_DIMENSIONS, "dimensions: one is 0 or too large, or does not fit the others"},
        {RBT_ERR_NAMES, "names: a channel or column is unknown, occurs twice or lacks "
         "what it is made of, or the pair has characters that control "
         "terminals"},
        {RBT_ERR_OFFSETS, "offsets: an array does not lie in the file on a multiple of 64"},
        {RBT_ERR_AXES, "axes: allowed: growing, angles from 1e-09 to 90 degrees, "
         "speeds from 1e-09 to 1e+09 m/s, last variate from 0.001 to "
         "1e+06"},
        {RBT_ERR_COORDINATES, "coordinates: allowed: growing from 0 to 1e+06, whole at the "
         "first and the last node"},
        {RBT_ERR_NORMALS, "normals: allowed: finite cubics below 16"},
        {RBT_ERR_ALIAS, "alias: a component is not below their number"},
        {RBT_ERR_CLASSES, "first_of_class: allowed: from 0, non-decreasing, at most the "
         "number of components"},
        {RBT_ERR_COMPONENTS, "components: allowed: reflection from 0 to 4096, diagonals "
         "positive"},
        {RBT_ERR_SPANS, "spans: allowed: finite and within what is physical"},
        {RBT_ERR_QUANTILES, "quantiles: allowed: non-decreasing from knot to knot"},
        {RBT_ERR_GRAINS, "grains: allowed: shares that grow to 1, probabilities that "
         "grow, ratios from 0.001 to 1"},
        {RBT_ERR_TREES, "trees: allowed: cuts within 1000, children that are a later "
         "node or a leaf"},
        {RBT_ERR_LEAVES, "leaves: allowed: middles within 1000, factors from 0 to 10000,"
         " diagonals positive"},
        {RBT_ERR_GRAIN_NOT_KNOWN, "grain: allowed: a shape of the spin law, and b/a and c/b from "
         "0.001 to 1"},
/* end texts */
        {RBT_CLAMPED | RBT_EXTRAPOLATED, "outside the table, and at a speed at which its pair was not "
         "measured"},
    };
    for (size_t k = 0; k < sizeof texts / sizeof *texts; k++)
        if (texts[k].code == code)
            return texts[k].text;
    return "unknown code";
}

#endif

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

/* -- torque of the gas ------------------------------------------------------------------------- */

/* Over that of Stokes, from RBTI_TORQUE_FROM on: A + B sqrt(Re). */
#define RBTI_TORQUE_FROM 32.0
#define RBTI_TORQUE_A (128.4 / (64.0 * RBTI_PI))
#define RBTI_TORQUE_B (12.9 / (64.0 * RBTI_PI))

/* The rotation of the gas less that of the particle, and its Reynolds number. */
RBTI_INLINE RBT_DEVICE double rbti_slip(const double omega[3], double diameter, double density,
                                        double viscosity, const double gas_rotation[3],
                                        double slip[3])
{
    for (int k = 0; k < 3; k++)
        slip[k] = (gas_rotation == NULL ? 0.0 : gas_rotation[k]) - omega[k];
    const double size = sqrt(slip[0] * slip[0] + slip[1] * slip[1] + slip[2] * slip[2]);
    return density * diameter * diameter * size / viscosity;
}

/* Share of the slip that is left after a time in relaxation times of Stokes. From RBTI_TORQUE_FROM on
   root = sqrt(Re) follows root' = -(A + B root) root / 2, so root / (A + B root) decays as
   exp(-A time / 2); the rest of the time the slip decays as exp(-time). */
RBTI_INLINE RBT_DEVICE double rbti_slip_left(double reynolds, double time)
{
    const double a = RBTI_TORQUE_A, b = RBTI_TORQUE_B, last = sqrt(RBTI_TORQUE_FROM);
    double root = last, above; /* part of the time that is spent there */
    if (reynolds < RBTI_TORQUE_FROM) {
        above = time + log(RBTI_TORQUE_FROM / (reynolds > 1e-200 ? reynolds : 1e-200));
        above = above < 0.0 ? above : 0.0;
    } else {
        root = sqrt(reynolds);
        above = 2.0 / a * log(root * (a + b * last) / (last * (a + b * root)));
        above = time < above ? time : above;
    }
    const double gone = expm1(-0.5 * a * above);
    double share = a * (1.0 + gone) / (a - b * root * gone);
    if (above < 0.0 && !(share > 0.0 && share * root < 1e3)) /* back in time it grew without end */
        share = root < 1e3 ? 1e3 / root : 1.0;
    return share * share * exp(above - time);
}

RBT_API RBT_DEVICE void rbt_gas_torque(const double omega[3], double diameter, double density,
                                       double viscosity, const double gas_rotation[3],
                                       double torque[3])
{
    double slip[3];
    const double reynolds = rbti_slip(omega, diameter, density, viscosity, gas_rotation, slip);
    const double law = reynolds < RBTI_TORQUE_FROM
                           ? 1.0
                           : RBTI_TORQUE_A + RBTI_TORQUE_B * sqrt(reynolds);
    for (int k = 0; k < 3; k++)
        torque[k] = RBTI_PI * viscosity * diameter * diameter * diameter * law * slip[k];
}

RBT_API RBT_DEVICE void rbt_spin_after(const double omega[3], double time, double inertia,
                                       double diameter, double density, double viscosity,
                                       const double gas_rotation[3], double new_omega[3])
{
    double slip[3];
    const double reynolds = rbti_slip(omega, diameter, density, viscosity, gas_rotation, slip);
    const double stokes = RBTI_PI * viscosity * diameter * diameter * diameter;
    const double left = rbti_slip_left(reynolds, stokes * time / inertia);
    for (int k = 0; k < 3; k++)
        new_omega[k] = (gas_rotation == NULL ? 0.0 : gas_rotation[k]) - left * slip[k];
}

/* -- sizes, and particles that stay on the wall -------------------------------------------------- */

/* Volume of a shape over a b c, by its code; 0: a mesh. */
RBTI_INLINE RBT_DEVICE double rbti_volume(double shape)
{
    const double volumes[5] = {4.0 / 3.0 * RBTI_PI, 8.0, 7.731986497631108, 8.0 / 3.0,
                               4.0 / 3.0 * RBTI_PI};
    return shape >= 0.0 && shape <= 4.0 ? volumes[(int)shape] : 0.0;
}

RBT_API RBT_DEVICE double rbt_half_size(double diameter, const double grain[3])
{
    const double volume = rbti_volume(grain[0]) * grain[1] * grain[1] * grain[2];
    return volume > 0.0 ? 0.5 * diameter * cbrt(4.0 / 3.0 * RBTI_PI / volume) : 0.0;
}

/* Mean of a power of a drawn ratio, at 256 midpoints: within 1e-6. */
RBTI_INLINE RBT_DEVICE double rbti_mean_power(const double law[4], double power)
{
    double ratio[RBTI_BLOCK], sum = 0.0;
    for (uint32_t k = 0; k < 256; k++) {
        const uint32_t word = (k << 24) + 0x800000u;
        rbti_fill_ratios(1, law, &word, ratio);
        sum += pow(ratio[0], power);
    }
    return sum / 256.0;
}

RBT_API RBT_DEVICE double rbt_mean_half_size(const rbt_table *table, double diameter)
{
    const rbt_spin_law *law = &table->spin;
    double before = 0.0, sum = 0.0;
    for (int32_t row = 0; row < law->n_shapes; row++) {
        const double *own = law->shape_ratios + 2 * row;
        const int drawn = own[0] == 0.0;
        const double grain[3] = {(double)law->shape_codes[row], drawn ? 1.0 : own[0],
                                 drawn ? 1.0 : own[1]};
        const double half = rbt_half_size(diameter, grain);
        if (half == 0.0)
            return 0.0;
        sum += (law->shape_shares[row] - before) * half *
               (drawn ? rbti_mean_power(law->aspect, -2.0 / 3.0) *
                            rbti_mean_power(law->aspect + 4, -1.0 / 3.0)
                      : 1.0);
        before = law->shape_shares[row];
    }
    return sum;
}

RBT_API RBT_DEVICE int rbt_deposits(const double velocity[3], const double normal[3],
                                    double critical_speed, const double wall_velocity[3])
{
    double relative[3], e_y[3];
    for (int k = 0; k < 3; k++)
        relative[k] = velocity[k] - (wall_velocity ? wall_velocity[k] : 0.0);
    rbti_unit(normal, e_y);
    const double approach = -rbti_dot(relative, e_y);
    return approach > 0.0 && approach < critical_speed;
}

#ifdef __cplusplus
}
#endif

#if defined(__GNUC__) && !defined(__clang__) && !defined(RBTI_GPU)
#pragma GCC pop_options
#endif

#endif /* REBOUND_SAMPLER_IMPLEMENTATION */
