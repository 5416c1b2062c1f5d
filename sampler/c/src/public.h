/* rebound_sampler.h - rebounds of non-spherical particles from walls, drawn from a table, in C.

   Your program finds which particles hit a wall, where and how fast. This header gives their velocity and
   spin after the rebound. In one file of your program or library say

       #define REBOUND_SAMPLER_IMPLEMENTATION
       #include "rebound_sampler.h"

   and in any other file include the header alone. It needs C99 or C++11, libc and libm; it compiles for
   CUDA and HIP as well, where device code needs no library (rebound_device.h has kernels for arrays).

       rbt_table *table;
       int code = rbt_open("corundum-steel.rbt", &table);   (written by `sampler export`)
       if (code < 0) {
           fprintf(stderr, "%s\n", rbt_strerror(code));
           exit(1);
       }
       rbt_impacts impact = {0};
       impact.velocity = velocity;      (3 numbers, m/s)
       impact.normal = normal;          (3 numbers, from the wall into the gas)
       impact.half_size = &half_size;   (m)
       impact.omega = omega;            (3 numbers, rad/s)
       impact.inertia = &inertia;
       impact.index = &particle;
       impact.hit = &hit;
       rbt_rebounds after = {0};
       after.velocity = velocity;       (results may replace the arguments)
       after.omega = omega;
       after.inertia = &inertia;
       code = rbt_rebound(table, 1, &impact, seed, &after);
       hit++;
       rbt_close(table);

   Units: SI, and radians. A state is u, v, w over V and omega_x, omega_y, omega_z times a/V, where V is
   the impact speed and a the largest half-size of the particle. Its frame is that of the impact: x lies
   along the tangential velocity before the impact, y along the wall normal into the gas, and z = x cross
   y.

   Random numbers: equal arguments give the states that the Python package gives. States have the same
   bits whatever the processor and the compiler flags; rebounds in the lab frame and states of spheres
   agree to the last digits of the C library's functions. With -ffast-math, with clang's
   -ffp-contract=fast, and on CUDA devices without -fmad=false, results agree to rounding in single
   precision.

   Threads: an open table is never written, and a draw is a pure function of its arguments that allocates
   nothing. Any number of threads may use one table at once. rbt_open and rbt_close of a table must not
   run beside other calls with it.

   Codes: 0 is fine, a positive code is a sum of flags, a negative code is an error; rbt_strerror says
   what each means. A row with a flag was drawn; if the condition lies outside the table, the nearest
   condition was drawn. Test `code & RBT_OUTSIDE` for that, not `code > 0`: RBT_EXTRAPOLATED is set in
   most rows where particles are slow. A row with an error gets NaN in all of its results; only a row
   whose particle does not approach its wall (RBT_ERR_NOT_APPROACHING) keeps what it arrived with. If a
   required array is NULL, the call returns RBT_ERR_MISSING and writes nothing. Nothing is ever printed:
   count errors and flags, and tell your user.

   Where to find what: declarations first, in the order of use; then the implementation, whose opening has
   a map of its sections.

   Part of rebound-tables; MIT licence. */

#ifndef REBOUND_SAMPLER_H
#define REBOUND_SAMPLER_H

#if defined(__CUDACC__) || defined(__HIPCC__) || defined(__HIP__)
#define RBTI_GPU 1 /* a compiler of programs for host and device */
#endif

/* Compilers that know no host (NVRTC, HIPRTC) must not see the functions that only a host can have. */
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

/* Marks functions that a device may call too; empty outside of CUDA and HIP. */
#ifndef RBT_DEVICE
#if defined(RBTI_GPU)
#define RBT_DEVICE __host__ __device__
#else
#define RBT_DEVICE
#endif
#endif

/* Where tables get their memory. Define both before you include the header to use another allocator. */
#ifndef RBT_MALLOC
#define RBT_MALLOC(size) malloc(size)
#define RBT_FREE(memory) free(memory)
#endif

/* How functions are declared. Define it as `static` to keep them within one file, or as
   `extern __attribute__((visibility("hidden")))` to keep them within one shared library. Do so in a plugin:
   on Linux a library calls the first function of a name in the process, which may be of another plugin. */
