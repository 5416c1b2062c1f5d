/* Every function with arguments that its documentation allows, while floating-point exceptions end the
   program, as flow codes let them: invalid operations, divisions by zero, overflows.

       traps TABLE.rbt   prints the number of calls

   Compiled with DIRECT, the table uses direct simulation. */

#define _GNU_SOURCE
#define REBOUND_SAMPLER_IMPLEMENTATION
#include "rebound_sampler.h"
#ifdef DIRECT
#include "rebound_direct.h"
#endif

#include <fenv.h>
#include <math.h>
#include <stdio.h>

static size_t calls;

static void count(int code)
{
    calls += code != RBT_ERR_MISSING;
}

static void flights(void)
{
    const double rest[3] = {0.0, 0.0, 0.0}, spins[] = {0.0, 1e-9, 1.0, 1e5, 1e8};
    const double viscosities[] = {0.0, 1e-9, 1.8e-5}, times[] = {0.0, 1e-9, 1.0, 1e6, -1e-9, -1.0, -1e6};
    double out[3];
    for (size_t k = 0; k < 5; k++)
        for (size_t j = 0; j < 3; j++) {
            const double omega[3] = {spins[k], 0.0, -0.5 * spins[k]};
            rbt_gas_torque(omega, 2e-5, 1.2, viscosities[j], NULL, out);
            rbt_gas_torque(rest, 2e-5, 1.2, viscosities[j], omega, out);
            for (size_t i = 0; i < 7; i++, calls += 2) {
                rbt_spin_after(omega, times[i], 5e-22, 2e-5, 1.2, viscosities[j], NULL, out);
                rbt_spin_after(rest, times[i], 5e-22, 2e-5, 1.2, viscosities[j], omega, out);
            }
        }
}

