/* cs_user_box.c - user functions of the box: gas at rest, particles that fly freely from wall to
   wall, and files of records, which box_run.py reads.

   box.txt: time steps in all, length of one [s], particles to inject, 1 to go on from a restart,
   1 for symmetry planes at both ends in x, 2 at all four sides. */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cs_defs.h"

#include "bft_error.h"
#include "cs_base.h"
#include "cs_boundary_zone.h"
#include "cs_field.h"
#include "cs_lagr_prototypes.h"
#include "cs_math.h"
#include "cs_mesh.h"
#include "cs_mesh_location.h"
#include "cs_mesh_quantities.h"
#include "cs_parameters.h"
#include "cs_prototypes.h"
#include "cs_time_step.h"
#include "cs_turbulence_model.h"
#include "cs_volume_zone.h"

#include "rebound_wall.h"

#pragma GCC diagnostic ignored "-Wunused-parameter"

#define CONDITIONS 6

/* Impact angles [deg] and speeds [m/s] of the first hit: CONDITIONS of box_run.py. */
static const double conditions[CONDITIONS][2] = {{5, 280},  {15, 75},  {30, 150},
                                                 {45, 250}, {60, 100}, {90, 200}};

static int steps, particles_in, restart, symmetry;
static double step_length;

static void read_box(void)
{
    FILE *file = fopen("box.txt", "r");
    if (file == NULL || fscanf(file, "%d %lf %d %d %d", &steps, &step_length, &particles_in,
                               &restart, &symmetry) != 5)
        bft_error(__FILE__, __LINE__, 0, "box.txt: got no five numbers");
    fclose(file);
}

/* Append a record to a file of this process. */
static void record(const char *name, const double *values, int count)
{
    char path[64];
    snprintf(path, sizeof path, "%s.%d.bin", name, CS_MAX(cs_glob_rank_id, 0));
    FILE *file = fopen(path, "ab");
    if (file == NULL || fwrite(values, sizeof *values, (size_t)count, file) != (size_t)count)
        bft_error(__FILE__, __LINE__, 0, "%s: cannot be written", path);
    fclose(file);
}

static double *kept_of(cs_lagr_particle_set_t *particles, cs_lnum_t p_id)
{
    return (cs_real_t *)cs_lagr_particles_attr(particles, p_id, CS_LAGR_USER) +
           rebound_wall_attribute();
}

/* What a particle keeps, its place and its velocity. */
static void record_particle(const char *name, cs_lagr_particle_set_t *particles, cs_lnum_t p_id)
{
    double values[REBOUND_ATTRIBUTES + 6];
    memcpy(values, kept_of(particles, p_id), REBOUND_ATTRIBUTES * sizeof *values);
    memcpy(values + REBOUND_ATTRIBUTES, cs_lagr_particles_attr(particles, p_id, CS_LAGR_COORDS),
           3 * sizeof *values);
    memcpy(values + REBOUND_ATTRIBUTES + 3,
           cs_lagr_particles_attr(particles, p_id, CS_LAGR_VELOCITY), 3 * sizeof *values);
    record(name, values, REBOUND_ATTRIBUTES + 6);
}

void cs_user_zones(void)
{
    read_box();
    if (symmetry)
        cs_boundary_zone_define("symmetry",
                                symmetry == 1 ? "x < -0.3999 or x > 0.3999"
                                              : "x < -0.3999 or x > 0.3999 or "
                                                "z < -0.3999 or z > 0.3999",
                                0);
}

void cs_user_model(void)
{
    cs_turb_model_t *turbulence = cs_get_glob_turb_model();
    read_box();
    turbulence->iturb = CS_TURB_NONE;
}

void cs_user_parameters(cs_domain_t *domain)
{
    cs_time_step_t *time = cs_get_glob_time_step();
    time->nt_max = steps;
    time->dt_ref = step_length;
}

void cs_user_lagr_model(void)
{
    cs_glob_lagr_time_scheme->iilagr = CS_LAGR_ONEWAY_COUPLING;
    cs_glob_lagr_time_scheme->isuila = restart;
    cs_glob_lagr_stat_options->isuist = restart;
    cs_glob_lagr_time_scheme->t_order = 1;
    cs_glob_lagr_time_scheme->idistu = 0;
    cs_glob_lagr_boundary_interactions->has_part_impact_nbr = 1;
    rebound_wall_model();
}

void cs_user_lagr_boundary_conditions(const int bc_type[])
{
    cs_lagr_zone_data_t *zones = cs_lagr_get_boundary_conditions();
    for (int zone = 0; zone < zones->n_zones; zone++)
        zones->zone_type[zone] = zone == 0 ? CS_LAGR_REBOUND : CS_LAGR_SYM;
    rebound_wall_zones();
}

/* Once, anywhere in the box. */
void cs_user_lagr_volume_conditions(void)
{
    cs_lagr_injection_set_t *set = cs_lagr_get_injection_set(cs_lagr_get_volume_conditions(), 0, 0);
    set->n_inject = particles_in;
    set->injection_frequency = 0;
    set->velocity_profile = 1;
    memset(set->velocity, 0, sizeof set->velocity);
    set->stat_weight = 1.0;
    set->diameter = 50e-6;
    set->diameter_variance = 0.0;
    set->density = 3950.0;
}