#ifndef RBT_API
#define RBT_API extern
#endif

/* Version of this library; codes, which rbt_strerror explains; variables that a state can have. The parts
   between such marks are written by `python tools/generated_code.py`. */
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
#define RBT_ERR_CASCADE_NOT_ENDED (-8)
#define RBT_ERR_REBOUND_NOT_ENDED (-9)
#define RBT_ERR_NO_SPIN_LAW (-10)
#define RBT_ERR_GRAIN_NOT_KNOWN (-11)
#define RBT_ERR_NO_WORKS (-12)
#define RBT_ERR_DIRECT_VERSION (-13)
#define RBT_ERR_DIRECT_PAIR (-14)
#define RBT_ERR_NOT_OPENED (-15)
#define RBT_ERR_NOT_READ (-16)
#define RBT_ERR_NO_MEMORY (-17)
#define RBT_ERR_BIG_ENDIAN (-18)
#define RBT_ERR_FORMAT (-19)
#define RBT_ERR_VERSION (-20)
#define RBT_ERR_SIZE (-21)
#define RBT_ERR_CHECKSUM (-22)
#define RBT_ERR_DIMENSIONS (-23)
#define RBT_ERR_NAMES (-24)
#define RBT_ERR_OFFSETS (-25)
#define RBT_ERR_INDICES (-26)
#define RBT_OUTSIDE 7 /* RBT_ANGLE, RBT_SPEED or RBT_SPIN: outside the table */
/* codes of shapes */
enum { RBT_ELLIPSOID, RBT_PRISM, RBT_TRUNCATED_PRISM, RBT_TETRAHEDRON, RBT_SPHERE,
       RBT_FIRST_MESH = 64 };
/* variables of a state, in this order */
enum { RBT_U, RBT_V, RBT_W, RBT_OMEGA_X, RBT_OMEGA_Y, RBT_OMEGA_Z, RBT_ROTATIONAL_ENERGY,
       RBT_COLLISIONS, RBT_WORK_NORMAL, RBT_WORK_SHEAR, RBT_VALUES };
/* channels, in which these are stored */
enum { RBTI_OF_V, RBTI_OF_U_HAT, RBTI_OF_OMEGA_Z, RBTI_OF_W_HAT, RBTI_OF_OMEGA_X, RBTI_OF_OMEGA_Y,
       RBTI_OF_ENERGY_HAT, RBTI_OF_COLLISIONS, RBTI_OF_NORMAL_HAT, RBTI_CHANNELS };
#define RBTI_NAMES 8 /* most of either that a table has */
/* end constants */

/* Largest roughness of a wall, rad. Beyond it a normal law of tilts describes no surface. */
#define RBT_MOST_ROUGHNESS 0.5

/* Smallest and largest half-size of a particle, m. Other values are mistaken units. */
#define RBT_LEAST_HALF_SIZE 1e-9
#define RBT_MOST_HALF_SIZE 100.0

/* Compilers warn if a program ignores such a result. */
#if defined(__GNUC__)
#define RBT_MUST_USE __attribute__((warn_unused_result))
#else
#define RBT_MUST_USE
#endif

/* -- tables --------------------------------------------------------------------------------------- */

/* A table in memory. Its fields belong to the functions below. */
typedef struct rbt_table rbt_table;

#ifndef RBT_DEVICE_ONLY

/* Open a binary table (.rbt). Checks that the file is whole, by its checksum, and everything that a draw
   uses as an index; the numbers themselves were checked when the file was made. A folder, a pipe or a
   device is refused at once.

   On success *table belongs to the caller, who ends it with rbt_close. On an error *table is NULL.

   The file is mapped into memory where the system can do that, so that all programs of a machine share
   one copy; with RBT_NO_MMAP it is read instead. Do not overwrite a mapped file in place, as cp and rsync
   --inplace do: draws would be wrong, or the program would end with SIGBUS. `sampler export` and mv put a
   new file in its place, which is safe. */
RBT_API RBT_MUST_USE int rbt_open(const char *path, rbt_table **table);

/* Open the bytes of a binary table that are in memory already. Their address must be a multiple of 64.
   They stay the caller's, and must neither change nor go away before rbt_close. */