static void walls(void)
{
    const double vectors[][3] = {{0.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {3.0, -4.0, 1e-9}, {NAN, 0.0, 0.0}};
    const double lengths[] = {0.0, 2.0, 2.5, 60.0, -1.0};
    double tilt;
    for (int k = 0; k < 4; k++)
        for (int j = 0; j < 3; j++, calls += 2) {
            rbt_deposits(vectors[k], vectors[j], 0.1, NULL);
            rbt_deposits(vectors[j], vectors[2], 0.0, vectors[j]);
        }
    for (int k = 0; k < 625; k++)
        count(rbt_wall_tilt(lengths[k % 5], lengths[k / 5 % 5], lengths[k / 25 % 5], lengths[k / 125], &tilt));
    for (int k = 0; k < 5; k++, calls += 2) {
        rbt_critical_speed(1e-5 * lengths[k], 2650.0, 95e9 * lengths[k], 0.1, 200e9, 0.3);
        rbt_critical_speed_at(1e-5, 0.1, 1e-6 * lengths[k]);
    }
}

static void faces(void)
{
    double sum[RBT_FACE_SUMS] = {0.0}, *sums[RBT_FACE_SUMS];
    const double speeds[] = {1e-9, 30.0};
    for (int k = 0; k < RBT_FACE_SUMS; k++)
        sums[k] = sum + k;
    for (int k = 0; k < 12; k++, calls += 3) {
        const rbt_face_hit hit = {k / 6 ? 1e5 : 0.0, 1e-12, {k % 3 ? 0.0 : 9.0, -speeds[k & 1], 0.0},
                                  {0.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0}, k & 1};
        rbt_add_face_hit(&hit, sums);
        rbt_angle_bin(&hit);
        rbt_speed_bin(&hit, 300.0);
    }
}

static void sizes(const rbt_table *table)
{
    for (uint64_t index = 0; index < 200; index++, calls += 4) {
        double grain[3];
        if (rbt_grains(table, 1, 7, &index, NULL, grain) != RBT_OK)
            return;
        const double mass = 1e-11, half_size = rbt_half_size(table, 2e-5, grain);
        rbt_moment_of_inertia(table, 7, index, index & 1 ? 0.3 : 0.0, mass, half_size, 2e-5);
        rbt_mean_inertia(table, grain);
        rbt_sphericity(table, grain);
        grain[0] = 99.0;
        rbt_sphericity(table, grain);
    }
    rbt_mean_half_size(table, 2e-5);
}

/* Draws of every kind, the conditions that are refused among them. */
static void draws(const rbt_table *table)
{
    const double angles[] = {0.0, 1e-9, 0.1, 0.7, 1.5707963267948966, 2.0};
    const double speeds[] = {-1.0, 0.0, 1e-9, 3.9, 120.0, 1e9}, sizes_of_spin[] = {0.0, 1e-9, 0.5, 99.0};
    enum { N = 6 * 6 * 4 };
    static double alpha1[N], speed[N], spin[3 * N], inertia[N], after[N], states[RBT_VALUES * N];
    static uint64_t index[N];
    static uint32_t hit[N];
    int codes[N];
    for (int k = 0; k < N; k++) {
        index[k] = (uint64_t)k;
        hit[k] = (uint32_t)k % 5;
        alpha1[k] = angles[k % 6];
        speed[k] = speeds[k / 6 % 6];
        spin[3 * k] = 0.3 * (spin[3 * k + 2] = sizes_of_spin[k / 36]);
        inertia[k] = k % 7 ? 0.0 : 0.3;
    }
    for (int kind = 0; kind < 4; kind++)
        for (int one_by_one = 0; one_by_one < 2; one_by_one++)
            for (size_t k = 0; k < (one_by_one ? N : 1); k++) {
                rbt_conditions conditions = {0};
                conditions.alpha1 = alpha1 + k;
                conditions.speed = speed + k;
                conditions.index = index + k;
                conditions.hit = hit + k;
                conditions.fresh = kind & 1;
                if (kind & 2) {
                    conditions.spin = spin + 3 * k;
                    conditions.inertia = inertia + k;
                    conditions.inertia_after = after;
                }
                count(rbt_sample(table, one_by_one ? 1 : N, &conditions, 7, states, codes));
            }
}

static void rebounds(const rbt_table *table)
{
    const double speeds[] = {0.0, 1e-9, 3.9, 120.0}, spins[] = {0.0, 1e-3, 1e5, 1e9};
    const double normals[][3] = {{0.0, 1.0, 0.0}, {0.0, 0.0, 0.0}, {1e-3, 2e-3, -3e-3}, {0.0, -2.0, 0.0}};
    const double directions[][3] = {{0.0, -1.0, 0.0}, {0.8, -0.6, 0.0}, {1.0, -1e-9, 0.0}, {1.0, 0.0, 0.0}};
    enum { N = 256 };
    static double velocity[3 * N], normal[3 * N], half_size[N], omega[3 * N], inertia[N], roughness[N];
    static double wall[3 * N];
    static uint64_t index[N];
    static uint32_t hit[N];
    int codes[N];
    for (int pass = 0; pass < 16; pass++)
        for (int one_by_one = 0; one_by_one < 2; one_by_one++)
            for (size_t k = 0; k < (one_by_one ? N : 1); k++) {
                for (int j = 0; j < N; j++) {
                    index[j] = (uint64_t)j;
                    hit[j] = (uint32_t)j % 3;
                    half_size[j] = j % 50 ? 1e-5 : 0.0;
                    inertia[j] = j % 3 ? 0.0 : 0.3;
                    roughness[j] = j % 5 ? 0.1 : 0.0;
                    for (int i = 0; i < 3; i++) {
                        velocity[3 * j + i] = speeds[j / 4 % 4] * directions[j % 4][i];
                        normal[3 * j + i] = normals[j / 16 % 4][i];
                        omega[3 * j + i] = i == 1 ? 0.0 : spins[j / 64];
                        wall[3 * j + i] = 0.0;
                    }
                }
                rbt_impacts impacts = {0};
                impacts.velocity = velocity + 3 * k;
                impacts.normal = normal + 3 * k;
                impacts.half_size = half_size + k;
                impacts.index = index + k;
                impacts.hit = hit + k;
                impacts.fresh = pass & 1;
                impacts.isotropic = pass & 1;
                if (pass & 2) {
                    impacts.omega = omega + 3 * k;
                    impacts.inertia = inertia + k;
                }
                impacts.roughness = pass & 4 ? roughness + k : NULL;
                impacts.wall_velocity = pass & 8 ? wall + 3 * k : NULL;
                rbt_rebounds after = {0};
                after.velocity = velocity + 3 * k;
                after.omega = omega + 3 * k;
                after.inertia = inertia + k;
                after.codes = codes;
                count(rbt_rebound(table, one_by_one ? 1 : N, &impacts, 7, &after));
            }
}

int main(int argc, char **argv)
{
    rbt_table *table;
    rbt_range range;
    if (argc != 2 || rbt_open(argv[1], &table) != RBT_OK)
        return 1;
#ifdef DIRECT
    if (rbt_use_direct(table, &rebound_direct) != RBT_OK)
        return 1;
#endif
    feenableexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW);
    count(rbt_covered(table, &range));
    rbt_highest_speed(table);
    flights();
    walls();
    faces();
    sizes(table);
    draws(table);
    rebounds(table);
    printf("%zu\n", calls);
    rbt_close(table);
    return 0;
}
