/* The library that Python loads: the functions of the header, and what only Python needs.

   Units are those of the header. build.py compiles this file; sampler/library.py calls it. */

#include <stdio.h>
#include <stdlib.h>

#include "rebound_sampler.h"

/* Open an image as rbt_open_memory does, but without a checksum: Python has just made it from a table that it
   has checked. */
int rbt_open_image(const void *image, size_t size, rbt_table **table)
{
    return rbti_open(image, size, 0, table);
}

/* Open a table that has no law but direct simulation, with the variables `columns` in its states. */
int rbt_open_direct(const rbt_direct_law *law, size_t n_columns, const int8_t *columns,
                    rbt_table **table)
{
    rbt_table *opened = (rbt_table *)calloc(1, sizeof *opened);
    if (!opened)
        return RBT_ERR_NO_MEMORY;
    memcpy(opened->columns, columns, n_columns);
    opened->n_columns = (int32_t)n_columns;
    snprintf(opened->pair, sizeof opened->pair, "%s", law->pair);
    const int code = rbt_use_direct(opened, law);
    if (code != RBT_OK) {
        free(opened);
        return code;
    }
    *table = opened;
    return RBT_OK;
}

/* Simulate n rows as rbt_sample does, and write all RBT_DIRECT_VALUES numbers of each. */
int rbt_sample_all(const rbt_table *table, size_t n, const rbt_conditions *conditions,
                   uint64_t seed, double *values, int *codes)
{
    rbti_tally tally = {RBT_OK, RBT_OK};
    for (size_t first = 0, count = 0; first < n; first += count) {
        count = n - first < RBT_DIRECT_ROWS ? n - first : RBT_DIRECT_ROWS;
        rbti_simulate_rows(table, conditions, first, count, seed, seed,
                           values + RBT_DIRECT_VALUES * first, codes + first);
        rbti_count_codes(&tally, codes + first, count);
    }
    return rbti_result(&tally);
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