RBT_API RBT_MUST_USE int rbt_open_memory(const void *image, size_t size, rbt_table **table);

/* Close a table and free its memory. NULL is allowed. */
RBT_API void rbt_close(rbt_table *table);

/* One line on a code; of a sum it names every flag. A constant string, never NULL. */
RBT_API const char *rbt_strerror(int code);

#endif

/* What a table covers, {smallest, largest}. */
typedef struct rbt_range {
    double alpha1[2];   /* Impact angles, rad, counted from the wall. */
    double speed[2];    /* Impact speeds V, m/s. {1e-300, 1e300} if the law does not depend on the speed. */
    double spin[2];     /* Spins before the impact, a |Omega| / V. {0, 0} without a spin law. */
    double measured[2]; /* Speeds at which the material pair was measured, m/s. Other speeds extrapolate. */
} rbt_range;

/* Tell what a table covers. RBT_OK or RBT_ERR_MISSING. */
RBT_API RBT_DEVICE int rbt_covered(const rbt_table *table, rbt_range *range);

/* The highest impact speed that a table covers, m/s; 0 if it covers any speed. */
RBT_API RBT_DEVICE double rbt_highest_speed(const rbt_table *table);

/* Whether a table has a spin law, 1 or 0. The spin law is that of particles that arrive spinning; it
   depends on the spin and on the grain. A table without it knows first impacts only. */
RBT_API RBT_DEVICE int rbt_has_spin_law(const rbt_table *table);

/* The variables in the columns of a state: returns how many there are, and writes which they are (RBT_U
   to RBT_WORK_SHEAR; -1 behind the last). `columns` may be NULL. */
RBT_API RBT_DEVICE int rbt_variables(const rbt_table *table, int columns[RBT_VALUES]);

/* Whether a table has a variable, RBT_U to RBT_WORK_SHEAR: 1 or 0. A rebound has 0 for variables that the
   table lacks. */
RBT_API RBT_DEVICE int rbt_has_variable(const rbt_table *table, int variable);

/* The name of the material pair, in UTF-8. It lives as long as the table. */
RBT_API RBT_DEVICE const char *rbt_pair(const rbt_table *table);

/* -- draws and rebounds ---------------------------------------------------------------------------

   Both functions take n rows; one particle is n = 1. Begin records with all fields 0, as `= {0}` does: a
   field that is NULL or 0 is "none", and later versions may have further fields. Arrays have n numbers,
   or 3 n numbers if they are vectors, row by row. Several threads may share out the rows of an array.

   Grain: a particle keeps its grain, which is a function of (seed, index), at every wall. With `fresh` it
   is another grain at each hit, a function of (seed, index, hit). To prescribe grains, pass `grain`: for
   each particle the code of a shape (RBT_ELLIPSOID ... RBT_SPHERE; mesh k of the population is
   RBT_FIRST_MESH + k), b/a, and c/b.

   Rotation: a grain in free flight tumbles, while its angular momentum L and its rotational energy T
   stay. A particle carries two quantities. One is the mean angular velocity Omega = (2 T / |L|^2) L,
   rad/s. The other is the inertia about it, k = |L|^2 / (2 T m a^2), which lies between the smallest and
   the largest moment of inertia of the grain over m a^2; so T = k m a^2 |Omega|^2 / 2. Both stay constant
   until the next wall, but for the torque of the gas. If k is 0 or NULL it is not known, and is drawn by
   the keys from the inertias that rebounds leave. If k lies beyond the moments of the grain, the nearest
   k is taken, and the row gets RBT_SPIN. Without a spin, k does not matter. */