/* Towards the floor or the lid, with one of the conditions, in any direction along the wall. */
void cs_user_lagr_in(cs_lagr_particle_set_t *particles, const cs_lagr_injection_set_t *zis,
                     const cs_lnum_t particle_range[2], const cs_lnum_t particle_face_id[],
                     const cs_real_t visc_length[])
{
    rebound_wall_new(particles, particle_range);
    for (cs_lnum_t p = particle_range[0]; p < particle_range[1]; p++) {
        const int number = (int)kept_of(particles, p)[REBOUND_NUMBER];
        const double *condition = conditions[number % CONDITIONS];
        const double alpha = condition[0] * cs_math_pi / 180.0;
        const double along = condition[0] < 89.0 ? condition[1] * cos(alpha) : 0.0;
        const double azimuth = 2.0 * cs_math_pi * fmod(0.6180339887498949 * number, 1.0);
        cs_real_t *velocity = cs_lagr_particles_attr(particles, p, CS_LAGR_VELOCITY);
        velocity[0] = along * cos(azimuth);
        velocity[1] = (number / CONDITIONS % 2 ? 1.0 : -1.0) * condition[1] * sin(alpha);
        velocity[2] = along * sin(azimuth);
        record_particle("start", particles, p);
    }
}

/* No drag within the box's time. */
void cs_user_lagr_rt(cs_lnum_t id_p, cs_real_t re_p, cs_real_t uvwr, cs_real_t rho_f,
                     cs_real_t rho_p, cs_real_t nu_f, cs_real_t taup[], const cs_real_t dt[])
{
    taup[id_p] = 1e5;
}

void cs_user_lagr_sde(const cs_real_t dt[], cs_real_t taup[], cs_real_3_t tlag[],
                      cs_real_t tempct[])
{
    rebound_wall_flight();
}

/* What a particle keeps, place, velocity before, normal into the gas; velocity, spin and inertia
   after. */
void cs_lagr_user_boundary_interaction(cs_lagr_particle_set_t *particles, cs_lnum_t p_id,
                                       cs_lnum_t face_id, const cs_real_t face_norm[3],
                                       const cs_real_t c_intersect[3], cs_real_t t_intersect,
                                       int b_zone_id, int *event_flag,
                                       cs_lagr_tracking_state_t *tracking_state)
{
    double values[REBOUND_ATTRIBUTES + 16];
    double *next = values;
    const cs_real_t *velocity = cs_lagr_particles_attr(particles, p_id, CS_LAGR_VELOCITY);
    const cs_real_t *outwards = cs_glob_mesh_quantities->b_face_normal + 3 * face_id;
    double *kept = kept_of(particles, p_id);
    memcpy(next, kept, REBOUND_ATTRIBUTES * sizeof *next);
    memcpy(next += REBOUND_ATTRIBUTES, c_intersect, 3 * sizeof *next);
    memcpy(next += 3, velocity, 3 * sizeof *next);
    next += 3;
    for (int k = 0; k < 3; k++)
        next[k] = -outwards[k] / cs_math_3_norm(outwards);
    rebound_wall_interaction(particles, p_id, face_id, face_norm, c_intersect, t_intersect,
                             b_zone_id, event_flag, tracking_state);
    memcpy(next += 3, velocity, 3 * sizeof *next);
    memcpy(next += 3, kept + REBOUND_OMEGA, 3 * sizeof *next);
    next[3] = kept[REBOUND_INERTIA];
    if (*event_flag != 0) /* a wall, no symmetry plane */
        record("hits", values, REBOUND_ATTRIBUTES + 16);
}

/* Centres of boundary faces, sums and histograms, 0 where there are none. */
static void record_faces(void)
{
    static const char *const names[8] = {"hits",        "deposits",  "mass",        "energy_before",
                                         "energy_lost", "angle_deg", "work_normal", "work_shear"};
    for (cs_lnum_t face = 0; face < cs_glob_mesh->n_b_faces; face++) {
        double values[3 + 8 + 20];
        char name[64];
        memcpy(values, cs_glob_mesh_quantities->b_face_cog + 3 * face, 3 * sizeof *values);
        for (int k = 0; k < 8; k++) {
            snprintf(name, sizeof name, "rebound_%s", names[k]);
            const cs_field_t *sums = cs_field_by_name_try(name);
            values[3 + k] = sums == NULL ? 0.0 : sums->val[face];
        }
        for (int k = 0; k < 20; k++) {
            snprintf(name, sizeof name, "rebound_hits_of_%s_%d", k < 10 ? "angle" : "speed", k % 10);
            const cs_field_t *hits = cs_field_by_name_try(name);
            values[11 + k] = hits == NULL ? 0.0 : hits->val[face];
        }
        record("faces", values, 31);
    }
}

void cs_user_lagr_extra_operations(const cs_real_t dt[])
{
    cs_lagr_particle_set_t *particles = cs_glob_lagr_particle_set;
    rebound_wall_log();
    if (cs_glob_time_step->nt_cur != cs_glob_time_step->nt_max)
        return;
    if (cs_field_by_name_try("rebound_hits") != NULL)
        record_faces();
    for (cs_lnum_t p = 0; p < particles->n_particles; p++)
        record_particle("end", particles, p);
}
