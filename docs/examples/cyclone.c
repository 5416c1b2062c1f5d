/* cyclone.c - the cyclone of cyclone.py in C, with rebounds from a table or by direct simulation.

       I="$(python -m sampler --include-dir)"
       sampler export corundum-steel --output corundum-steel.rbt
       gcc -O2 -I"$I" docs/examples/cyclone.c -o cyclone -lm
       ./cyclone corundum-steel.rbt 10000 512

       tablegen export-direct corundum-steel --output direct
       gcc -O2 -I"$I" -Idirect -DDIRECT docs/examples/cyclone.c direct/rebound_direct.o -o cyclone_direct -lm
       ./cyclone_direct corundum-steel.rbt 10000 512

   follow 10000 grains, and rebound up to 512 of them in a call. All grains fly to their next wall, then all
   rebound, and so on until each is collected, escapes, or has been inside for two seconds. The geometry, the
   gas, the grains and the rule for rest are those of cyclone.py, whose head describes them. */

#define REBOUND_SAMPLER_IMPLEMENTATION
#include "rebound_sampler.h"
#ifdef DIRECT
#include "rebound_direct.h"
#endif

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define PI 3.14159265358979323846
static const double GAS_DENSITY = 1.16, VISCOSITY = 1.85e-5, DENSITY = 3950.0, GRAVITY = 9.81;
static const double RADIUS = 0.1, CORE = 0.05, FINDER = 0.12, CYLINDER = 0.2, HEIGHT = 0.4;
static const double INLET_HEIGHT = 0.12, INLET_WIDTH = 0.05, INLET_SPEED = 40.0;
static const double FLOW = 0.12 * 0.05 * 40.0, CORE_HEIGHT = 0.4 - 0.12, SLOPE = (0.09 - 0.1) / (0.4 - 0.2);
static const double LOSS = (0.4 - 0.12) * 0.1 * PI * 0.007 * 40.0 / (0.12 * 0.05 * 40.0);
static const double THROUGH_BIN = 0.5, STEP = 1e-3, TIME_LIMIT = 2.0, HOP = 0.01;
static const double SMALLEST = 5e-6, LARGEST = 100e-6;
enum { SEED = 1, MOST = 100000 };

/* Walls that a flight ends at, and other ends. */
typedef enum { BODY, CONE, LID, TUBE, COLLECTED, ESCAPED, TIME_IS_UP } place;

/* Grains inside: what a flight needs, and the arrays that rbt_rebound reads and replaces. */
typedef struct {
    double p[6]; /* place, m, with z down from the lid, and velocity, m/s */
    double drag[6], diameter, time;
} grain;
static grain grains[MOST];
static double velocity[MOST][3], normal[MOST][3], omega[MOST][3], half_size[MOST], inertia[MOST];
static uint64_t index_of[MOST];
static uint32_t hit[MOST];

static double wall_radius(double z)
{
    return z > CYLINDER ? RADIUS + SLOPE * (z - CYLINDER) : RADIUS;
}

static void gas_velocity(const double p[3], double gas[3])
{
    const double z = p[2], r = sqrt(p[0] * p[0] + p[1] * p[1]) + 1e-12, core = CORE * CORE;
    const double around = r > CORE ? INLET_SPEED * RADIUS / r / (1.0 + LOSS * (RADIUS - r) / (RADIUS - CORE))
                                   : INLET_SPEED * RADIUS * r / core / (1.0 + LOSS);
    double axial, radial;
    if (z < FINDER) {
        const double share = (r * r - core) / (RADIUS * RADIUS - core);
        axial = FLOW * z / FINDER / (PI * (RADIUS * RADIUS - core));
        radial = -FLOW / FINDER * share / (2.0 * PI * r);
    } else {
        const double sink = FLOW * (1.0 - THROUGH_BIN) / CORE_HEIGHT, down = FLOW - sink * (z - FINDER);
        const double wall = wall_radius(z), area = wall * wall - core, slope = z > CYLINDER ? SLOPE : 0.0;
        axial = r > CORE ? down / (PI * area) : -down / (PI * core);
        radial = r > CORE ? -sink * (wall * wall - r * r) / area +
                                down * 2.0 * wall * slope * (r * r - core) / (area * area)
                          : -sink * r * r / core;
        radial /= 2.0 * PI * r;
    }
    gas[0] = (radial * p[0] - around * p[1]) / r;
    gas[1] = (radial * p[1] + around * p[0]) / r;
    gas[2] = axial;
}

/* Coefficients of the drag of Haider & Levenspiel. */
static void set_drag(grain *g, double sphericity)
{
    const double s = sphericity < 1.0 ? sphericity : 1.0, d = g->diameter;
    g->drag[0] = 18.0 * VISCOSITY / (DENSITY * d * d);
    g->drag[1] = GAS_DENSITY * d / VISCOSITY;
    g->drag[2] = exp(2.3288 - 6.4581 * s + 2.4486 * s * s);
    g->drag[3] = 0.0964 + 0.5565 * s;
    g->drag[4] = exp(4.905 - 13.8944 * s + 18.4222 * s * s - 10.2599 * s * s * s);
    g->drag[5] = exp(1.4681 + 12.2584 * s - 20.7322 * s * s + 15.8855 * s * s * s);
}

