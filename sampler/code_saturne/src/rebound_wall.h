/* rebound_wall.h - wall rebounds of non-spherical particles in code_saturne 6.0, from a table.

   How to use it: README.md. cs_user_lagr_rebound.c hands over to the functions below; a case that
   has one of these user functions already calls ours there instead.

   Part of rebound-tables; MIT licence. */

#ifndef REBOUND_WALL_H
#define REBOUND_WALL_H

#include <stdint.h>

#include "cs_lagr.h"
#include "cs_lagr_particle.h"
#include "cs_lagr_tracking.h"

/* User attributes (doubles) of a particle, from rebound_wall_attribute() on. Its identity is the
   time step of its injection, and its number among all particles of that step. */
enum {
    REBOUND_STEP,
    REBOUND_NUMBER,
    REBOUND_HITS,    /* walls met so far */
    REBOUND_OMEGA,   /* mean angular velocity [rad/s], three numbers */
    REBOUND_INERTIA = REBOUND_OMEGA + 3, /* about it, over m a^2; 0: not known */
    REBOUND_ATTRIBUTES
};

/* In cs_user_lagr_model, after it has set n_user_variables for itself: read the settings, open the
   table, and add our user attributes. */
void rebound_wall_model(void);

/* First of our user attributes. */
int rebound_wall_attribute(void);

/* In cs_user_lagr_boundary_conditions, after zones have their types: zones of type CS_LAGR_REBOUND
   get rebounds from the table, zones of type CS_LAGR_SYM mirror the spin too. After a restart it
   reads the user attributes. */
void rebound_wall_zones(void);

/* In cs_user_lagr_in: new particles get an identity, no hits and no spin. */
void rebound_wall_new(cs_lagr_particle_set_t *particles, const cs_lnum_t particle_range[2]);

/* In cs_user_lagr_sde: let the gas slow spins down for a time step. */
void rebound_wall_flight(void);

/* In cs_lagr_user_boundary_interaction, with its arguments. */
void rebound_wall_interaction(cs_lagr_particle_set_t *particles, cs_lnum_t p_id, cs_lnum_t face_id,
                              const cs_real_t face_norm[3], const cs_real_t c_intersect[3],
                              cs_real_t t_intersect, int b_zone_id, int *event_flag,
                              cs_lagr_tracking_state_t *tracking_state);

/* In cs_user_lagr_extra_operations: print the counts of all processes. */
void rebound_wall_log(void);

/* -- between our own files --------------------------------------------------------------------- */

struct rbt_table;
struct rbt_face_hit;

/* Values of rebound_wall.cfg. */
typedef struct {
    char table[256];      /* file of `sampler export`; relative to the folder of the run */
    char direct[258];     /* shared library with direct simulation; empty: none */
    uint64_t seed;        /* of the random numbers */
    int spin;             /* whether particles keep their spin */
    int refuse_outside;   /* whether an impact outside the table ends the run */
    double half_size;     /* largest half-size of a grain over the particle's diameter */
    double deposit_speed; /* critical normal speed of deposits, m/s; 0: no rule */
    double deposit_diameter; /* its diameter, m; 0: of every diameter */
    double gas_torque;    /* of the gas on a spinning grain, over that on a sphere; 0: none */
    double tilt_deg;      /* standard deviation of the tilt of facets; 0: smooth walls */
    int face_sums;        /* whether boundary faces have sums of what met them */
    int face_histograms;  /* whether they have hits by angle and by speed */
    double histogram_speed; /* where the last bin of speeds would end, m/s */
    int isotropic;        /* whether facets are tilted across the plane of incidence as well */
    double ra, rq, rsm;   /* or the profile of the wall, m; rsm 0: none */
} rebound_settings_t;

#define REBOUND_SETTINGS_FILE "rebound_wall.cfg"

/* Read the settings and open the table; an error ends the run with the name of the setting. */
struct rbt_table *rebound_settings_read(rebound_settings_t *settings);

/* Standard deviation [rad] of the tilt that a particle of a diameter [m] meets; 0: smooth walls. */
double rebound_settings_roughness(const rebound_settings_t *settings, double diameter);

/* Make the fields of sums by face, those of works only if the table has works. */
void rebound_sums_make(int works);

/* Make the fields of histograms by face; the last bin of speeds would end at `most`, m/s. */
void rebound_histograms_make(double most);

/* Whether there are sums of works. */
int rebound_sums_have_works(void);

/* Add a hit to the fields of a boundary face, as far as there are fields. */
void rebound_sums_add(cs_lnum_t face_id, const struct rbt_face_hit *hit);

/* Our user attributes: add them to the model, find those of a particle, read them from the files of a
   restart. */
void rebound_particles_make(void);
cs_real_t *rebound_particles_attributes(cs_lagr_particle_set_t *particles, cs_lnum_t p_id);
void rebound_particles_resume(void);

#endif