/* Conditions of draws, in the frame of the impact. */
/* begin conditions */
typedef struct rbt_conditions {
    const double *alpha1;  /* Impact angles from the wall, rad, above 0, at most pi/2. Required. */
    const double *speed;   /* Impact speeds V, m/s, above 0. Required. */
    const double *spin;    /* Angular velocities before the impact, times a/V, 3 n. NULL: the law of first
                              impacts, of particles of any grain that do not spin. */
    const double *inertia; /* Inertias k about the spin, over m a^2. NULL or 0: not known. */
    const double *grain;   /* Prescribed grains, 3 n. NULL: the grains of the keys. Grains without `spin` do
                              not spin, and are drawn from the spin law. */
    const uint64_t *index; /* Identities of the particles. Required. */
    const uint32_t *hit;   /* Number of walls that each particle has met before. Required. */
    double *inertia_after; /* Written: inertias k after the rebound; 0 by the law of first impacts. NULL: not
                              wanted. */
    int fresh;             /* 1: another grain at each hit. 0: particles keep their grains. */
} rbt_conditions;
/* end conditions */

/* Draw n states. `states` gets n rows of the table's variables (rbt_variables), at most RBT_VALUES n
   numbers; if it is NULL only the codes are written. `codes` gets n codes, or is NULL.

   Returns the first error, else the sum of the flags of all rows. Errors: RBT_ERR_MISSING,
   RBT_ERR_NOT_FINITE, RBT_ERR_NOT_APPROACHING, RBT_ERR_SPEED_NOT_POSITIVE, RBT_ERR_NO_SPIN_LAW,
   RBT_ERR_GRAIN_NOT_KNOWN. */
RBT_API RBT_MUST_USE RBT_DEVICE int rbt_sample(const rbt_table *table, size_t n,
                                               const rbt_conditions *conditions, uint64_t seed,
                                               double *states, int *codes);

/* Impacts on walls, in the lab frame. */
/* begin impacts */
typedef struct rbt_impacts {
    const double *velocity;      /* Velocities of the particles at the contact, m/s, 3 n. Required. */
    const double *normal;        /* Normals from the wall into the gas, 3 n, of any length but 0. Required. */
    const double *half_size;     /* Largest half-sizes a, 1e-9 to 100 m. Required. */
    const double *wall_velocity; /* Velocities of the walls at the contact, m/s, 3 n. NULL: walls at rest. */
    const double *omega;         /* Mean angular velocities before the impact, rad/s, 3 n. NULL: zeros. */
    const double *inertia;       /* Inertias k about omega, over m a^2. NULL or 0: not known. */
    const double *roughness;     /* Standard deviations of the tilt of facets, 0 to 0.5 rad. NULL: smooth
                                    walls. */
    const double *grain;         /* Prescribed grains, 3 n. NULL: the grains of the keys. */
    const uint64_t *index;       /* Identities of the particles. Required. */
    const uint32_t *hit;         /* Number of walls that each particle has met before. Required. */
    int fresh;                   /* 1: another grain at each hit. From smooth walls, without omega and grain,
                                    it is drawn from the law of first impacts; a table without a spin law has
                                    no other. 0: particles keep their grains. */
    int isotropic;               /* 1: facets are tilted across the plane of incidence as well. 0: they are
                                    tilted in that plane only. */
} rbt_impacts;
/* end impacts */

/* Rebounds: arrays of results, each NULL if it is not wanted, and counts of rows. The arrays may be those
   of the impacts. */
/* begin rebounds */
typedef struct rbt_rebounds {
    double *velocity;  /* Velocities after the rebound, m/s, 3 n. */
    double *omega;     /* Mean angular velocities after the rebound, rad/s, 3 n. */
    double *inertia;   /* Inertias k about omega, over m a^2; 0 by the law of first impacts. */
    double *works;     /* Energies that the impulses along the normal and along the wall take, J for each kg
                          of the particle, 2 n. If the table has no works, RBT_ERR_NO_WORKS. */
    int *codes;        /* Codes of the rows, n. */
    size_t bad;        /* Written: number of rows with an error. */
    size_t first_bad;  /* Written: the first row with an error; n if there is none. */
    size_t flagged[8]; /* Written: in place k the number of rows with the flag 1 << k. */
} rbt_rebounds;
/* end rebounds */

