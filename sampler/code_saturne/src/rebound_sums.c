/* rebound_sums.c - sums and histograms over the particles that met each boundary face, since the
   start: fields that code_saturne writes with its own and reads at a restart.

   Part of rebound-tables; MIT licence. */

#include <math.h>
#include <stdio.h>

#include "cs_field.h"
#include "cs_math.h"
#include "cs_mesh_location.h"
#include "cs_post.h"
#include "cs_restart_default.h"

#include "rebound_wall.h"

enum { HITS, DEPOSITS, MASS, BEFORE, LOST, ANGLE, WORK_NORMAL, WORK_SHEAR, SUMS };

static const char *const names[SUMS] = {"rebound_hits",        "rebound_deposits",
                                        "rebound_mass",        "rebound_energy_before",
                                        "rebound_energy_lost", "rebound_angle_deg",
                                        "rebound_work_normal", "rebound_work_shear"};
static cs_field_t *sums[SUMS];

/* Hits by bin of the impact angle, from 0 to 90 degrees, and of the impact speed, from 0 to a limit,
   m/s; the last one has all faster hits as well. */
enum { BINS = 10 };
static cs_field_t *angles[BINS], *speeds[BINS];
static double most_speed;

static cs_field_t *make_field(const char *name)
{
    cs_field_t *field =
        cs_field_create(name, CS_FIELD_USER, CS_MESH_LOCATION_BOUNDARY_FACES, 1, false);
    cs_field_set_key_int(field, cs_field_key_id("post_vis"), CS_POST_ON_LOCATION);
    cs_field_set_key_int(field, cs_field_key_id("restart_file"), CS_RESTART_MAIN);
    return field;
}

void rebound_sums_make(int works)
{
    for (int i = 0; i < (works ? SUMS : WORK_NORMAL); i++)
        sums[i] = make_field(names[i]);
}

int rebound_sums_have_works(void)
{
    return sums[WORK_NORMAL] != NULL;
}

void rebound_histograms_make(double most)
{
    most_speed = most;
    for (int i = 0; i < BINS; i++) {
        char name[64];
        snprintf(name, sizeof name, "rebound_hits_of_angle_%d", i);
        angles[i] = make_field(name);
        snprintf(name, sizeof name, "rebound_hits_of_speed_%d", i);
        speeds[i] = make_field(name);
    }
}

static int bin(double value, double most)
{
    return (int)fmin(BINS * value / most, BINS - 1);
}

void rebound_sums_add(cs_lagr_particle_set_t *particles, cs_lnum_t p_id, cs_lnum_t face_id,
                      const double normal[3], const double before[3], const double after[3],
                      int stays, const double works[2])
{
    if (sums[HITS] == NULL && angles[0] == NULL)
        return;
    const double n = cs_lagr_particles_get_real(particles, p_id, CS_LAGR_STAT_WEIGHT);
    const double mass = n * cs_lagr_particles_get_real(particles, p_id, CS_LAGR_MASS);
    const double square = cs_math_3_dot_product(before, before);
    const double sine = -cs_math_3_dot_product(before, normal) / sqrt(square);
    const double angle = asin(sine < 1.0 ? sine : 1.0) * 180.0 / cs_math_pi;
    if (angles[0] != NULL) {
        angles[bin(angle, 90.0)]->val[face_id] += n;
        speeds[bin(sqrt(square), most_speed)]->val[face_id] += n;
    }
    if (sums[HITS] == NULL)
        return;
    sums[HITS]->val[face_id] += n;
    sums[DEPOSITS]->val[face_id] += stays ? n : 0.0;
    sums[MASS]->val[face_id] += mass;
    sums[BEFORE]->val[face_id] += 0.5 * mass * square;
    sums[LOST]->val[face_id] += 0.5 * mass * (square - cs_math_3_dot_product(after, after));
    double *mean = sums[ANGLE]->val + face_id;
    *mean += (angle - *mean) * n / sums[HITS]->val[face_id];
    for (int k = 0; k < 2 && sums[WORK_NORMAL] != NULL; k++)
        sums[WORK_NORMAL + k]->val[face_id] += mass * works[k];
}
