/* rebound_particles.c - user attributes of particles: identity, hits, spin, inertia.

   Part of rebound-tables; MIT licence. */

#include <stdio.h>

#if defined(HAVE_MPI)
#include <mpi.h>
#endif

#include "bft_error.h"
#include "bft_mem.h"
#include "cs_parall.h"
#include "cs_restart.h"
#include "cs_time_step.h"

#include "rebound_wall.h"

static int first_attribute = -1; /* ours, among the user attributes */

void rebound_particles_make(void)
{
    first_attribute = cs_glob_lagr_model->n_user_variables;
    cs_glob_lagr_model->n_user_variables += REBOUND_ATTRIBUTES;
}

cs_real_t *rebound_particles_attributes(cs_lagr_particle_set_t *particles, cs_lnum_t p_id)
{
    return (cs_real_t *)cs_lagr_particles_attr(particles, p_id, CS_LAGR_USER) + first_attribute;
}

int rebound_wall_attribute(void)
{
    return first_attribute;
}

/* Number of particles on processes of a lower rank, if there are n on this process. *total becomes their
   number on all processes. */
static cs_gnum_t count_before(cs_lnum_t n, cs_gnum_t *total)
{
    cs_gnum_t before = 0, mine = (cs_gnum_t)n;
    *total = mine;
#if defined(HAVE_MPI)
    if (cs_glob_n_ranks > 1) {
        MPI_Scan(&mine, &before, 1, CS_MPI_GNUM, MPI_SUM, cs_glob_mpi_comm);
        before -= mine;
    }
#endif
    cs_parall_counter(total, 1);
    return before;
}

void rebound_wall_new(cs_lagr_particle_set_t *particles, const cs_lnum_t particle_range[2])
{
    static int step = -1;
    static cs_gnum_t n_identities = 0; /* of this step */
    cs_gnum_t total;
    if (step != cs_glob_time_step->nt_cur) {
        step = cs_glob_time_step->nt_cur;
        n_identities = 0;
    }
    const cs_lnum_t n_new = particle_range[1] - particle_range[0];
    const cs_gnum_t first = n_identities + count_before(n_new, &total);
    n_identities += total;
    for (cs_lnum_t p = particle_range[0]; p < particle_range[1]; p++) {
        cs_real_t *attributes = rebound_particles_attributes(particles, p);
        attributes[REBOUND_STEP] = step;
        attributes[REBOUND_NUMBER] = (cs_real_t)(first + (cs_gnum_t)(p - particle_range[0]));
        for (int k = REBOUND_HITS; k < REBOUND_ATTRIBUTES; k++)
            attributes[k] = 0.0;
    }
}

/* Read one user attribute of all particles. */
static void resume_attribute(cs_restart_t *file, int location, int k, cs_real_t *values)
{
    char section[128];
    snprintf(section, sizeof section, "particle_%s::vals::%d::0",
             cs_lagr_attribute_name[CS_LAGR_USER], k);
    if (cs_restart_read_section(file, section, location, 1, CS_TYPE_cs_real_t, values) !=
        CS_RESTART_SUCCESS)
        bft_error(__FILE__, __LINE__, 0, "restart: the file has no user attribute %d of particles; "
                  "restart from a run with these sources and the same user attributes before ours", k);
}

/* code_saturne 6.0 writes user attributes one by one, but as it reads them each one overwrites all:
   so they are read again, before any particle has moved or come. */
void rebound_particles_resume(void)
{
    cs_lagr_particle_set_t *particles = cs_glob_lagr_particle_set;
    cs_restart_t *file = cs_restart_create("lagrangian", NULL, CS_RESTART_MODE_READ);
    cs_lnum_t n = 0, *cells = NULL;
    cs_real_t *values = NULL;
    const int location = cs_restart_read_particles_info(file, "particle_coords::vals::0", &n);
    if (location < 0 || n != particles->n_particles)
        bft_error(__FILE__, __LINE__, 0, "restart: the file has %d particles, but the run has %d; "
                  "restart from the last checkpoint of one run", (int)n, (int)particles->n_particles);
    BFT_MALLOC(cells, n, cs_lnum_t);
    BFT_MALLOC(values, 3 * n, cs_real_t);
    cs_restart_read_particles(file, location, cells, values); /* needed before their sections */
    for (int k = 0; k < REBOUND_ATTRIBUTES; k++) {
        resume_attribute(file, location, first_attribute + k, values);
        for (cs_lnum_t p = 0; p < n; p++)
            rebound_particles_attributes(particles, p)[k] = values[p];
    }
    BFT_FREE(values);
    BFT_FREE(cells);
    cs_restart_destroy(&file);
}