/* Slip of the gas past a grain, and the rate at which drag takes it, 1/s. */
static double drag_rate(const double drag[6], const double p[6], double gas[3], double slip[3])
{
    gas_velocity(p, gas);
    for (int k = 0; k < 3; k++)
        slip[k] = gas[k] - p[3 + k];
    const double re = drag[1] * sqrt(slip[0] * slip[0] + slip[1] * slip[1] + slip[2] * slip[2]);
    return drag[0] * (1.0 + drag[2] * pow(re, drag[3]) + drag[4] / 24.0 * re * re / (re + drag[5]));
}

/* State after a time h in the gas of a place, with the drag there. */
static void part_of_step(const double p[6], const double at[6], const double drag[6], double h, double end[6])
{
    double gas[3], slip[3];
    const double rate = drag_rate(drag, at, gas, slip), left = exp(-rate * h);
    const double moved = rate * h > 1e-12 ? -expm1(-rate * h) / rate : h;
    const double fallen = rate * h > 1e-4 ? (h - moved) / rate : 0.5 * h * h;
    for (int k = 0; k < 3; k++) {
        const double g = k == 2 ? GRAVITY : 0.0, v = p[3 + k] - gas[k];
        end[k] = p[k] + h * gas[k] + moved * v + g * fallen;
        end[3 + k] = gas[k] + left * v + g * moved;
    }
}

static void step(const double p[6], const double drag[6], double h, double end[6])
{
    double middle[6];
    part_of_step(p, p, drag, 0.5 * h, middle);
    part_of_step(p, middle, drag, h, end);
}

static int is_inside(const double p[6])
{
    const double r2 = p[0] * p[0] + p[1] * p[1], wall = wall_radius(p[2]);
    return p[2] >= 0.0 && r2 < wall * wall && (p[2] > FINDER || r2 > CORE * CORE);
}

/* Fly a grain to its next wall or its end, and add the time. */
static place fly(grain *g)
{
    double end[6], middle[6], low = 0.0, high;
    for (;;) {
        const double *v = g->p + 3;
        if (g->p[2] >= HEIGHT)
            return COLLECTED;
        if (g->time >= TIME_LIMIT)
            return TIME_IS_UP;
        high = STEP / (sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) + 1.0);
        step(g->p, g->drag, high, end);
        if (!is_inside(end))
            break;
        memcpy(g->p, end, sizeof end);
        g->time += high;
    }
    double start[6];
    memcpy(start, g->p, sizeof start);
    for (int k = 0; k < 40; k++) { /* the last state inside, g->p, and the first outside, end */
        const double h = 0.5 * (low + high);
        step(start, g->drag, h, middle);
        const int inside = is_inside(middle);
        memcpy(inside ? g->p : end, middle, sizeof middle);
        *(inside ? &low : &high) = h;
    }
    g->time += low;
    if (end[2] < 0.0)
        return LID;
    if (end[2] <= FINDER && hypot(end[0], end[1]) <= CORE)
        return g->p[2] > FINDER ? ESCAPED : TUBE;
    return end[2] > CYLINDER ? CONE : BODY;
}

/* Find the normal of the wall where a grain is. Returns whether the grain comes to rest: its next hop would
   be lower than a hundredth of its diameter. */
static int rests(const grain *g, place wall, double n[3])
{
    const double r = hypot(g->p[0], g->p[1]), slope = wall == CONE ? SLOPE : 0.0, size = hypot(1.0, slope);
    const double out = wall == LID ? 0.0 : wall == TUBE ? 1.0 : -1.0 / size;
    const double around = (g->p[0] * g->p[4] - g->p[1] * g->p[3]) / r;
    double gas[3], slip[3];
    n[0] = out * g->p[0] / r;
    n[1] = out * g->p[1] / r;
    n[2] = wall == LID ? 1.0 : slope / size;
    const double rate = drag_rate(g->drag, g->p, gas, slip);
    const double away = rate * (slip[0] * n[0] + slip[1] * n[1] + slip[2] * n[2]);
    const double towards = -around * around * out / r - away - GRAVITY * n[2];
    const double into = -(g->p[3] * n[0] + g->p[4] * n[1] + g->p[5] * n[2]);
    return into <= 0.0 || into * into < 2.0 * towards * HOP * g->diameter;
}

/* Numbers between 0 and 1, spread evenly over the grains. */
static double fraction(double x) { return x - floor(x); }

