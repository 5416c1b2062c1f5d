/* rebound_sampler.h - rebounds of non-spherical particles, drawn from a table, in C.

   One file of one C program or library says

       #define REBOUND_SAMPLER_IMPLEMENTATION
       #include "rebound_sampler.h"

   and any others include the header alone. C99, C++11 or later, CUDA or HIP; needs libc and libm, and
   in device code nothing. rebound_device.h has kernels for arrays.

       rbt_table *table;
       int code = rbt_open("corundum-steel.rbt", &table);
       if (code < 0) { fprintf(stderr, "%s\n", rbt_strerror(code)); exit(1); }
       const rbt_impacts impact = {.velocity = v, .normal = n, .half_size = &a, .omega = omega,
                                   .inertia = &k, .index = &particle, .hit = &hit};
       rbt_rebounds after = {.velocity = v, .omega = omega, .inertia = &k};
       code = rbt_rebound(table, 1, &impact, seed, &after);
       rbt_close(table);

   The file is what `sampler export T.h5 --output T.rbt` writes. Equal arguments give the states
   that the Python package gives, with the same bits whatever the compiler flags and the processor,
   and rebounds and spheres to the last digits of the C library's functions; but with
   -ffast-math, clang's -ffp-contract=fast, and on CUDA devices without -fmad=false, the same to
   rounding in single precision.

   Angles are in radians, everything else in SI units. A state is u, v, w over V and omega_x,
   omega_y, omega_z times a/V (V: impact speed, a: largest half-size of the particle) in the frame
   of the impact: x along the tangential velocity before impact, y along the wall normal into the
   gas.

   Threads: a table is never written after it was opened, and a draw is a pure function of its
   arguments that allocates nothing. Any number of threads may use one table at once; rbt_open and
   rbt_close of one table must not run beside other calls with it.

   Codes: 0 is fine, a positive code is a sum of flags, a negative one an error; rbt_strerror says what
   each means. A row with a flag was drawn; where it lies outside the table, at the nearest condition.
   Test `code & RBT_OUTSIDE` for that, not `code > 0`: RBT_EXTRAPOLATED is set in most rows where
   particles are slow. A row with an error has NaN in all of its results, but one that does not approach
   its wall (RBT_ERR_NOT_APPROACHING) has there what it arrived with. Nothing is printed: count both, and tell
   your user. A NULL where an array is required is an error as well, and then nothing is written.

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

/* Version of this library; codes, on which rbt_strerror says more; variables that a state can have.
   Written by `python -m sampler.formats.generated_code`, as are all parts between such marks. */
/* begin constants */
#define RBT_VERSION_MAJOR 1
#define RBT_VERSION_MINOR 0
#define RBT_OK 0
#define RBT_ANGLE 1
#define RBT_SPEED 2
#define RBT_SPIN 4
#define RBT_EXTRAPOLATED 8
#define RBT_ERR_MISSING (-1)
#define RBT_ERR_NOT_FINITE (-2)
#define RBT_ERR_NOT_APPROACHING (-3)
#define RBT_ERR_SPEED_NOT_POSITIVE (-4)
#define RBT_ERR_NORMAL_NOT_USABLE (-5)
#define RBT_ERR_HALF_SIZE (-6)
#define RBT_ERR_ROUGHNESS_NOT_USABLE (-7)
#define RBT_ERR_CASCADE_NOT_ENDED (-9)
#define RBT_ERR_NO_SPIN_LAW (-10)
#define RBT_ERR_GRAIN_NOT_KNOWN (-11)
#define RBT_ERR_NO_WORKS (-12)
#define RBT_ERR_NOT_OPENED (-20)
#define RBT_ERR_NOT_READ (-21)
#define RBT_ERR_NO_MEMORY (-22)
#define RBT_ERR_BIG_ENDIAN (-23)
#define RBT_ERR_FORMAT (-24)
#define RBT_ERR_VERSION (-25)
#define RBT_ERR_SIZE (-26)
#define RBT_ERR_CHECKSUM (-27)
#define RBT_ERR_DIMENSIONS (-28)
#define RBT_ERR_NAMES (-29)
#define RBT_ERR_OFFSETS (-30)
#define RBT_ERR_INDICES (-31)
#define RBT_OUTSIDE 7 /* RBT_ANGLE, RBT_SPEED or RBT_SPIN: outside the table */
/* variables of a state, in this order */
enum { RBT_U, RBT_V, RBT_W, RBT_OMEGA_X, RBT_OMEGA_Y, RBT_OMEGA_Z, RBT_ROTATIONAL_ENERGY,
       RBT_COLLISIONS, RBT_WORK_NORMAL, RBT_WORK_SHEAR, RBT_VALUES };
