/* Grains of corundum in a channel with two plates. A grain keeps its number, the number of walls that it
   has met, its spin, and the inertia about its spin. */
#define REBOUND_SAMPLER_IMPLEMENTATION /* in one file of a program */
#include "rebound_sampler.h"

#include <stdio.h>

/* SI units: time step, gas, diameter, mass and largest half-size of a grain */
static const double dt = 2e-5, gas[3] = {100, 0, 0}, density = 1.2, viscosity = 1.8e-5;
static const double diameter = 60e-6, mass = 4.5e-10, half_size = 0.63 * 60e-6;

/* floor, roof, two sides of each plate: x, y of an end, the normal into the gas, the length */
static const double walls[6][6] = {
    {-9, 0, 0, 1, 0, 18},
    {9, 0.1, 0, -1, 0, 18},
    {0.1, 0, -0.8660254, 0.5, 0, 0.07},
    {0.135, 0.06062178, 0.8660254, -0.5, 0, 0.07},
    {0.235, 0.03937822, -0.8660254, -0.5, 0, 0.07},
    {0.2, 0.1, 0.8660254, 0.5, 0, 0.07},
};

typedef struct {
    double x[2], v[3];
    double omega[3]; /* mean angular velocity, rad/s */
    double inertia;  /* about it, over mass half_size^2; 0: not known */
    double flight;   /* time since the last wall, s */
    uint64_t index;  /* number of the grain */
    uint32_t hit;    /* number of walls that it has met */
} grain;

/* Normal of the wall that the next step crosses; NULL: none. */
static const double *wall_ahead(const grain *g)
{
    const double *normal = NULL;
    for (int k = 0; k < 6; k++) {
        const double *end = walls[k], *n = walls[k] + 2, length = walls[k][5];
        const double x = g->x[0] - end[0], y = g->x[1] - end[1];
        const double away = n[0] * x + n[1] * y, along = n[1] * x - n[0] * y;
        const double approach = -(n[0] * g->v[0] + n[1] * g->v[1]);
        if (away >= 0 && away < dt * approach && along > 0 && along < length)
            normal = n;
    }
    return normal;
}

/* Normal speed below which a grain rests: its next hop would be lower than a hundredth of its diameter,
   since the gas presses it to the wall. */
static double resting_speed(const grain *g, const double *n)
{
    double pressure = 0; /* acceleration towards the wall */
    for (int k = 0; k < 3; k++)
        pressure -= n[k] * (gas[k] - g->v[k]) * (9.42477796 * viscosity * diameter / mass);
    return pressure > 0 ? sqrt(2 * pressure * 0.01 * diameter) : 0;
}

/* The torque of the gas over the whole flight from the last wall. One call is exact. */
static void slow_down_spin(grain *g)
{
    const double moment = g->inertia * mass * half_size * half_size;
    if (g->hit > 0) /* else it does not spin yet */
        rbt_spin_after(g->omega, g->flight, moment, diameter, density, viscosity, NULL, g->omega);
    g->flight = 0;
}

/* Returns a code. */
static int rebound(const rbt_table *table, grain *g, const double *normal)
{
    rbt_impacts before = {0}; /* fields that stay 0 are "none" */
    rbt_rebounds after = {0};
    before.velocity = g->v;
    before.normal = normal;
    before.half_size = &half_size;
    before.omega = g->omega;
    before.inertia = &g->inertia;
    before.index = &g->index;
    before.hit = &g->hit;
    after.velocity = g->v;
    after.omega = g->omega;
    after.inertia = &g->inertia;
    const int code = rbt_rebound(table, 1, &before, 7, &after);
    g->hit++;
    return code;
}

int main(void)
{
    const double share = 1 - exp(-9.42477796 * viscosity * diameter * dt / mass);
    double passed = 0, back = 0, hits = 0, energy = 0, spin = 0, outside = 0;
    rbt_table *table;
    int code = rbt_open("corundum-steel.rbt", &table);
    if (code < 0) {
        puts(rbt_strerror(code));
        return 1;
    }
    for (uint64_t index = 0; index < 2000; index++) {
        grain g = {{0, ((double)index + 0.5) * 5e-5}, {100, 0, 0}, {0, 0, 0}, 0, 0, index, 0};
        while (g.x[0] >= 0 && g.x[0] < 0.5) {
            for (int k = 0; k < 3; k++)
                g.v[k] += share * (gas[k] - g.v[k]);
            g.flight += dt;
            const double *normal = wall_ahead(&g);
            if (normal == NULL) {
                g.x[0] += dt * g.v[0];
                g.x[1] += dt * g.v[1];
                continue;
            }
            if (rbt_deposits(g.v, normal, resting_speed(&g, normal), NULL))
                break;
            slow_down_spin(&g);
            code = rebound(table, &g, normal);
            if (code < 0) {
                puts(rbt_strerror(code));
                return 1;
            }
            outside += (code & RBT_OUTSIDE) != 0;
        }
        slow_down_spin(&g);
        passed += g.x[0] >= 0.5;
        back += g.x[0] < 0;
        hits += g.hit;
        energy += g.v[0] * g.v[0] + g.v[1] * g.v[1] + g.v[2] * g.v[2];
        spin += g.omega[2];
    }
    rbt_close(table);
    printf("%g %g %g %.12g %.12g %g\n", passed, back, hits, energy, spin, outside);
    return 0;
}
