/* rebound_bc.c - rebounds drawn from a table, as a wall condition of Fluent's discrete phase.

   A SKETCH: compiled, and exercised with made-up particles, against our own declarations in udf.h
   beside it. NOT RUN IN FLUENT. The names used are those of Fluent's UDF manual.

   To use it, copy this file and rebound_sampler.h, not our udf.h, into the folder of a compiled UDF
   library, and the binary table that `sampler export` wrote into the folder where Fluent runs. Then

   - set six particle scalars (discrete phase model, UDF: number of scalars), and hook
     `rebound_flight` there as scalar update, so that a new particle has hit no wall and does not spin;
   - hook `rebound_wall` at each wall as the boundary condition of the discrete phase.

   Parallel runs: every process maps the table when the library is loaded, before any particle moves.
   Afterwards nothing is written but the particle at hand, so any number of threads may call at once.
   The scalars travel with the particle from process to process. What turns the velocity of a
   particle between walls, a symmetry plane or a periodic zone that rotates, does not turn its spin:
   that would be yours to add. */

#define REBOUND_SAMPLER_IMPLEMENTATION
#include "rebound_sampler.h"

#include "udf.h"

/* What to adapt. */
#ifndef REBOUND_TABLE
#define REBOUND_TABLE "corundum-steel.rbt"
#endif
#ifndef REBOUND_SEED
#define REBOUND_SEED 7
#endif
#ifndef REBOUND_HALF_SIZE
#define REBOUND_HALF_SIZE 0.5 /* largest half-size of a grain over the particle's diameter */
#endif
#ifndef REBOUND_KEEP_SPIN
#define REBOUND_KEEP_SPIN 1 /* 0: every impact is that of a particle that arrives without spin */
#endif
#ifndef REBOUND_GAS_TORQUE
#define REBOUND_GAS_TORQUE 0.0 /* of the gas on a spinning grain, over that on a sphere; 0: none */
#endif
#ifndef REBOUND_ROUGHNESS
#define REBOUND_ROUGHNESS 0.0 /* standard deviation of the tilt of facets, rad; 0: smooth walls */
#endif
#ifndef REBOUND_RSM
#define REBOUND_RSM 0.0 /* m; above 0: the tilt is that of a profile with this width of elements */
#define REBOUND_RA 0.0  /* and these heights, m: mean and root mean square */
#define REBOUND_RQ 0.0
#endif

/* Particle scalars: how many walls the particle has met, at how many of them it was outside the
   table, at how many the law of the material pair was extrapolated; and its angular velocity, three
   numbers in rad/s. A float counts to 16 million. */
#define REBOUND_HITS 0
#define REBOUND_CLAMPED 1
#define REBOUND_EXTRAPOLATED 2
#define REBOUND_OMEGA 3
#define REBOUND_SCALARS 6

/* Where a particle keeps its angular velocity: a macro of your version may take the scalars' place. */
#ifndef REBOUND_SPIN
#define REBOUND_SPIN(tp) (&TP_USER_REAL(tp, REBOUND_OMEGA))
#endif

static rbt_table *rebound_table = NULL;
static int rebound_keeps_spin = 0;
static double rebound_valid[2]; /* speeds at which the law was measured, m/s */
static int rebound_warned = 0;  /* of an impact outside the table, once a process */

/* Roughness of the walls for a particle of some diameter. */
static int rebound_roughness(double diameter, double *roughness)
{
    *roughness = REBOUND_ROUGHNESS;
    if (REBOUND_RSM > 0.0)
        return rbt_wall_tilt(REBOUND_RA, REBOUND_RQ, REBOUND_RSM, diameter, roughness);
    return *roughness >= 0.0 && *roughness <= RBT_MOST_ROUGHNESS ? RBT_OK
                                                                : RBT_ERR_ROUGHNESS_NOT_USABLE;
}

DEFINE_EXECUTE_ON_LOADING(rebound_open, libname)
{
    const int code = rbt_open(REBOUND_TABLE, &rebound_table);
    if (code < RBT_OK) {
        Message("%s: %s: %s\n", libname, REBOUND_TABLE, rbt_strerror(code));
        return;
    }
    rbt_valid_speed(rebound_table, rebound_valid);
    rebound_keeps_spin = REBOUND_KEEP_SPIN && rbt_has_spin_law(rebound_table);
    if (REBOUND_KEEP_SPIN && !rebound_keeps_spin)
        Message("%s: %s: no spin law: particles are taken to arrive without spin\n", libname,
                REBOUND_TABLE);
}

DEFINE_EXECUTE_AT_EXIT(rebound_close)
{
    rbt_close(rebound_table);
    rebound_table = NULL;
}

/* A new particle; and what the gas does to the spin between walls: it decays with the time
   rho_p d^2 / (60 mu REBOUND_GAS_TORQUE). The rotation of the gas is small beside it, and left out. */