/* channels, in which these are stored */
enum { RBTI_OF_V, RBTI_OF_U_HAT, RBTI_OF_OMEGA_Z, RBTI_OF_W_HAT, RBTI_OF_OMEGA_X, RBTI_OF_OMEGA_Y,
       RBTI_OF_ENERGY_HAT, RBTI_OF_COLLISIONS, RBTI_OF_NORMAL_HAT, RBTI_CHANNELS };
#define RBTI_NAMES 8 /* most of either that a table has */
/* end constants */

/* Largest roughness of a wall, rad: beyond it a normal law of tilts describes no surface. */
#define RBT_MOST_ROUGHNESS 0.5

/* Half-sizes of particles, m: the smallest and the largest. Others are mistaken units. */
#define RBT_LEAST_HALF_SIZE 1e-9
#define RBT_MOST_HALF_SIZE 100.0

/* A result that must not be ignored, where compilers can say so. */
#if defined(__GNUC__)
#define RBT_MUST_USE __attribute__((warn_unused_result))
#else
#define RBT_MUST_USE
#endif

/* A table in memory. Its fields are for the functions below. */
typedef struct rbt_table rbt_table;

#ifndef RBT_DEVICE_ONLY

/* Open a binary table (.rbt) and check that it is whole: its checksum, and all that a draw takes as
   an index. What its numbers mean was checked when it was made.

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

/* One line on a return code, which names every flag of a sum; a constant string, never NULL. */
RBT_API const char *rbt_strerror(int code);

#endif

/* What a table covers, {smallest, largest}: impact angles, rad; impact speeds V, m/s; sizes of the spin
   before the impact, a |Omega| / V, {0, 0} without a spin law; and the speeds at which the law of the
   material pair was measured, beyond which it is extrapolated. A law that does not depend on the speed
   covers 1e-300 to 1e300 m/s. */
typedef struct rbt_range {
    double alpha1[2], speed[2], spin[2], measured[2];
} rbt_range;

/* RBT_OK or RBT_ERR_MISSING. */
RBT_API RBT_DEVICE int rbt_covered(const rbt_table *table, rbt_range *range);

/* Whether the table has a spin law, the law of particles that arrive spinning, which depends on their
   spin and on their grain, a shape and its ratios: 1 or 0. */
RBT_API RBT_DEVICE int rbt_has_spin_law(const rbt_table *table);

/* Variables in the columns of a state: how many, and which (RBT_U ... RBT_WORK_SHEAR). `columns` may be
   NULL. */
RBT_API RBT_DEVICE int rbt_variables(const rbt_table *table, int columns[RBT_VALUES]);

/* Name of the material pair, UTF-8; lives as long as the table. */
RBT_API RBT_DEVICE const char *rbt_pair(const rbt_table *table);

/* -- draws and rebounds ---------------------------------------------------------------------------

   Both take n rows; one particle is n = 1. Begin records with all fields 0, as `= {0}` does: NULL and 0
   mean "none", and later versions may have further fields. Arrays have n numbers, or 3 n where they
   are vectors, row by row. Any number of threads may share out the rows of an array.

   Grains: a particle keeps its grain, the one of (seed, index), at every wall. With `fresh` 1 it has
   another one at each hit, of (seed, index, hit). `grain` gives it: code of the shape (0 ellipsoid,
   1 prism, 2 truncated prism, 3 tetrahedron, 4 sphere, from 6 on meshes), b/a and c/b.

   Rotation: a grain in free flight tumbles; its angular momentum L and its energy of rotation T stay. A
   particle carries the mean angular velocity, Omega = (2 T / |L|^2) L, and the inertia about it,
   k = |L|^2 / (2 T m a^2), between the smallest and the largest moment of inertia of its grain over
   m a^2; so T = k m a^2 |Omega|^2 / 2. Both stay until the next wall, but for torques of the gas. A k of
   0, or NULL, is not known: it is drawn by the keys from those that rebounds leave. Beyond the grain's
   moments the nearest k is taken, with RBT_SPIN. Without a spin k does not matter. */