/* Rebound n particles. At exactly normal impact the direction along the wall is uniform.

   A rough wall has facets whose normals are tilted at random; `normal` is the normal of the mean wall.
   The particle meets facets in proportion to the area that it sees, and none in the shadow of others. If
   a facet sends it back into the wall, it meets further facets within the same hit, with the spin and the
   inertia that the facet before has given it. Its works are then the sums over all facets, and its flags
   those of all. It stays the same grain within a hit, a fresh grain too.

   Returns the first error, else the sum of the flags of all rows. Errors: those of rbt_sample, and
   RBT_ERR_NORMAL_NOT_USABLE, RBT_ERR_HALF_SIZE, RBT_ERR_ROUGHNESS_NOT_USABLE, RBT_ERR_NO_WORKS;
   RBT_ERR_CASCADE_NOT_ENDED with a probability below 1e-30 a hit. */
RBT_API RBT_MUST_USE RBT_DEVICE int rbt_rebound(const rbt_table *table, size_t n,
                                                const rbt_impacts *impacts, uint64_t seed,
                                                rbt_rebounds *rebounds);

/* Write the grains of n particles, 3 n numbers: the grains that they keep, or, if `hit` is not NULL, the
   grains that `fresh` gives them at these hits. RBT_OK, RBT_ERR_MISSING or RBT_ERR_NO_SPIN_LAW. */
RBT_API RBT_MUST_USE RBT_DEVICE int rbt_grains(const rbt_table *table, size_t n, uint64_t seed,
                                               const uint64_t *index, const uint32_t *hit,
                                               double *grains);

#if !defined(RBT_DEVICE_ONLY) && !defined(RBTI_GPU)
#define RBTI_DIRECT 1

/* -- direct simulation ----------------------------------------------------------------------------

   `tablegen export-direct PAIR` writes an object file, rebound_direct.o, which simulates rebounds, and a
   header, rebound_direct.h, which declares it as `rebound_direct`. Link the object, and say

       code = rbt_use_direct(table, &rebound_direct);

   From then on rbt_sample and rbt_rebound of this table simulate each rebound in place of a draw. The
   object needs libc and libm. It allocates nothing, has no global state, and may be used by any number of
   threads. A call with many rows keeps some 400 kB on the stack; define RBT_DIRECT_ROWS to keep less, and
   simulate a little slower. Not for GPUs. */

/* The law of direct simulation of a material pair, in an object file. */
typedef struct rbt_direct_law rbt_direct_law;

/* Let a table simulate, in place of its law. Grains, the range of the table and its extrapolation become
   those of direct simulation; the law must outlive the table. RBT_OK, RBT_ERR_MISSING,
   RBT_ERR_DIRECT_VERSION or RBT_ERR_DIRECT_PAIR, after which the table draws as before. Draws of a table
   that simulates also give RBT_ERR_REBOUND_NOT_ENDED. */
RBT_API RBT_MUST_USE int rbt_use_direct(rbt_table *table, const rbt_direct_law *law);

#endif

/* -- sizes and shapes of grains ------------------------------------------------------------------- */

/* Sizes of grains, of shapes of the table; 0 for any other shape. */

/* Largest half-size a of a grain whose volume is that of a sphere of this diameter, m. */
RBT_API RBT_DEVICE double rbt_half_size(const rbt_table *table, double diameter,
                                        const double grain[3]);

/* Mean of rbt_half_size over the particles of a table, m. 0 for a table without a spin law. */
RBT_API RBT_DEVICE double rbt_mean_half_size(const rbt_table *table, double diameter);

/* Mean moment of inertia of a grain over m a^2. */
RBT_API RBT_DEVICE double rbt_mean_inertia(const rbt_table *table, const double grain[3]);

/* Sphericity of a grain, for laws of drag: the surface of the sphere of equal volume over the surface of
   the grain. */
RBT_API RBT_DEVICE double rbt_sphericity(const rbt_table *table, const double grain[3]);

/* -- flights: the torque of the gas ---------------------------------------------------------------

   Arguments: omega is the mean angular velocity, rad/s, as a rebound gives it. diameter is that of the
   sphere of equal volume, m. density, kg/m3, and viscosity, Pa s, are of the gas. All three are above 0;
   a viscosity of 0 means no torque. gas_rotation is half the curl of the gas velocity, rad/s; NULL means
   0.

   With slip = gas_rotation - omega and Re = density diameter^2 |slip| / viscosity the torque is

       (density / 2) (diameter / 2)^5 C |slip| slip,
       C = 64 pi / Re                        below Re = 32,
       C = 12.9 / sqrt(Re) + 128.4 / Re      from there on.

   Source: Dennis, Singh & Ingham, J. Fluid Mech. 101 (1980) 257-279, for spheres up to Re = 1000; beyond,
   the formula extrapolates. If an argument is so large that a product overflows, results are not finite. */

