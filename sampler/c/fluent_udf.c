/* Rebounds from a table in Ansys Fluent: a compiled UDF for inert particles.

   How to install it: README.md beside this file. A particle has five user scalars: the number of walls met, the
   mean angular velocity (three numbers, rad/s), and the inertia about it over m a^2. */
#define REBOUND_SAMPLER_IMPLEMENTATION
#include "rebound_sampler.h"

#include "udf.h"

/* Change these three for your case. */
static const char *const table_path = "corundum-steel.rbt";
static const double half_size_over_diameter = 0.63; /* what rbt_mean_half_size gives for this table */
static const uint64_t seed = 7;

/* User scalars of a particle. */
enum { HITS, OMEGA, INERTIA = OMEGA + 3, N_SCALARS };

/* The table, which is opened at the first hit. If it cannot be opened, a message says why, and it is NULL. */
static const rbt_table *find_table(void)
{
    static rbt_table *table = NULL;
    static int was_tried = 0;
    if (!was_tried) {
        was_tried = 1;
        const int code = rbt_open(table_path, &table);
        if (code < 0)
            Message("rebound_wall: %s: %s; all particles that meet a wall are aborted\n", table_path,
                    rbt_strerror(code));
    }
    return table;
}

/* Find the normal of a wall from the wall into the gas. f_normal points out of the gas. Returns how many
   components of the velocity Fluent keeps. */
static int find_normal(Tracked_Particle *tp, const real f_normal[], int dim, double normal[3])
{
    normal[0] = -f_normal[0];
    normal[1] = -f_normal[1];
    normal[2] = 0.0;
#if RP_3D
    normal[2] = -f_normal[2];
#else
    if (rp_axi_swirl) { /* particles move in three dimensions, but faces lie in a half-plane */
        const double y = TP_POS(tp)[1];
        const double z = TP_POS(tp)[2];
        const double radius = sqrt(y * y + z * z);
        if (radius > 1e-20) {
            normal[1] = -f_normal[1] * y / radius;
            normal[2] = -f_normal[1] * z / radius;
        }
        return 3;
    }
#endif
    return dim;
}

/* A new particle has met no wall and does not spin. */
DEFINE_DPM_SCALAR_UPDATE(start_particle, cell, thread, initialize, tp)
{
    if (initialize)
        for (int k = 0; k < N_SCALARS; k++)
            TP_USER_REAL(tp, k) = 0;
}

DEFINE_DPM_BC(rebound_wall, tp, t, f, f_normal, dim)
{
    const rbt_table *table = find_table();
    if (table == NULL)
        return PATH_ABORT;

    double normal[3];
    const int n_components = find_normal(tp, f_normal, dim, normal);
    double velocity[3] = {0.0, 0.0, 0.0};
    for (int k = 0; k < n_components; k++)
        velocity[k] = TP_VEL(tp)[k];
    double wall_velocity[3] = {0.0, 0.0, 0.0};
    if (SV_ALLOCATED_P(t, SV_WALL_GRID_V) && SV_ALLOCATED_P(t, SV_WALL_V)) /* the wall moves */
        for (int k = 0; k < dim; k++)
            wall_velocity[k] = WALL_F_VV(f, t)[k] + WALL_F_GRID_VV(f, t)[k];
    double omega[3];
    for (int k = 0; k < 3; k++)
        omega[k] = TP_USER_REAL(tp, OMEGA + k);
    double inertia = TP_USER_REAL(tp, INERTIA);
    const double half_size = half_size_over_diameter * TP_DIAM(tp);
    const uint64_t index = (uint64_t)TP_ID(tp);
    const uint32_t hit = (uint32_t)TP_USER_REAL(tp, HITS);

    rbt_impacts impact = {0}; /* fields that stay 0 are "none" */
    impact.velocity = velocity;
    impact.normal = normal;
    impact.half_size = &half_size;
    impact.wall_velocity = wall_velocity;
    impact.omega = omega;
    impact.inertia = &inertia;
    impact.index = &index;
    impact.hit = &hit;
    rbt_rebounds after = {0};
    after.velocity = velocity;
    after.omega = omega;
    after.inertia = &inertia;
    const int code = rbt_rebound(table, 1, &impact, seed, &after);
    if (code == RBT_ERR_NOT_APPROACHING) /* the particle leaves the wall already */
        return PATH_ACTIVE;
    if (code < 0) {
        Message("rebound_wall: particle %ld: %s\n", (long)TP_ID(tp), rbt_strerror(code));
        return PATH_ABORT;
    }

    for (int k = 0; k < n_components; k++) {
        TP_VEL(tp)[k] = velocity[k];
        TP_VEL0(tp)[k] = velocity[k];
    }
    TP_USER_REAL(tp, HITS) += 1;
    for (int k = 0; k < 3; k++)
        TP_USER_REAL(tp, OMEGA + k) = omega[k];
    TP_USER_REAL(tp, INERTIA) = inertia;
    return PATH_ACTIVE;
}
