/* The library that Python loads: the functions of the header, and what only Python needs.

   Units are those of the header. build.py compiles this file; sampler/library.py calls it. */

#include "rebound_sampler.h"

/* Open an image as rbt_open_memory does, but without a checksum: Python has just made it from a table that it
   has checked. */
int rbt_open_image(const void *image, size_t size, rbt_table **table)
{
    return rbti_open(image, size, 0, table);
}

/* -- functions of one particle, called for n particles ---------------------------------------------

   Arrays have n numbers, or 3 n if they are vectors or grains, or 4 n if they are geometries. */

void rbt_gas_torque_rows(size_t n, const double *omega, const double *diameter,
                         const double *density, const double *viscosity,
                         const double *gas_rotation, double *torque)
{
    for (size_t k = 0; k < n; k++)
        rbt_gas_torque(omega + 3 * k, diameter[k], density[k], viscosity[k], gas_rotation + 3 * k,
                       torque + 3 * k);
}

void rbt_spin_after_rows(size_t n, const double *omega, const double *time, const double *moment,
                         const double *diameter, const double *density, const double *viscosity,
                         const double *gas_rotation, double *new_omega)
{
    for (size_t k = 0; k < n; k++)
        rbt_spin_after(omega + 3 * k, time[k], moment[k], diameter[k], density[k], viscosity[k],
                       gas_rotation + 3 * k, new_omega + 3 * k);
}

void rbt_half_size_rows(size_t n, const double *geometry, const double *diameter,
                        const double *grain, double *half_size)
{
    for (size_t k = 0; k < n; k++)
        half_size[k] = rbti_half_size(geometry + 4 * k, diameter[k], grain + 3 * k);
}

void rbt_mean_inertia_rows(size_t n, const double *geometry, const double *grain, double *inertia)
{
    for (size_t k = 0; k < n; k++)
        inertia[k] = rbti_inertia(geometry + 4 * k, grain + 3 * k);
}

void rbt_sphericity_rows(size_t n, const double *geometry, const double *grain,
                         double *sphericity)
{
    for (size_t k = 0; k < n; k++)
        sphericity[k] = rbti_sphericity(geometry + 4 * k, grain + 3 * k);
}

void rbt_deposits_rows(size_t n, const double *velocity, const double *normal,
                       const double *critical_speed, const double *wall_velocity, uint8_t *stays)
{
    for (size_t k = 0; k < n; k++)
        stays[k] = (uint8_t)rbt_deposits(velocity + 3 * k, normal + 3 * k, critical_speed[k],
                                         wall_velocity + 3 * k);
}

void rbt_critical_speed_rows(size_t n, const double *diameter, const double *density,
                             const double *young, const double *poisson, const double *wall_young,
                             const double *wall_poisson, double *speed)
{
    for (size_t k = 0; k < n; k++)
        speed[k] = rbt_critical_speed(diameter[k], density[k], young[k], poisson[k], wall_young[k],
                                      wall_poisson[k]);
}

/* Tilts; NaN if rbt_wall_tilt refuses the lengths of a row. */
void rbt_wall_tilt_rows(size_t n, const double *ra, const double *rq, const double *rsm,
                        const double *diameter, double *tilt)
{
    for (size_t k = 0; k < n; k++)
        if (rbt_wall_tilt(ra[k], rq[k], rsm[k], diameter[k], tilt + k) != RBT_OK)
            tilt[k] = NAN;
}