/* Torque of the gas on a spinning particle, N m. */
RBT_API RBT_DEVICE void rbt_gas_torque(const double omega[3], double diameter, double density,
                                       double viscosity, const double gas_rotation[3],
                                       double torque[3]);

/* Angular velocity that the torque of the gas leaves after a time, rad/s. `time` is in s; a negative time
   goes back, to Re = 1e6 at most. `moment` is the moment of inertia of the particle, kg m2
   (rbt_moment_of_inertia). If the gas exerts another multiple of the torque on your grains, divide
   `moment` by that multiple. The decay is exact, so time steps of any size give the same; if the gas
   turns evenly, call this once for a whole flight. new_omega may be omega. */
RBT_API RBT_DEVICE void rbt_spin_after(const double omega[3], double time, double moment,
                                       double diameter, double density, double viscosity,
                                       const double gas_rotation[3], double new_omega[3]);

/* Moment of inertia of a particle about its spin, kg m2: k m a^2. If the inertia k is 0, not known, it is
   the mean moment of the particle's grain, or, where the table does not have that, the moment of the
   sphere of equal volume. `mass` is in kg, `half_size` and `diameter` in m. */
RBT_API RBT_DEVICE double rbt_moment_of_inertia(const rbt_table *table, uint64_t seed, uint64_t index,
                                                double inertia, double mass, double half_size,
                                                double diameter);

/* -- walls: roughness, and particles that stay on them -------------------------------------------- */

/* Standard deviation of the tilt of facets, rad, of a rough wall with a measured profile, for
   rbt_impacts.

   ra and rq are the mean and the root mean square of the height, rsm is the mean width of the profile's
   elements (ISO 21920-2, ISO 4287), diameter is that of the particle; all four in the same unit. *tilt
   becomes atan(2 ra / rsm) if the particle is so small beside the elements that it meets their flanks,
   which is diameter < rsm / sin(atan(2 ra / rsm)), and else atan(2 rq / rsm). Source: Sommerfeld & Huber,
   Int. J. Multiphase Flow 25 (1999) 1457-1489, as codes take it.

   RBT_OK, RBT_ERR_NOT_FINITE, or RBT_ERR_ROUGHNESS_NOT_USABLE, after which *tilt is as it was. Not usable
   are: ra below 0; rq below ra, which no profile has (by 1 % for the rounding of published digits); rsm
   or diameter not above 0; a tilt above 0.5 rad. */
RBT_API RBT_MUST_USE RBT_DEVICE int rbt_wall_tilt(double ra, double rq, double rsm, double diameter,
                                                  double *tilt);

/* Critical normal speed, m/s, below which a smooth dry elastic sphere stays on a wall, in SI units

       (2 E / diameter)^(10/7),  E = 0.51 (5 pi^2 (k + k') / (4 density^(3/2)))^(2/5),

   with k = (1 - poisson^2) / (pi young), and k' the same of the wall. diameter, m, and density, kg/m3,
   are those of the particle; young is Young's modulus, Pa; poisson is Poisson's ratio, 0 to 0.5. NaN if
   an argument cannot be used. Source: Brach & Dunn, Aerosol Sci. Technol. 16 (1992) 51-64, as El-Batsh
   takes it (dissertation, TU Wien, 2001). */
RBT_API RBT_DEVICE double rbt_critical_speed(double diameter, double density, double young,
                                             double poisson, double wall_young,
                                             double wall_poisson);

/* The critical speed at another diameter: speed (reference_diameter / diameter)^(10/7), if it is `speed`
   at the reference diameter. A reference diameter of 0 means that `speed` holds at every diameter. */
RBT_API RBT_DEVICE double rbt_critical_speed_at(double diameter, double speed,
                                                double reference_diameter);

