/* Follow grains of corundum, in air of 100 m/s, through a channel with two plates, on a GPU: a thread follows
   each grain.

   The gas exerts a drag and a torque on them. A grain keeps its index, the number of walls that it has met, its
   spin, and the inertia about its spin. All quantities are in SI units.

   The drag is that of Schiller & Naumann (Z. VDI 77 (1933) 318) on spheres of equal volume, which holds up to
   a Reynolds number of 800; the slip of these grains gives up to 570. rbt_sphericity is for drag laws of
   other grains. */
#define REBOUND_SAMPLER_IMPLEMENTATION /* in one file of a program */
#include "rebound_sampler.h"
#include "rebound_device.h"

#include <cmath>
#include <cstdio>

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

struct wall {
    double x, y;      /* one end */
    double normal[3]; /* into the gas */
    double length;
};

struct grain {
    double x, y;
    double v[3];
    double omega[3]; /* mean angular velocity */
    double inertia;  /* about it, over MASS half_size^2; 0 is not known */
    double half_size; /* a, the largest */
    double flight;   /* time since the last wall */
    uint64_t index;
    uint32_t hit;    /* number of walls that it has met */
};

/* Sums over all grains, to which threads add. */
enum { PASSED, RESTING, HITS, SQUARED_VELOCITY, SPIN, OUTSIDE, FAILED, N_SUMS };

/* Find the normal of the wall that the next step of a grain crosses. Returns false if there is none. */
static RBT_DEVICE bool find_wall_ahead(const grain &g, double normal[3])
{
    const wall walls[] = {
        {-9.0, 0.0, {0.0, 1.0, 0.0}, 18.0},                  /* floor */
        {9.0, 0.1, {0.0, -1.0, 0.0}, 18.0},                  /* roof */
        {0.1, 0.0, {-0.8660254, 0.5, 0.0}, 0.07},            /* plate on the floor: front */
        {0.135, 0.06062178, {0.8660254, -0.5, 0.0}, 0.07},   /* back */
        {0.235, 0.03937822, {-0.8660254, -0.5, 0.0}, 0.07},  /* plate on the roof: front */
        {0.2, 0.1, {0.8660254, 0.5, 0.0}, 0.07},             /* back */
    };
    bool is_ahead = false;
    for (const wall &w : walls) {
        const double *n = w.normal;
        const double x = g.x - w.x;
        const double y = g.y - w.y;
        const double distance = n[0] * x + n[1] * y;
        const double along = n[1] * x - n[0] * y;
        const double approach = -(n[0] * g.v[0] + n[1] * g.v[1]);
        if (distance >= 0.0 && distance < TIME_STEP * approach && along > 0.0 && along < w.length) {
            is_ahead = true;
            for (int i = 0; i < 3; i++)
                normal[i] = n[i];
        }
    }
    return is_ahead;
}

/* The rate at which the drag takes the slip of a grain, 1/s. */
static RBT_DEVICE double find_drag_rate(const grain &g)
{
    const double u = GAS_SPEED - g.v[0], v = g.v[1], w = g.v[2];
    const double reynolds = GAS_DENSITY * DIAMETER / VISCOSITY * sqrt(u * u + v * v + w * w);
    return STOKES_RATE * (1.0 + 0.15 * pow(reynolds, 0.687));
}

/* The normal speed below which a grain rests. Where the gas presses it to the wall, its next hop would be
   lower than a hundredth of its diameter. */
static RBT_DEVICE double find_resting_speed(const grain &g, const double normal[3])
{
    const double slip[3] = {GAS_SPEED - g.v[0], -g.v[1], -g.v[2]};
    const double along_normal = slip[0] * normal[0] + slip[1] * normal[1] + slip[2] * normal[2];
    const double towards_wall = -find_drag_rate(g) * along_normal; /* acceleration */
    return towards_wall > 0.0 ? sqrt(2.0 * towards_wall * 0.01 * DIAMETER) : 0.0;
}

/* Let the torque of the gas act on the spin. One call for the whole flight since the last wall is exact. */
static RBT_DEVICE void slow_down_spin(grain &g)
{
    const double moment = g.inertia * MASS * g.half_size * g.half_size;
    if (g.hit > 0) /* before its first wall the grain does not spin */
        rbt_spin_after(g.omega, g.flight, moment, DIAMETER, GAS_DENSITY, VISCOSITY, nullptr, g.omega);
    g.flight = 0.0;
}

