/* Grains of corundum in a channel with two plates: each keeps its number, its hits and its spin. */
#define REBOUND_SAMPLER_IMPLEMENTATION /* in one file of a program */
#include "rebound_sampler.h"
#include <stdio.h>
/* SI units: time step, gas, diameter and mass of a grain */
static const double dt = 2e-5, gas[3] = {100, 0, 0}, rho = 1.2, mu = 1.8e-5, d = 60e-6, m = 4.5e-10;
/* floor, roof, two sides of each plate: x, y of an end, the normal into the gas, the length */
static const double walls[6][6] = {{-9, 0, 0, 1, 0, 18}, {9, 0.1, 0, -1, 0, 18},
    {0.1, 0, -0.8660254, 0.5, 0, 0.07}, {0.135, 0.06062178, 0.8660254, -0.5, 0, 0.07},
    {0.235, 0.03937822, -0.8660254, -0.5, 0, 0.07}, {0.2, 0.1, 0.8660254, 0.5, 0, 0.07}};

int main(void)
{
    const double share = 1 - exp(-9.42477796 * mu * d * dt / m), a = 0.63 * d;
    double energy = 0, spin = 0, passed = 0, back = 0, hits = 0, flagged = 0;
    double v[3], omega[3], inertia;
    uint64_t index = 0; uint32_t hit = 0; /* number of the grain, and of walls that it has met */
    static rbt_impacts met; static rbt_rebounds after; /* fields that stay 0 are "none" */
    met.velocity = after.velocity = v, met.omega = after.omega = omega, met.index = &index;
    met.inertia = after.inertia = &inertia, met.half_size = &a, met.hit = &hit;
    rbt_table *table; int code = rbt_open("corundum-steel.rbt", &table);
    for (; index < 2000 && code >= RBT_OK; index++) {
        double x[2] = {0, ((double)index + 0.5) * 5e-5}, time = 0; /* since the last wall */
        inertia = 0.4; /* that of a grain at rest has no effect */
        for (int k = 0; k < 3; k++) v[k] = gas[k], omega[k] = 0;
        for (hit = 0; x[0] >= 0 && x[0] < 0.5 && code >= RBT_OK;) {
            for (int k = 0; k < 3; k++) v[k] += share * (gas[k] - v[k]);
            time += dt;
            const double *n = NULL; /* normal of a wall that the next step crosses */
            for (const double *w = *walls; w < *walls + 36; w += 6) {
                const double p = x[0] - w[0], q = x[1] - w[1], away = w[2] * p + w[3] * q;
                const double along = w[3] * p - w[2] * q, in = -w[2] * v[0] - w[3] * v[1];
                if (away >= 0 && away < dt * in && along > 0 && along < w[5]) n = w + 2;
            }
            if (n && n[0] * v[0] + n[1] * v[1] > -1) break; /* m/s: it rests, instead of hops */
            if (!n) { x[0] += dt * v[0], x[1] += dt * v[1]; continue; }
            rbt_spin_after(omega, time, inertia * m * a * a, d, rho, mu, NULL, omega); /* the gas */
            met.normal = n, code = rbt_rebound(table, 1, &met, 7, &after), hit++, time = 0;
            flagged += code > RBT_OK; /* outside the table, or of the measured speeds */
        }
        passed += x[0] >= 0.5, back += x[0] < 0, hits += hit, spin += omega[2];
        energy += v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    }
    printf("%g %g %g %.12g %.12g %g\n", passed, back, hits, energy, spin, flagged);
    return code < RBT_OK ? puts(rbt_strerror(code)) : (rbt_close(table), 0);
}