/* Conditions of draws, in the frame of the impact. */
typedef struct rbt_conditions {
    const double *alpha1;  /* impact angles from the wall, in (0, pi/2]; required */
    const double *speed;   /* impact speeds V > 0; required */
    const double *spin;    /* 3 n: angular velocities before the impact times a/V; NULL: the law of first
                              impacts, of particles of any grain that do not spin */
    const double *inertia; /* inertias k about the spin; NULL or 0: not known */
    const double *grain;   /* 3 n; NULL: the grains of the keys. Without spin they do not spin */
    const uint64_t *index; /* identities of the particles; required */
    const uint32_t *hit;   /* how many walls they have met before, below 2^32; required */
    double *inertia_after; /* written: n inertias k about the spin after the rebound, 0 by the law of first
                              impacts; NULL: not wanted */
    int fresh;             /* 1: another grain at each hit */
} rbt_conditions;

/* Draw n states: rows of the table's variables (rbt_variables), at most RBT_VALUES n numbers. Without
   `states` only the codes are written. codes: n codes, or NULL. Returns the first error, else the sum of
   the flags of all rows. Errors:
   RBT_ERR_MISSING, RBT_ERR_NOT_FINITE, RBT_ERR_NOT_APPROACHING, RBT_ERR_SPEED_NOT_POSITIVE,
   RBT_ERR_NO_SPIN_LAW, RBT_ERR_GRAIN_NOT_KNOWN. */
RBT_API RBT_MUST_USE RBT_DEVICE int rbt_sample(const rbt_table *table, size_t n,
                                               const rbt_conditions *conditions, uint64_t seed,
                                               double *states, int *codes);

/* Impacts on walls, in the lab frame. */
typedef struct rbt_impacts {
    const double *velocity;      /* 3 n: of the particles at the contact, m/s; required */
    const double *normal;        /* 3 n: from the wall into the gas, any length but zero; required */
    const double *half_size;     /* largest half-sizes a, 1e-9 to 100 m; required */
    const double *wall_velocity; /* 3 n: of the wall at the contact, m/s; NULL: walls at rest */
    const double *omega;         /* 3 n: mean angular velocities before the impact, rad/s; NULL: zeros */
    const double *inertia;       /* inertias k about omega; NULL or 0: not known */
    const double *roughness;     /* standard deviations of the tilt of facets, rad, 0 to 0.5; NULL:
                                    smooth walls */
    const double *grain;         /* 3 n; NULL: the grains of the keys */
    const uint64_t *index;       /* identities of the particles; required */
    const uint32_t *hit;         /* how many walls they have met before; required */
    int fresh;     /* 1: another grain at each hit; from smooth walls, without omega and grain, the
                      law of first impacts, the only one of a table without a spin law */
    int isotropic; /* 1: facets are tilted across the plane of incidence as well; 0: in it only */
} rbt_impacts;

/* Rebounds: arrays for results, NULL where they are not wanted, and counts of rows. Results may be the
   arrays of the impacts. */
typedef struct rbt_rebounds {
    double *velocity;  /* 3 n: after the rebound, m/s */
    double *omega;     /* 3 n: mean angular velocity after it, rad/s */
    double *inertia;   /* n: inertia k about it; 0 by the law of first impacts */
    double *works;     /* 2 n: energies that impulses along the normal and along the wall take, J for each
                          kg of the particle; an error if the table has no works */
    int *codes;        /* n */
    size_t bad;        /* written: number of rows with an error */
    size_t first_bad;  /* written: first of them; n if none */
    size_t flagged[4]; /* written: numbers of rows with RBT_ANGLE, RBT_SPEED, RBT_SPIN, RBT_EXTRAPOLATED */
} rbt_rebounds;