/* Rebound a grain. Returns the code. */
static RBT_DEVICE int rebound(const rbt_table *table, grain &g, const double normal[3])
{
    rbt_impacts impact = {};
    impact.velocity = g.v;
    impact.normal = normal;
    impact.half_size = &g.half_size;
    impact.omega = g.omega;
    impact.inertia = &g.inertia;
    impact.index = &g.index;
    impact.hit = &g.hit;
    rbt_rebounds after = {};
    after.velocity = g.v;
    after.omega = g.omega;
    after.inertia = &g.inertia;
    const int code = rbt_rebound(table, 1, &impact, SEED, &after);
    g.hit++;
    return code;
}

RBT_KERNEL follow(RBT_TABLE_ARGUMENT table, unsigned long long n_grains, double *sums)
{
    RBT_EACH_ROW(k, n_grains)
    {
        double outside = 0.0, failed = 0.0, normal[3], shape[3]; /* code, b/a and c/b */
        grain g = {};
        g.y = ((double)k + 0.5) * CHANNEL_HEIGHT / (double)n_grains;
        g.v[0] = GAS_SPEED;
        g.index = k;
        if (rbt_grains(&table, 1, SEED, &g.index, nullptr, shape) < 0)
            failed = 1.0;
        g.half_size = rbt_half_size(&table, DIAMETER, shape);
        while (g.x >= 0.0 && g.x < CHANNEL_LENGTH) {
            const double share = 1.0 - exp(-find_drag_rate(g) * TIME_STEP); /* of the slip */
            g.v[0] += share * (GAS_SPEED - g.v[0]);
            g.v[1] -= share * g.v[1];
            g.v[2] -= share * g.v[2];
            g.flight += TIME_STEP;
            if (!find_wall_ahead(g, normal)) {
                g.x += TIME_STEP * g.v[0];
                g.y += TIME_STEP * g.v[1];
                continue;
            }
            if (rbt_deposits(g.v, normal, find_resting_speed(g, normal), nullptr))
                break;
            slow_down_spin(g);
            const int code = rebound(&table, g, normal);
            if (code < 0) {
                failed = 1.0;
                break;
            }
            if (code & RBT_OUTSIDE)
                outside += 1.0;
        }
        slow_down_spin(g);
        atomicAdd(sums + PASSED, g.x >= CHANNEL_LENGTH ? 1.0 : 0.0);
        atomicAdd(sums + RESTING, g.x >= 0.0 && g.x < CHANNEL_LENGTH ? 1.0 : 0.0);
        atomicAdd(sums + HITS, (double)g.hit);
        atomicAdd(sums + SQUARED_VELOCITY, g.v[0] * g.v[0] + g.v[1] * g.v[1] + g.v[2] * g.v[2]);
        atomicAdd(sums + SPIN, g.omega[2]);
        atomicAdd(sums + OUTSIDE, outside);
        atomicAdd(sums + FAILED, failed);
    }
}

/* End the program with a message. */
static int fail(const char *message)
{
    std::fprintf(stderr, "tracker: %s\n", message);
    return 1;
}

int main()
{
    double sums[N_SUMS] = {};
    void *copy, *device_sums;
    rbt_table *table, device_table;
    int code = rbt_open("corundum-steel.rbt", &table);
    if (code < 0)
        return fail(rbt_strerror(code));
    code = rbt_to_device(table, &device_table, &copy);
    rbt_close(table);
    if (code < 0)
        return fail(rbt_strerror(code));
    if (RBT_DEVICE_MALLOC(&device_sums, sizeof sums) != 0)
        return fail("the device has no memory left");
    if (RBT_DEVICE_COPY(device_sums, sums, sizeof sums) != 0)
        return fail("the sums were not copied to the device");
    RBT_LAUNCH(follow, 32, 64, device_table, N_GRAINS, static_cast<double *>(device_sums));
    if (RBT_DEVICE_COPY(sums, device_sums, sizeof sums) != 0)
        return fail("the grains were not followed to their end");
    rbt_device_free(device_sums);
    rbt_device_free(copy);
    if (sums[FAILED] > 0.0)
        return fail("a rebound has failed");
    std::printf("grains that pass:      %g\n", sums[PASSED]);
    std::printf("grains that rest:      %g\n", sums[RESTING]);
    std::printf("hits of walls:         %g\n", sums[HITS]);
    std::printf("sum of v^2, m2/s2:     %.12g\n", sums[SQUARED_VELOCITY]);
    std::printf("sum of omega_z, rad/s: %.12g\n", sums[SPIN]);
    std::printf("outside the table:     %g\n", sums[OUTSIDE]);
    return 0;
}