DEFINE_DPM_SCALAR_UPDATE(rebound_flight, c, t, initialize, tp)
{
    if (initialize) {
        for (int k = 0; k < REBOUND_SCALARS; k++)
            TP_USER_REAL(tp, k) = 0;
    } else if (REBOUND_GAS_TORQUE > 0.0) {
        const double diameter = TP_DIAM(tp);
        const double rate = REBOUND_GAS_TORQUE * 60.0 * C_MU_L(c, t) /
                            (TP_RHO(tp) * diameter * diameter);
        const double kept = exp(-rate * TP_DT(tp));
        for (int k = 0; k < 3; k++)
            REBOUND_SPIN(tp)[k] = (real)(kept * REBOUND_SPIN(tp)[k]);
    }
}

/* Normal into the gas, and how many components of the velocity count.

   f_normal points out of the gas, so it is reversed. With swirl the case is two-dimensional but
   particles move in space, and the normal turns about the axis with the particle. */
static int rebound_normal(Tracked_Particle *tp, const real f_normal[], int dim, double normal[3])
{
    normal[2] = 0.0;
    for (int k = 0; k < dim; k++)
        normal[k] = -f_normal[k];
#if RP_2D
    if (rp_axi_swirl) {
        const double y = TP_POS(tp)[1], z = TP_POS(tp)[2], radial = normal[1];
        const double radius = sqrt(y * y + z * z);
        if (radius > 1e-20) {
            normal[1] = radial * y / radius;
            normal[2] = radial * z / radius;
        }
        return 3;
    }
#else
    (void)tp;
#endif
    return dim;
}

/* Velocity of the wall at the particle, m/s. Walls at rest; one that moves is yours to fill in, from
   the motion that your case prescribes for this face thread. */
static void rebound_wall_velocity(face_t f, Thread *t, double velocity[3])
{
    (void)f;
    (void)t;
    for (int k = 0; k < 3; k++)
        velocity[k] = 0.0;
}

/* Speed of a particle relative to a wall, m/s. */
static double rebound_speed(const double velocity[3], const double wall[3])
{
    double square = 0.0;
    for (int k = 0; k < 3; k++)
        square += (velocity[k] - wall[k]) * (velocity[k] - wall[k]);
    return sqrt(square);
}

static void rebound_count(Tracked_Particle *tp, int code, double speed)
{
    TP_USER_REAL(tp, REBOUND_HITS) += 1;
    if (speed < rebound_valid[0] || speed > rebound_valid[1])
        TP_USER_REAL(tp, REBOUND_EXTRAPOLATED) += 1;
    if (code == RBT_CLAMPED) {
        TP_USER_REAL(tp, REBOUND_CLAMPED) += 1;
        if (!rebound_warned)
            Message("rebound_wall: an impact lay outside the table and took its nearest condition; "
                    "the second user scalar of the particles counts such\n");
        rebound_warned = 1;
    }
}

DEFINE_DPM_BC(rebound_wall, tp, t, f, f_normal, dim)
{
    double normal[3], wall[3], omega[3], velocity[3] = {0.0, 0.0, 0.0}, roughness;
    const int count = rebound_normal(tp, f_normal, dim, normal);
    const uint32_t hit = (uint32_t)(TP_USER_REAL(tp, REBOUND_HITS) + (real)0.5);
    if (TP_TYPE(tp) != DPM_TYPE_INERT || !rebound_table)
        return PATH_ABORT;
    rebound_wall_velocity(f, t, wall);
    for (int k = 0; k < count; k++)
        velocity[k] = TP_VEL(tp)[k];
    for (int k = 0; k < 3; k++)
        omega[k] = REBOUND_SPIN(tp)[k];
    const double speed = rebound_speed(velocity, wall);

    int code = rebound_roughness(TP_DIAM(tp), &roughness);
    if (code == RBT_OK)
        code = rbt_rough_rebound(rebound_table, velocity, normal, REBOUND_HALF_SIZE * TP_DIAM(tp),
                                 wall, roughness, rebound_keeps_spin ? omega : NULL, REBOUND_SEED,
                                 (uint64_t)TP_ID(tp), hit, velocity, omega);
    if (code == RBT_ERR_NOT_APPROACHING)
        return PATH_ACTIVE; /* at the wall, but leaving already: no hit */
    if (code < RBT_OK) {
        Message("rebound_wall: particle %lld: %s\n", (long long)TP_ID(tp), rbt_strerror(code));
        return PATH_ABORT;
    }
    /* In a plane case the component out of the plane is dropped, with its energy. */
    for (int k = 0; k < count; k++) {
        TP_VEL(tp)[k] = (real)velocity[k];
        TP_VEL0(tp)[k] = (real)velocity[k]; /* keeps the wall's impulse out of the gas's balance */
    }
    for (int k = 0; k < 3; k++)
        REBOUND_SPIN(tp)[k] = (real)omega[k];
    rebound_count(tp, code, speed);
    return PATH_ACTIVE;
}