/* Rebound n particles. At exactly normal impact the direction along the wall is uniform.

   A rough wall has facets whose normals are tilted at random in the plane of incidence; `normal` is
   that of the mean wall. The particle meets facets by their projected area, none in the shadow of
   others. One that a facet sends back into the wall meets further ones within the same hit, with the
   spin and inertia that the one before has left: its works are their sums, its flags those of all. One
   hit has one grain, a fresh one too.

   Returns the first error, else the sum of the flags of all rows. Errors: those of rbt_sample, and
   RBT_ERR_NORMAL_NOT_USABLE, RBT_ERR_HALF_SIZE, RBT_ERR_ROUGHNESS_NOT_USABLE, RBT_ERR_NO_WORKS;
   RBT_ERR_CASCADE_NOT_ENDED with a probability below 1e-30 a hit. */
RBT_API RBT_MUST_USE RBT_DEVICE int rbt_rebound(const rbt_table *table, size_t n,
                                                const rbt_impacts *impacts, uint64_t seed,
                                                rbt_rebounds *rebounds);

/* Grains of n particles, 3 n numbers: those that they keep, or, with `hit`, those that fresh ones have.
   RBT_OK, RBT_ERR_MISSING or RBT_ERR_NO_SPIN_LAW. */
RBT_API RBT_MUST_USE RBT_DEVICE int rbt_grains(const rbt_table *table, size_t n, uint64_t seed,
                                               const uint64_t *index, const uint32_t *hit,
                                               double *grains);

/* -- around the wall ------------------------------------------------------------------------------ */

/* Standard deviation of the tilt of facets, rad, of a rough wall with a measured profile: for rbt_impacts.

   ra, rq: mean and root mean square of the height, rsm: mean width of the profile's elements (ISO
   21920-2, ISO 4287); diameter: of the particle; all four in the same unit. *tilt becomes atan(2 ra /
   rsm) if diameter < rsm / sin(atan(2 ra / rsm)), else atan(2 rq / rsm): a particle that is small
   beside the elements meets their flanks. Source: Sommerfeld & Huber, Int. J. Multiphase Flow 25
   (1999) 1457-1489, as codes take it.

   RBT_OK, RBT_ERR_NOT_FINITE, or RBT_ERR_ROUGHNESS_NOT_USABLE: ra negative, rq below ra (which no
   profile has; by 1 % for the rounding of published digits), rsm or diameter not positive, or a tilt
   beyond 0.5 rad. */
RBT_API RBT_MUST_USE RBT_DEVICE int rbt_wall_tilt(double ra, double rq, double rsm, double diameter,
                                                  double *tilt);

/* Torque of the gas on a spinning particle, N m, and the angular velocity, rad/s, that it leaves after
   a time, s; omega: as a rebound gives it, the mean over the particle's tumbling.

   diameter: of the sphere of equal volume, m; density, kg/m3, and viscosity, Pa s: of the gas; all
   above 0, or a viscosity of 0: no torque. gas_rotation: half the curl of the gas velocity, rad/s;
   NULL: 0. inertia: kg m2, the particle's own, k m a^2 with the k of the rebound, or rbt_inertia m a^2
   where k is not known. For grains that feel another multiple of the torque, divide the inertia by that
   multiple. Where the gas turns evenly, one call for a whole flight is exact. With slip = gas_rotation -
   omega the torque on a sphere is

       (density / 2) (diameter / 2)^5 C |slip| slip,
       C = 64 pi / Re below Re = density diameter^2 |slip| / viscosity = 32,
       C = 12.9 / sqrt(Re) + 128.4 / Re from there on

   (Dennis, Singh & Ingham, J. Fluid Mech. 101 (1980) 257-279), up to Re = 1000; beyond, the formula
   extrapolates. omega decays along the law exactly: time steps of any size give the same. A negative
   time goes back, to Re = 1e6 at most. Results may be the same arrays as omega. */