/* Whether a particle stays on the wall that it meets, 1 or 0: it does if it approaches at less than a
   critical normal speed, m/s. Ask before the rebound. The other arguments are those of rbt_rebound. With
   NaN, and with a normal of length zero, the answer is 0. */
RBT_API RBT_DEVICE int rbt_deposits(const double velocity[3], const double normal[3],
                                    double critical_speed, const double wall_velocity[3]);

/* -- statistics by face of a wall ----------------------------------------------------------------- */

/* A hit of a face by particles of one kind, after its rebound or deposit. */
typedef struct rbt_face_hit {
    double number;    /* How many particles it stands for. */
    double mass;      /* Mass of one particle, kg. */
    double before[3]; /* Velocity relative to the wall before the hit, m/s. */
    double after[3];  /* Velocity relative to the wall after the hit, m/s; 0 if the particle stays. */
    double normal[3]; /* Unit normal from the wall into the gas. */
    double works[2];  /* Works of the impulses (rbt_rebounds), J for each kg. */
    int stays;        /* 1: the particle stays on the wall. */
} rbt_face_hit;

/* Sums over the hits of a face: particles, particles that stayed, kg, J of translation before, J of
   translation lost, the mean impact angle in degrees, and J of the works along the normal and the
   wall. */
enum {
    RBT_FACE_HITS,
    RBT_FACE_DEPOSITS,
    RBT_FACE_MASS,
    RBT_FACE_ENERGY_BEFORE,
    RBT_FACE_ENERGY_LOST,
    RBT_FACE_ANGLE_DEG,
    RBT_FACE_WORK_NORMAL,
    RBT_FACE_WORK_SHEAR,
    RBT_FACE_SUMS
};

/* Number of bins of histograms by face. */
#define RBT_FACE_BINS 10

/* Add a hit to the sums of a face, which are 0 before its first hit. sums[k] points to sum k
   (RBT_FACE_HITS ...); it is NULL if the sum is not wanted. The mean angle needs the hits. */
RBT_API RBT_DEVICE void rbt_add_face_hit(const rbt_face_hit *hit, double *const sums[RBT_FACE_SUMS]);

/* The bin of a hit in histograms of the impact angle, from 0 to 90 degrees, and of the impact speed, from
   0 to `most_speed`, m/s; faster hits belong to the last bin. */
RBT_API RBT_DEVICE int rbt_angle_bin(const rbt_face_hit *hit);
RBT_API RBT_DEVICE int rbt_speed_bin(const rbt_face_hit *hit, double most_speed);

/* -- tables in the memory of a device, and what a table has ---------------------------------------- */

/* An axis of the grid of nodes, rad or m/s. The number of a node at equal steps is looked up in
   `coordinate`, so that nodes may be spaced unevenly. */
typedef struct rbt_axis {
    double first, last;       /* Ends of the grid of nodes. */
    double low, high;         /* Values without a flag, but for rounding to single precision. */
    double origin, scale;     /* coordinate[0] is at `origin`; `scale` entries for each rad or m/s. */
    int32_t offset;           /* Number of the first node of the table. */
    int32_t nodes;            /* How many nodes there are. */
    int32_t grid;             /* Length of `coordinate`. */
    const double *coordinate; /* Fractional numbers of nodes, [grid]. */
} rbt_axis;

/* The grains of the particles: shapes, and the laws of their ratios b/a and c/b. Units: tables/FORMAT.md. */
typedef struct rbt_population {
    int32_t n_shapes; /* 0: the grains of particles are not known, and there is no spin law. */
    double aspect[8]; /* Laws of b/a and c/b: mean, deviation, lowest and highest probability. */
    const int32_t *shape_codes;
    const double *shape_shares, *shape_ratios, *ratio_range, *shape_geometry, *shape_inertia;
} rbt_population;

