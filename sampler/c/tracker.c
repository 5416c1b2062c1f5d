/* Follow grains of corundum, in air of 100 m/s, through a channel with two plates.

   The gas exerts a drag and a torque on them. A grain keeps its index, the number of walls that it has met, its
   spin, and the inertia about its spin. All quantities are in SI units.

   The drag is that of Schiller & Naumann (Z. VDI 77 (1933) 318) on spheres of equal volume, which holds up to
   a Reynolds number of 800; the slip of these grains gives up to 570. rbt_sphericity is for drag laws of
   other grains. */
#define REBOUND_SAMPLER_IMPLEMENTATION /* in one file of a program */
#include "rebound_sampler.h"

#include <math.h>
#include <stdio.h>

#define N_GRAINS 2000
#define SEED 7
#define TIME_STEP 2e-5
#define CHANNEL_LENGTH 0.5
#define CHANNEL_HEIGHT 0.1

#define GAS_SPEED 100.0 /* along x */
#define GAS_DENSITY 1.2
#define VISCOSITY 1.8e-5

#define DIAMETER 60e-6 /* of the sphere of equal volume */
#define MASS 4.5e-10
#define PI 3.141592653589793
#define STOKES_RATE (3.0 * PI * VISCOSITY * DIAMETER / MASS) /* of the drag at small slip */

typedef struct {
    double x, y;      /* one end */
    double normal[3]; /* into the gas */
    double length;
} wall;

static const wall walls[] = {
    {-9.0, 0.0, {0.0, 1.0, 0.0}, 18.0},                  /* floor */
    {9.0, 0.1, {0.0, -1.0, 0.0}, 18.0},                  /* roof */
    {0.1, 0.0, {-0.8660254, 0.5, 0.0}, 0.07},            /* plate on the floor: front */
    {0.135, 0.06062178, {0.8660254, -0.5, 0.0}, 0.07},   /* back */
    {0.235, 0.03937822, {-0.8660254, -0.5, 0.0}, 0.07},  /* plate on the roof: front */
    {0.2, 0.1, {0.8660254, 0.5, 0.0}, 0.07},             /* back */
};

typedef struct {
    double x, y;
    double v[3];
    double omega[3]; /* mean angular velocity */
    double inertia;  /* about it, over MASS half_size^2; 0 is not known */
    double half_size; /* a, the largest */
    double flight;   /* time since the last wall */
    uint64_t index;
    uint32_t hit;    /* number of walls that it has met */
} grain;

/* The wall that the next step of a grain crosses, or NULL. */
static const wall *find_wall_ahead(const grain *g)
{
    const wall *ahead = NULL;
    for (size_t k = 0; k < sizeof walls / sizeof walls[0]; k++) {
        const double *n = walls[k].normal;
        const double x = g->x - walls[k].x;
        const double y = g->y - walls[k].y;
        const double distance = n[0] * x + n[1] * y;
        const double along = n[1] * x - n[0] * y;
        const double approach = -(n[0] * g->v[0] + n[1] * g->v[1]);
        if (distance >= 0.0 && distance < TIME_STEP * approach && along > 0.0 &&
            along < walls[k].length)
            ahead = &walls[k];
    }
    return ahead;
}

/* The rate at which the drag takes the slip of a grain, 1/s. */
static double find_drag_rate(const grain *g)
{
    const double u = GAS_SPEED - g->v[0], v = g->v[1], w = g->v[2];
    const double reynolds = GAS_DENSITY * DIAMETER / VISCOSITY * sqrt(u * u + v * v + w * w);
    return STOKES_RATE * (1.0 + 0.15 * pow(reynolds, 0.687));
}

/* The normal speed below which a grain rests. Where the gas presses it to the wall, its next hop would be
   lower than a hundredth of its diameter. */
static double find_resting_speed(const grain *g, const double normal[3])
{
    const double slip[3] = {GAS_SPEED - g->v[0], -g->v[1], -g->v[2]};
    const double along_normal = slip[0] * normal[0] + slip[1] * normal[1] + slip[2] * normal[2];
    const double towards_wall = -find_drag_rate(g) * along_normal; /* acceleration */
    return towards_wall > 0.0 ? sqrt(2.0 * towards_wall * 0.01 * DIAMETER) : 0.0;
}