/* Let grain k enter. Returns a code. */
static int enter(const rbt_table *table, size_t k)
{
    grain *g = &grains[k];
    double shape[3];
    index_of[k] = k;
    const int code = rbt_grains(table, 1, SEED, &index_of[k], NULL, shape);
    g->diameter = SMALLEST * pow(LARGEST / SMALLEST, fraction(0.8191725134 * (double)(k + 1)));
    g->p[0] = RADIUS - INLET_WIDTH * fraction(0.6710436067 * (double)(k + 1));
    g->p[2] = INLET_HEIGHT * fraction(0.5497004779 * (double)(k + 1));
    g->p[4] = INLET_SPEED;
    half_size[k] = rbt_half_size(table, g->diameter, shape);
    set_drag(g, rbt_sphericity(table, shape));
    return code;
}

static void move_grain(size_t from, size_t to)
{
    grains[to] = grains[from];
    memcpy(omega[to], omega[from], sizeof *omega);
    memcpy(velocity[to], velocity[from], sizeof *velocity);
    memcpy(normal[to], normal[from], sizeof *normal);
    half_size[to] = half_size[from];
    inertia[to] = inertia[from];
    index_of[to] = index_of[from];
    hit[to] = hit[from];
}

/* Fly `n` grains to their walls, let the gas slow down their spins, and keep those that will rebound. Returns
   how many these are, and adds to the number of grains that are collected. */
static size_t fly_all(size_t n, size_t *collected)
{
    for (size_t k = n; k-- > 0;) {
        grain *g = &grains[k];
        const double d = g->diameter, since = g->time;
        const double moment = inertia[k] * PI / 6.0 * DENSITY * d * d * d * half_size[k] * half_size[k];
        const place end = fly(g);
        const int rested = end <= TUBE && rests(g, end, normal[k]);
        if (hit[k] > 0)
            rbt_spin_after(omega[k], g->time - since, moment, d, GAS_DENSITY, VISCOSITY, NULL, omega[k]);
        memcpy(velocity[k], g->p + 3, sizeof *velocity);
        *collected += rested || end == COLLECTED;
        if (rested || end > TUBE)
            move_grain(--n, k);
    }
    return n;
}

/* Rebound n grains, some rows in a call. Returns an error, or the sum of all flags. */
static int rebound_all(const rbt_table *table, size_t n, size_t rows)
{
    int codes = RBT_OK;
    for (size_t k = 0; k < n && codes >= RBT_OK; k += rows) {
        rbt_impacts impact = {0};
        rbt_rebounds after = {0};
        impact.velocity = after.velocity = velocity[k];
        impact.omega = after.omega = omega[k];
        impact.inertia = after.inertia = &inertia[k];
        impact.normal = normal[k];
        impact.half_size = &half_size[k];
        impact.index = &index_of[k];
        impact.hit = &hit[k];
        const int code = rbt_rebound(table, n - k < rows ? n - k : rows, &impact, SEED, &after);
        codes = code < 0 ? code : codes | code;
    }
    for (size_t k = 0; k < n; k++) {
        memcpy(grains[k].p + 3, velocity[k], sizeof *velocity);
        hit[k]++;
    }
    return codes;
}

static double seconds(clock_t time) { return (double)time / CLOCKS_PER_SEC; }

int main(int argc, char **argv)
{
    const size_t n = argc == 4 ? strtoul(argv[2], NULL, 10) : 0;
    const size_t rows = argc == 4 ? strtoul(argv[3], NULL, 10) : 0;
    rbt_table *table;
    if (n < 1 || n > MOST || rows < 1) {
        fprintf(stderr, "usage: cyclone TABLE.rbt GRAINS ROWS\n");
        return 2;
    }
    int code = rbt_open(argv[1], &table);
#ifdef DIRECT
    if (code == RBT_OK)
        code = rbt_use_direct(table, &rebound_direct);
#endif
    for (size_t k = 0; k < n && code >= RBT_OK; k++)
        code = enter(table, k);
    size_t collected = 0, hits = 0;
    clock_t in_flights = 0, in_rebounds = 0;
    for (size_t inside = n; inside > 0 && code >= RBT_OK; hits += inside) {
        const clock_t start = clock();
        inside = fly_all(inside, &collected);
        const clock_t middle = clock();
        code = rebound_all(table, inside, rows);
        in_rebounds += clock() - middle;
        in_flights += middle - start;
    }
    if (code < 0) {
        fprintf(stderr, "%s: %s\n", argv[1], rbt_strerror(code));
        return 1;
    }
    printf("collected:       %.4f\n", (double)collected / (double)n);
    printf("hits a grain:    %.2f\n", (double)hits / (double)n);
    printf("flights, s:      %.2f\n", seconds(in_flights));
    printf("rebounds, s:     %.2f\n", seconds(in_rebounds));
    printf("one rebound, us: %.3f\n", 1e6 * seconds(in_rebounds) / (double)hits);
    rbt_close(table);
    return 0;
}