/* The spin law. Its arrays and their units are those of tables/FORMAT.md. */
typedef struct rbt_spin_law {
    int32_t n_nodes, n_leaves, n_knots, n_outcomes;
    double least_spin, most_spin; /* Squares of the sizes of the spin that it covers. */
    double alpha_first, alpha_last, speed_first, speed_last; /* Ends of the conditions of draws. */
    double speed_low, speed_high; /* Effective speeds V_e without a flag. */
    double speed_scale, speed_exponent; /* Of the coordinate of the speed, in units of speed_last. */
    const double *kappa_quantiles;
    const int32_t *roots;
    const int8_t *node_axis;
    const double *node_cut;
    const int32_t *node_child;
    const float *inputs;
    const int16_t *group_gates, *gates, *experts;
    const float *spans;
    const uint16_t *quantiles;
} rbt_spin_law;

#ifdef RBTI_DIRECT

/* Numbers that a simulation writes for each row: the variables of a state, the inertia about the spin,
   and the energy before the impact over m V^2 / 2. */
#define RBT_DIRECT_VALUES (RBT_VALUES + 2)

/* Direct simulation, as `tablegen export-direct` writes it. */
struct rbt_direct_law {
    uint64_t version;         /* RBT_DIRECT_VERSION of the header that it is made for. */
    rbt_population population;
    double alpha1[2], speed[2]; /* Angles, rad, and speeds, m/s, that are simulated, {least, most}. */
    double most_spin;         /* Largest size of the spin before the impact, V/a. */
    double most_turned;       /* Largest angle turned before the first contact, 2 spin / sin(alpha1), rad. */
    double valid_speed[2];    /* Speeds at which the pair was measured, m/s. */
    const char *pair;         /* Name of the material pair. */
    const double *reals;      /* Laws of contact, shapes and parameters, for `simulate`. */
    const int64_t *integers;
    void (*simulate)(const double *reals, const int64_t *integers, int64_t n, const double *alpha1,
                     const double *speed, const double *spin, const double *inertia,
                     const double *grain, const uint64_t *index, const uint32_t *hit,
                     uint64_t seed, double *values, int32_t *codes);
};
#define RBT_DIRECT_VERSION 1

#endif

struct rbt_table {
    rbt_axis alpha, speed;
    rbt_population population;
    rbt_spin_law spin;
#ifdef RBTI_DIRECT
    const rbt_direct_law *direct; /* If it is not NULL, rebounds are simulated. */
#endif
    double valid_speed[2]; /* Speeds at which the pair was measured. */
    double least_inertia;  /* Smallest moment of inertia of a grain over m a^2. */
    double variate_max, variate_scale; /* Largest variate; knots for each unit of a variate. */
    int32_t n_knots, n_components, n_classes, n_channels, n_marginals, n_columns, stride;
    int32_t spheres;          /* 1: rebounds follow from laws of contact, and there are no nodes. */
    int32_t n_law_parameters; /* Numbers of the laws of contact; 0: none. */
    const double *laws;
    int8_t channels[RBTI_NAMES], marginals[RBTI_NAMES], columns[RBTI_NAMES];
    uint32_t variable_bits;      /* Bit k: variable k is among the columns. */
    int32_t plain;               /* 1: the columns are the first six variables. */
    int8_t mirrored[RBTI_NAMES]; /* Whether reflection turns the sign of a row of a factor. */
    const float *normals;
    const uint32_t *alias;
    const uint16_t *first_of_class;
    const int16_t *components;
    const double *spans;
    const uint16_t *quantiles;
    const char *image; /* The bytes of the file. */
    size_t image_size;
    void *to_free;  /* Memory that belongs to the table, else NULL. */
    void *to_unmap; /* Mapping that belongs to the table, else NULL. */
    char pair[128];
};

/* The bytes of a table, and how many there are: copy them to memory that the host cannot read, as of a
   GPU. */
RBT_API RBT_DEVICE const void *rbt_image(const rbt_table *table, size_t *size);

/* A table whose draws read such a copy, at an address that is a multiple of 64. Pass it by value. */
RBT_API RBT_DEVICE rbt_table rbt_moved(const rbt_table *table, const void *copy);

/* The table of bytes that rbt_open would accept, at an address that is a multiple of 64. Nothing is
   checked: it is for devices, where there is no rbt_open. */
RBT_API RBT_DEVICE rbt_table rbt_unchecked(const void *image, size_t size);

#ifdef __cplusplus
}
#endif

#endif /* REBOUND_SAMPLER_H */