/* Let the torque of the gas act on the spin. One call for the whole flight since the last wall is exact. */
static void slow_down_spin(grain *g)
{
    const double moment = g->inertia * MASS * g->half_size * g->half_size;
    if (g->hit > 0) /* before its first wall the grain does not spin */
        rbt_spin_after(g->omega, g->flight, moment, DIAMETER, GAS_DENSITY, VISCOSITY, NULL, g->omega);
    g->flight = 0.0;
}

/* Rebound a grain. Returns the code. */
static int rebound(const rbt_table *table, grain *g, const double normal[3])
{
    rbt_impacts impact = {0}; /* fields that stay 0 are "none" */
    rbt_rebounds after = {0};
    impact.velocity = g->v;
    impact.normal = normal;
    impact.half_size = &g->half_size;
    impact.omega = g->omega;
    impact.inertia = &g->inertia;
    impact.index = &g->index;
    impact.hit = &g->hit;
    after.velocity = g->v;
    after.omega = g->omega;
    after.inertia = &g->inertia;
    const int code = rbt_rebound(table, 1, &impact, SEED, &after);
    g->hit++;
    return code;
}

/* Follow a grain until it leaves the channel or rests on a wall, and count impacts outside the table. Returns
   RBT_OK or an error. */
static int follow(const rbt_table *table, grain *g, int *outside)
{
    while (g->x >= 0.0 && g->x < CHANNEL_LENGTH) {
        const double share = 1.0 - exp(-find_drag_rate(g) * TIME_STEP); /* of the slip */
        g->v[0] += share * (GAS_SPEED - g->v[0]);
        g->v[1] -= share * g->v[1];
        g->v[2] -= share * g->v[2];
        g->flight += TIME_STEP;
        const wall *ahead = find_wall_ahead(g);
        if (ahead == NULL) {
            g->x += TIME_STEP * g->v[0];
            g->y += TIME_STEP * g->v[1];
            continue;
        }
        if (rbt_deposits(g->v, ahead->normal, find_resting_speed(g, ahead->normal), NULL))
            break;
        slow_down_spin(g);
        const int code = rebound(table, g, ahead->normal);
        if (code < 0)
            return code;
        if (code & RBT_OUTSIDE)
            *outside += 1;
    }
    slow_down_spin(g);
    return RBT_OK;
}

int main(void)
{
    int passed = 0, resting = 0, hits = 0, outside = 0;
    double squared_velocity = 0.0, spin = 0.0;
    rbt_table *table;
    int code = rbt_open("corundum-steel.rbt", &table);
    if (code < 0) {
        fprintf(stderr, "corundum-steel.rbt: %s\n", rbt_strerror(code));
        return 1;
    }
    for (int k = 0; k < N_GRAINS; k++) {
        grain g = {0};
        g.y = (k + 0.5) * CHANNEL_HEIGHT / N_GRAINS;
        g.v[0] = GAS_SPEED;
        g.index = (uint64_t)k;
        double shape[3]; /* its code, b/a and c/b */
        code = rbt_grains(table, 1, SEED, &g.index, NULL, shape);
        if (code < 0) {
            fprintf(stderr, "grain %d: %s\n", k, rbt_strerror(code));
            return 1;
        }
        g.half_size = rbt_half_size(table, DIAMETER, shape);
        code = follow(table, &g, &outside);
        if (code < 0) {
            fprintf(stderr, "grain %d: %s\n", k, rbt_strerror(code));
            return 1;
        }
        passed += g.x >= CHANNEL_LENGTH;
        resting += g.x >= 0.0 && g.x < CHANNEL_LENGTH;
        hits += (int)g.hit;
        squared_velocity += g.v[0] * g.v[0] + g.v[1] * g.v[1] + g.v[2] * g.v[2];
        spin += g.omega[2];
    }
    rbt_close(table);
    printf("grains that pass:      %d\n", passed);
    printf("grains that rest:      %d\n", resting);
    printf("hits of walls:         %d\n", hits);
    printf("sum of v^2, m2/s2:     %.12g\n", squared_velocity);
    printf("sum of omega_z, rad/s: %.12g\n", spin);
    printf("outside the table:     %d\n", outside);
    return 0;
}
