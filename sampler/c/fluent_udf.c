/* Rebounds from a table in Ansys Fluent: a compiled UDF for inert particles.

   Put rebound_sampler.h beside this file in the UDF library, and the binary table into the folder where
   Fluent runs. Give particles five user scalars: the number of walls met, the mean angular velocity
   (three numbers, rad/s), and the inertia about it over m a^2. Hook start_particle as the scalar update
   of the discrete phase, and rebound_wall as the boundary condition at each wall. */
#define REBOUND_SAMPLER_IMPLEMENTATION
#include "rebound_sampler.h"

#include "udf.h"

enum { HITS, OMEGA, INERTIA = OMEGA + 3 };

static const char *const path = "corundum-steel.rbt";
static const double half_size_rule = 0.63; /* largest half-size over the diameter */
static const uint64_t seed = 7;

/* The table, which is opened at the first hit. NULL, after a message, if it cannot be opened. */
static const rbt_table *the_table(void)
{
    static rbt_table *table = NULL;
    static int tried = 0;
    if (!tried) {
        tried = 1;
        const int code = rbt_open(path, &table);
        if (code < 0)
            Message("rebound_wall: %s: %s; all particles that meet a wall are aborted\n", path,
                    rbt_strerror(code));
    }
    return table;
}

/* A new particle has met no wall, and does not spin. */
DEFINE_DPM_SCALAR_UPDATE(start_particle, cell, thread, initialize, tp)
{
    if (initialize)
        for (int k = HITS; k <= INERTIA; k++)
            TP_USER_REAL(tp, k) = 0;
}

DEFINE_DPM_BC(rebound_wall, tp, t, f, f_normal, dim)
{
    const rbt_table *table = the_table();
    const double a = half_size_rule * TP_DIAM(tp);
    const uint64_t index = (uint64_t)TP_ID(tp);
    const uint32_t hit = (uint32_t)TP_USER_REAL(tp, HITS);
    double normal[3] = {-f_normal[0], -f_normal[1], 0}; /* from the wall into the gas */
    double v[3] = {TP_VEL(tp)[0], TP_VEL(tp)[1], 0}, wall[3] = {0, 0, 0}, omega[3], inertia;
    int components = dim;
    if (table == NULL)
        return PATH_ABORT;
#if RP_3D
    normal[2] = -f_normal[2];
#else
    if (rp_axi_swirl) { /* particles move in three dimensions, faces lie in a half-plane */
        const double y = TP_POS(tp)[1], z = TP_POS(tp)[2], radius = sqrt(y * y + z * z);
        components = 3;
        if (radius > 1e-20) {
            normal[1] = -f_normal[1] * y / radius;
            normal[2] = -f_normal[1] * z / radius;
        }
    }
#endif
    if (components == 3)
        v[2] = TP_VEL(tp)[2];
    if (SV_ALLOCATED_P(t, SV_WALL_GRID_V) && SV_ALLOCATED_P(t, SV_WALL_V)) /* it moves */
        for (int k = 0; k < dim; k++)
            wall[k] = WALL_F_VV(f, t)[k] + WALL_F_GRID_VV(f, t)[k];
    for (int k = 0; k < 3; k++)
        omega[k] = TP_USER_REAL(tp, OMEGA + k);
    inertia = TP_USER_REAL(tp, INERTIA);

    rbt_impacts before = {0}; /* fields that stay 0 are "none" */
    rbt_rebounds after = {0};
    before.velocity = v;
    before.normal = normal;
    before.half_size = &a;
    before.wall_velocity = wall;
    before.omega = omega;
    before.inertia = &inertia;
    before.index = &index;
    before.hit = &hit;
    after.velocity = v;
    after.omega = omega;
    after.inertia = &inertia;
    const int code = rbt_rebound(table, 1, &before, seed, &after);
    if (code == RBT_ERR_NOT_APPROACHING) /* it leaves the wall already */
        return PATH_ACTIVE;
    if (code < 0) {
        Message("rebound_wall: particle %ld: %s\n", (long)TP_ID(tp), rbt_strerror(code));
        return PATH_ABORT;
    }
    for (int k = 0; k < components; k++)
        TP_VEL(tp)[k] = TP_VEL0(tp)[k] = v[k];
    TP_USER_REAL(tp, HITS) += 1;
    for (int k = 0; k < 3; k++)
        TP_USER_REAL(tp, OMEGA + k) = omega[k];
    TP_USER_REAL(tp, INERTIA) = inertia;
    return PATH_ACTIVE;
}
