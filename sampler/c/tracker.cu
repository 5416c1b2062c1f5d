/* Grains of corundum in a channel with two plates. A grain keeps its number, the number of walls that it
   has met, its spin, and the inertia about its spin. */
#define REBOUND_SAMPLER_IMPLEMENTATION /* in one file of a program */
#include "rebound_sampler.h"
#include "rebound_device.h"

#include <cstdio>

/* Normal of the wall that the next step crosses; false: none. Walls are the floor, the roof and two sides
   of each plate: x, y of an end, the normal into the gas, the length. */
static RBT_DEVICE bool wall_ahead(const double x[2], const double v[3], double dt, double normal[3])
{
    const double walls[6][6] = {
        {-9, 0, 0, 1, 0, 18},
        {9, 0.1, 0, -1, 0, 18},
        {0.1, 0, -0.8660254, 0.5, 0, 0.07},
        {0.135, 0.06062178, 0.8660254, -0.5, 0, 0.07},
        {0.235, 0.03937822, -0.8660254, -0.5, 0, 0.07},
        {0.2, 0.1, 0.8660254, 0.5, 0, 0.07},
    };
    bool found = false;
    for (const auto &wall : walls) {
        const double *n = wall + 2;
        const double from_x = x[0] - wall[0], from_y = x[1] - wall[1];
        const double away = n[0] * from_x + n[1] * from_y, along = n[1] * from_x - n[0] * from_y;
        const double approach = -(n[0] * v[0] + n[1] * v[1]);
        if (away >= 0 && away < dt * approach && along > 0 && along < wall[5]) {
            found = true;
            for (int i = 0; i < 3; i++)
                normal[i] = n[i];
        }
    }
    return found;
}

RBT_KERNEL follow(RBT_TABLE_ARGUMENT table, unsigned long long grains, double *sums)
{
    /* SI units: time step, gas, diameter, mass and largest half-size of a grain, its rate of drag */
    const double dt = 2e-5, gas[3] = {100, 0, 0}, density = 1.2, viscosity = 1.8e-5;
    const double diameter = 60e-6, mass = 4.5e-10, half_size = 0.63 * diameter;
    const double drag = 9.42477796 * viscosity * diameter / mass, share = -expm1(-drag * dt);
    RBT_EACH_ROW(k, grains)
    {
        double x[2] = {0, ((double)k + 0.5) * 5e-5}, v[3] = {100, 0, 0}, normal[3];
        double omega[3] = {0, 0, 0}, inertia = 0; /* mean spin, and over mass half_size^2; 0: not known */
        double flight = 0;                        /* time since the last wall */
        const uint64_t index = k;
        uint32_t hit = 0; /* number of walls that it has met */
        rbt_impacts before = {};
        before.velocity = v;
        before.normal = normal;
        before.half_size = &half_size;
        before.omega = omega;
        before.inertia = &inertia;
        before.index = &index;
        before.hit = &hit;
        rbt_rebounds after = {};
        after.velocity = v;
        after.omega = omega;
        after.inertia = &inertia;
        while (x[0] >= 0 && x[0] < 0.5) {
            for (int i = 0; i < 3; i++)
                v[i] += share * (gas[i] - v[i]);
            flight += dt;
            if (!wall_ahead(x, v, dt, normal)) {
                x[0] += dt * v[0];
                x[1] += dt * v[1];
                continue;
            }
            /* it rests where its next hop would be lower than a hundredth of its diameter, since the
               gas presses it to the wall */
            double pressure = 0; /* acceleration towards the wall */
            for (int i = 0; i < 3; i++)
                pressure -= normal[i] * (gas[i] - v[i]) * drag;
            const double slow = pressure > 0 ? sqrt(2 * pressure * 0.01 * diameter) : 0;
            if (rbt_deposits(v, normal, slow, nullptr))
                break;
            /* the torque of the gas over the whole flight: one call is exact */
            const double moment = inertia * mass * half_size * half_size;
            if (hit > 0)
                rbt_spin_after(omega, flight, moment, diameter, density, viscosity, nullptr, omega);
            if (rbt_rebound(&table, 1, &before, 7, &after) < 0)
                break;
            hit++;
            flight = 0;
        }
        const double moment = inertia * mass * half_size * half_size;
        if (hit > 0)
            rbt_spin_after(omega, flight, moment, diameter, density, viscosity, nullptr, omega);
        atomicAdd(sums, double(x[0] >= 0.5));
        atomicAdd(sums + 1, double(x[0] < 0));
        atomicAdd(sums + 2, double(hit));
        atomicAdd(sums + 3, v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        atomicAdd(sums + 4, omega[2]);
    }
}

int main()
{
    double sums[5] = {0, 0, 0, 0, 0};
    void *copy, *there;
    rbt_table *table, on_device;
    if (rbt_open("corundum-steel.rbt", &table) < 0 || rbt_to_device(table, &on_device, &copy) < 0)
        return 1;
    if (RBT_DEVICE_MALLOC(&there, sizeof sums) || RBT_DEVICE_COPY(there, sums, sizeof sums))
        return 1;
    RBT_LAUNCH(follow, 32, 64, on_device, 2000, static_cast<double *>(there));
    if (RBT_DEVICE_COPY(sums, there, sizeof sums))
        return 1;
    std::printf("%g %g %g %.12g %.12g\n", sums[0], sums[1], sums[2], sums[3], sums[4]);
    return 0;
}
