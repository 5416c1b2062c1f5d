/* Grains of corundum in a channel with two plates: each keeps its number, its hits and its spin. */
#define REBOUND_SAMPLER_IMPLEMENTATION /* in one file of a program */
#include "rebound_sampler.h"
#include "rebound_device.h"
#include <cstdio>
RBT_KERNEL follow(RBT_TABLE_ARGUMENT table, unsigned long long grains, double *sums) {
    const double s = 0.8660254, walls[6][6] = {{-9, 0, 0, 1, 0, 18}, {9, 0.1, 0, -1, 0, 18},
        {0.1, 0, -s, 0.5, 0, 0.07}, {0.135, 0.06062178, s, -0.5, 0, 0.07},
        {0.235, 0.03937822, -s, -0.5, 0, 0.07}, {0.2, 0.1, s, 0.5, 0, 0.07}}; /* x, y, n, length */
    const double gas[3] = {100, 0, 0}, rho = 1.2, mu = 1.8e-5, d = 60e-6, m = 4.5e-10, dt = 2e-5;
    const double share = -expm1(-9.42477796 * mu * d * dt / m), half_size = 0.63 * d;
    RBT_EACH_ROW(k, grains) {
        double x[2] = {0, ((double)k + 0.5) * 5e-5}, v[3] = {100, 0, 0}, omega[3] = {0, 0, 0};
        double inertia = 0.4, time = 0; /* that of a grain at rest has no effect */
        const uint64_t index = k; uint32_t hit = 0; /* walls that it has met */
        rbt_impacts of = {}; of.velocity = v, of.omega = omega, of.half_size = &half_size;
        of.index = &index, of.hit = &hit; rbt_rebounds to = {}; to.velocity = v, to.omega = omega;
        of.inertia = to.inertia = &inertia;
        for (int code = RBT_OK; x[0] >= 0 && x[0] < 0.5 && code >= RBT_OK;) {
            for (int i = 0; i < 3; i++) v[i] += share * (gas[i] - v[i]);
            time += dt;
            const double *n = nullptr; /* normal of a wall that the next step crosses */
            for (const auto &w : walls) {
                const double a = x[0] - w[0], b = x[1] - w[1], away = w[2] * a + w[3] * b;
                const double along = w[3] * a - w[2] * b, in = -w[2] * v[0] - w[3] * v[1];
                if (away >= 0 && away < dt * in && along > 0 && along < w[5]) n = w + 2;
            }
            if (n && n[0] * v[0] + n[1] * v[1] > -1) break; /* m/s: it rests, instead of hops */
            if (!n) { x[0] += dt * v[0], x[1] += dt * v[1]; continue; }
            rbt_spin_after(omega, time, inertia * m * half_size * half_size, d, rho, mu, nullptr, omega);
            of.normal = n, code = rbt_rebound(&table, 1, &of, 7, &to), hit++, time = 0;
        }
        atomicAdd(sums, double(x[0] >= 0.5)), atomicAdd(sums + 1, double(x[0] < 0));
        atomicAdd(sums + 2, double(hit)), atomicAdd(sums + 4, omega[2]);
        atomicAdd(sums + 3, v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    }
}
int main() {
    double to[5] = {0, 0, 0, 0, 0}; void *copy, *there; rbt_table *table, on_device;
    if (rbt_open("corundum-steel.rbt", &table) < 0 || rbt_to_device(table, &on_device, &copy) < 0 ||
        RBT_DEVICE_MALLOC(&there, sizeof to) || RBT_DEVICE_COPY(there, to, sizeof to)) return 1;
    RBT_LAUNCH(follow, 32, 64, on_device, 2000, static_cast<double *>(there));
    return RBT_DEVICE_COPY(to, there, sizeof to) ||
           std::printf("%g %g %g %.12g %.12g\n", to[0], to[1], to[2], to[3], to[4]) < 0;
}
