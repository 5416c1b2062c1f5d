/* rebound_sums.c - sums and histograms over the particles that met each boundary face since the start.

   They are fields, which code_saturne writes with its own and reads at a restart. rebound_sampler.h adds the
   hits. Part of rebound-tables; MIT licence. */

#include <stdio.h>

#include "cs_field.h"
#include "cs_mesh_location.h"
#include "cs_post.h"
#include "cs_restart_default.h"

#include "rebound_sampler.h"

#include "rebound_wall.h"

/* Names of the sums of rbt_add_face_hit, in their order. */
static const char *const names[RBT_FACE_SUMS] = {
    "rebound_hits",          "rebound_deposits",    "rebound_mass",
    "rebound_energy_before", "rebound_energy_lost", "rebound_angle_deg",
    "rebound_work_normal",   "rebound_work_shear",
};
static cs_field_t *sums[RBT_FACE_SUMS];

static cs_field_t *angles[RBT_FACE_BINS], *speeds[RBT_FACE_BINS];
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
    for (int k = 0; k < (works ? RBT_FACE_SUMS : RBT_FACE_WORK_NORMAL); k++)
        sums[k] = make_field(names[k]);
}

int rebound_sums_have_works(void)
{
    return sums[RBT_FACE_WORK_NORMAL] != NULL;
}

void rebound_histograms_make(double most)
{
    most_speed = most;
    for (int k = 0; k < RBT_FACE_BINS; k++) {
        char name[64];
        snprintf(name, sizeof name, "rebound_hits_of_angle_%d", k);
        angles[k] = make_field(name);
        snprintf(name, sizeof name, "rebound_hits_of_speed_%d", k);
        speeds[k] = make_field(name);
    }
}

void rebound_sums_add(cs_lnum_t face_id, const rbt_face_hit *hit)
{
    double *face[RBT_FACE_SUMS];
    for (int k = 0; k < RBT_FACE_SUMS; k++)
        face[k] = sums[k] == NULL ? NULL : sums[k]->val + face_id;
    rbt_add_face_hit(hit, face);
    if (angles[0] != NULL) {
        angles[rbt_angle_bin(hit)]->val[face_id] += hit->number;
        speeds[rbt_speed_bin(hit, most_speed)]->val[face_id] += hit->number;
    }
}
