/* cs_user_lagr_rebound.c - user functions of code_saturne 6.0 that hand over to rebound_wall.h.

   A case that defines one of these functions elsewhere takes it out here, and calls there what it
   calls here. Part of rebound-tables; MIT licence. */

#include "cs_defs.h"

#include "cs_lagr_prototypes.h"

#include "rebound_wall.h"

#pragma GCC diagnostic ignored "-Wunused-parameter"

void cs_user_lagr_model(void)
{
    rebound_wall_model();
}

/* Zones have the types that the graphical interface gave them. */
void cs_user_lagr_boundary_conditions(const int bc_type[])
{
    rebound_wall_zones();
}

void cs_user_lagr_in(cs_lagr_particle_set_t *particles, const cs_lagr_injection_set_t *zis,
                     const cs_lnum_t particle_range[2], const cs_lnum_t particle_face_id[],
                     const cs_real_t visc_length[])
{
    rebound_wall_new(particles, particle_range);
}

void cs_user_lagr_sde(const cs_real_t dt[], cs_real_t taup[], cs_real_3_t tlag[],
                      cs_real_t tempct[])
{
    rebound_wall_flight();
}

void cs_lagr_user_boundary_interaction(cs_lagr_particle_set_t *particles, cs_lnum_t p_id,
                                       cs_lnum_t face_id, const cs_real_t face_norm[3],
                                       const cs_real_t c_intersect[3], cs_real_t t_intersect,
                                       int b_zone_id, int *event_flag,
                                       cs_lagr_tracking_state_t *tracking_state)
{
    rebound_wall_interaction(particles, p_id, face_id, face_norm, c_intersect, t_intersect,
                             b_zone_id, event_flag, tracking_state);
}

void cs_user_lagr_extra_operations(const cs_real_t dt[])
{
    rebound_wall_log();
}
