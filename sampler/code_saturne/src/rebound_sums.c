/* rebound_sums.c - sums over the particles that met each boundary face, since the start: fields that
   code_saturne writes with its own and reads at a restart.

   Part of rebound-tables; MIT licence. */

#include <math.h>

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

void rebound_sums_make(int works)
{
    for (int i = 0; i < (works ? SUMS : WORK_NORMAL); i++) {
        sums[i] = cs_field_create(names[i], CS_FIELD_USER, CS_MESH_LOCATION_BOUNDARY_FACES, 1, false);
        cs_field_set_key_int(sums[i], cs_field_key_id("post_vis"), CS_POST_ON_LOCATION);
        cs_field_set_key_int(sums[i], cs_field_key_id("restart_file"), CS_RESTART_MAIN);
    }
}

void rebound_sums_add(cs_lagr_particle_set_t *particles, cs_lnum_t p_id, cs_lnum_t face_id,
                      const double normal[3], const double before[3], const double after[3],
                      int stays, const double works[2])
{
    if (sums[HITS] == NULL)
        return;
    const double n = cs_lagr_particles_get_real(particles, p_id, CS_LAGR_STAT_WEIGHT);
    const double mass = n * cs_lagr_particles_get_real(particles, p_id, CS_LAGR_MASS);
    const double square = cs_math_3_dot_product(before, before);
    const double sine = -cs_math_3_dot_product(before, normal) / sqrt(square);
    const double angle = asin(sine < 1.0 ? sine : 1.0) * 180.0 / cs_math_pi;
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