RBT_API RBT_DEVICE void rbt_gas_torque(const double omega[3], double diameter, double density,
                                       double viscosity, const double gas_rotation[3],
                                       double torque[3]);
RBT_API RBT_DEVICE void rbt_spin_after(const double omega[3], double time, double inertia,
                                       double diameter, double density, double viscosity,
                                       const double gas_rotation[3], double new_omega[3]);

/* -- sizes, and particles that stay on the wall --

   Largest half-size, m, of a grain (rbt_grains) with the volume of a sphere of a diameter, m; 0: a mesh,
   of unknown volume. */
RBT_API RBT_DEVICE double rbt_half_size(double diameter, const double grain[3]);

/* Mean moment of inertia of a grain over m a^2, for rbt_spin_after where the inertia about the spin is
   not known. Sphericity of a grain: the surface of the sphere of equal volume over that of the grain,
   for laws of drag. Both are 0 for a mesh. */
RBT_API RBT_DEVICE double rbt_inertia(const double grain[3]);
RBT_API RBT_DEVICE double rbt_sphericity(const double grain[3]);

/* Mean of rbt_half_size over the particles of a table; 0: one without a spin law, or with meshes. */
RBT_API RBT_DEVICE double rbt_mean_half_size(const rbt_table *table, double diameter);

/* Normal speed, m/s, below which a smooth dry elastic sphere stays on a wall. In SI units it is

       (2 E / diameter)^(10/7),  E = 0.51 (5 pi^2 (k + k') / (4 density^(3/2)))^(2/5),

   with k = (1 - poisson^2) / (pi young), and k' of the wall. diameter, m, and density, kg/m3, are those
   of the particle; young is Young's modulus, Pa; poisson is Poisson's ratio, 0 to 0.5. NaN if an argument
   cannot be used. Source: Brach & Dunn, Aerosol Sci. Technol. 16 (1992) 51-64, as El-Batsh takes it
   (dissertation, TU Wien, 2001). */
RBT_API RBT_DEVICE double rbt_critical_speed(double diameter, double density, double young,
                                             double poisson, double wall_young,
                                             double wall_poisson);

/* Whether a particle that meets a wall stays there: 1, if it approaches at less than a critical normal
   speed, m/s; else 0. Ask before the draw. Arguments as of rbt_rebound; with NaN it is 0. */
RBT_API RBT_DEVICE int rbt_deposits(const double velocity[3], const double normal[3],
                                    double critical_speed, const double wall_velocity[3]);

/* An axis of the node grid, rad or m/s. Values from low to high are inside; so are values beyond
   these ends by no more than rounding to single precision. coordinate[grid] is the fractional number
   of the node at equal steps from origin on, scale of them per rad or m/s; offset is the number of the
   first of the nodes. */
typedef struct rbt_axis {
    double first, last, low, high, origin, scale;
    int32_t offset, nodes, grid;
    const double *coordinate;
} rbt_axis;

/* The spin law. The arrays and their units are those of tables/FORMAT.md. */
typedef struct rbt_spin_law {
    int32_t n_shapes, n_nodes, n_leaves, n_knots, n_outcomes; /* 0 shapes: no law */
    double least_spin, most_spin; /* squares of the sizes of the spin that it covers */
    double alpha_first, alpha_last, speed_first, speed_last; /* nearest conditions that it draws at */
    double speed_high; /* largest V_e without a flag */
    double speed_scale, speed_exponent; /* of the coordinate of the speed, in units of speed_last */
    double aspect[8];
    const int32_t *shape_codes;
    const double *shape_shares, *shape_ratios, *shape_inertia, *kappa_quantiles;
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
    int32_t n_laws;  /* numbers of the laws of contact; 0: none */
    const double *laws;
    int8_t channels[RBTI_NAMES], marginals[RBTI_NAMES], columns[RBTI_NAMES];
    uint32_t variable_bits; /* bit k: variable k is among the columns */
    int32_t plain; /* whether the columns are the first six variables */
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
