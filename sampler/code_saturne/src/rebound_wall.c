/* rebound_wall.c - rebounds at walls, and spins between them, in SI units.

   code_saturne calls rebound_wall_interaction at each wall: it finds the normal, lets the particle stay
   (deposit), rebound (draw) or mirror (reflect), adds the hit to the statistics of the face, and turns the rest
   of its path. Part of rebound-tables; MIT licence. */

#include <math.h>
#include <string.h>

#include "rebound_sampler.h"

#include "bft_error.h"
#include "bft_mem.h"
#include "bft_printf.h"
#include "cs_boundary_zone.h"
#include "cs_field.h"
#include "cs_lagr_event.h"
#include "cs_math.h"
#include "cs_mesh.h"
#include "cs_mesh_quantities.h"
#include "cs_parall.h"
#include "cs_time_step.h"
#include "fvm_periodicity.h"

#include "rebound_wall.h"

/* Shift of the tracker's start from the wall towards the cell's centre, as in code_saturne. */
#define START_SHIFT 1e-2

static rebound_settings_t settings;
static rbt_table *table = NULL;
static int *is_symmetry = NULL; /* for each zone: 1 a symmetry plane, 0 a wall, -1 not ours */
static int n_zones = 0;
static int resumed = 0;

/* Counts of this process: hits of walls, hits after which particles stayed, hits with each flag. */
enum { HITS, DEPOSITED, ANGLE, SPEED, SPIN, EXTRAPOLATED, COUNTS };
static cs_gnum_t counts[COUNTS] = {0};

/* Refuse models of code_saturne that do not go together with rebounds from a table. */
static void check_models(void)
{
    const cs_lagr_model_t *model = cs_glob_lagr_model;
    if (model->agglomeration || model->fragmentation || model->precipitation)
        bft_error(__FILE__, __LINE__, 0, "%s: table: agglomeration, fragmentation and "
                  "precipitation make particles without identity; switch them off",
                  REBOUND_SETTINGS_FILE);
    if (cs_glob_lagr_time_scheme->t_order != 1)
        bft_error(__FILE__, __LINE__, 0, "%s: table: at t_order %d code_saturne 6.0 goes back to "
                  "the velocity before the rebound; set t_order to 1",
                  REBOUND_SETTINGS_FILE, cs_glob_lagr_time_scheme->t_order);
}

void rebound_wall_model(void)
{
    table = rebound_settings_read(&settings);
    rebound_particles_make();
    if (settings.face_sums)
        rebound_sums_make(rbt_has_variable(table, RBT_WORK_NORMAL));
    if (settings.face_histograms)
        rebound_histograms_make(settings.histogram_speed);
}

/* Refuse a periodicity of rotation, which turns the velocities of particles but not their spins. */
static void check_periodicity(void)
{
    const fvm_periodicity_t *periodicity = cs_glob_mesh->periodicity;
    const int n = periodicity == NULL ? 0 : fvm_periodicity_get_n_transforms(periodicity);
    for (int i = 0; i < n && settings.spin; i++)
        if (fvm_periodicity_get_type(periodicity, i) >= FVM_PERIODICITY_ROTATION)
            bft_error(__FILE__, __LINE__, 0, "%s: spin: a periodicity of rotation turns velocities, "
                      "but not spins; write `spin no`", REBOUND_SETTINGS_FILE);
}

void rebound_wall_zones(void)
{
    cs_lagr_zone_data_t *conditions = cs_lagr_get_boundary_conditions();
    if (n_zones < conditions->n_zones) {
        BFT_REALLOC(is_symmetry, conditions->n_zones, int);
        for (; n_zones < conditions->n_zones; n_zones++)
            is_symmetry[n_zones] = -1;
    }
    for (int zone = 0; zone < conditions->n_zones; zone++) {
        int *type = conditions->zone_type + zone;
        if (*type != CS_LAGR_REBOUND && *type != CS_LAGR_SYM)
            continue; /* of another kind, or ours since an earlier time step */
        is_symmetry[zone] = *type == CS_LAGR_SYM;
        *type = CS_LAGR_BC_USER;
    }
    if (!resumed) {
        check_models();
        check_periodicity();
        if (cs_glob_lagr_time_scheme->isuila == 1)
            rebound_particles_resume();
    }
    resumed = 1;
}

/* Identity of a particle, the index of the random numbers. */
static uint64_t identity_of(const double *attributes)
{
    return ((uint64_t)attributes[REBOUND_STEP] << 32) | (uint64_t)attributes[REBOUND_NUMBER];
}

/* Let the gas act on a spin for a time [s]. A negative time goes back. */
static void fly(cs_lagr_particle_set_t *particles, cs_lnum_t p_id, double time, double inertia,
                double omega[3])
{
    const double diameter = cs_lagr_particles_get_real(particles, p_id, CS_LAGR_DIAMETER);
    const double mass = cs_lagr_particles_get_real(particles, p_id, CS_LAGR_MASS);
    const cs_lnum_t cell = cs_lagr_particles_get_lnum(particles, p_id, CS_LAGR_CELL_ID);
    const cs_lagr_extra_module_t *gas = cs_glob_lagr_extra_module;
    if (!(cs_math_3_norm(omega) > 0.0 && settings.gas_torque > 0.0))
        return;
    const double moment = rbt_moment_of_inertia(table, settings.seed,
                                                identity_of(rebound_particles_attributes(particles, p_id)), inertia,
                                                mass, settings.half_size * diameter, diameter);
    rbt_spin_after(omega, time, moment / settings.gas_torque, diameter, gas->cromf->val[cell],
                   gas->viscl->val[cell], NULL, omega);
}

void rebound_wall_flight(void)
{
    cs_lagr_particle_set_t *particles = cs_glob_lagr_particle_set;
    if (settings.gas_torque <= 0.0)
        return;
    for (cs_lnum_t p = 0; p < particles->n_particles; p++) {
        double *attributes = rebound_particles_attributes(particles, p);
        fly(particles, p, cs_glob_lagr_time_step->dtp, attributes[REBOUND_INERTIA], attributes + REBOUND_OMEGA);
    }
}

/* Start of the path that the tracker of code_saturne follows to CS_LAGR_COORDS. It is the first entry of a
   particle's data, in a private structure; so each hit checks that the path leads through the wall. */
static cs_real_t *start_of(cs_lagr_particle_set_t *particles, cs_lnum_t p_id,
                           const cs_real_t end[3], const cs_real_t hit[3], double t)
{
    cs_real_t *start = (cs_real_t *)(particles->p_buffer + particles->p_am->extents * (size_t)p_id);
    for (int k = 0; k < 3; k++) {
        const double size = fabs(start[k]) + fabs(end[k]);
        if (!(fabs(start[k] + t * (end[k] - start[k]) - hit[k]) <= 1e-9 * size))
            bft_error(__FILE__, __LINE__, 0, "rebound_wall: the data of particles have another order "
                      "than in code_saturne 6.0; use that version");
    }
    return start;
}

/* Unit normal from the wall into the gas. code_saturne's face_norm may have either sign. */
static void normal_into_gas(cs_lnum_t face_id, const cs_real_t face_norm[3], double normal[3])
{
    const cs_real_t *outwards = cs_glob_mesh_quantities->b_face_normal + 3 * (size_t)face_id;
    const double sign = cs_math_3_dot_product(outwards, face_norm) > 0.0 ? -1.0 : 1.0;
    for (int k = 0; k < 3; k++)
        normal[k] = sign * face_norm[k];
}

/* Mirror a vector at a plane. */
static void mirror(const double normal[3], cs_real_t vector[3])
{
    const double twice = 2.0 * cs_math_3_dot_product(normal, vector);
    for (int k = 0; k < 3; k++)
        vector[k] -= twice * normal[k];
}

/* Whether a particle stays on the wall; then it is fixed there, as CS_LAGR_DEPO2 does. */
static int deposit(cs_lagr_particle_set_t *particles, cs_lnum_t p_id, const double normal[3],
                   cs_real_t velocity[3])
{
    double *attributes = rebound_particles_attributes(particles, p_id);
    const double d = cs_lagr_particles_get_real(particles, p_id, CS_LAGR_DIAMETER);
    const double critical_speed =
        rbt_critical_speed_at(d, settings.deposit_speed, settings.deposit_diameter);
    if (!rbt_deposits(velocity, normal, critical_speed, NULL))
        return 0;
    cs_lagr_particles_set_flag(particles, p_id, CS_LAGR_PART_DEPOSITED | CS_LAGR_PART_FIXED);
    particles->n_part_dep += 1;
    particles->weight_dep += cs_lagr_particles_get_real(particles, p_id, CS_LAGR_STAT_WEIGHT);
    for (int k = 0; k < 3; k++)
        velocity[k] = attributes[REBOUND_OMEGA + k] = 0.0;
    attributes[REBOUND_INERTIA] = 0.0;
    attributes[REBOUND_HITS] += 1.0;
    counts[HITS]++;
    counts[DEPOSITED]++;
    return 1;
}

/* End the run because of an impact that is outside the table, or cannot be drawn. */
static void refuse(const rbt_impacts *impact, int code)
{
    const double *v = impact->velocity, none[3] = {0.0, 0.0, 0.0};
    const double *omega = impact->omega != NULL ? impact->omega : none;
    rbt_range range;
    rbt_covered(table, &range);
    bft_error(__FILE__, __LINE__, 0, "%s: out_of_range: got an impact at (%g, %g, %g) m/s, half-size "
              "%g m and spin (%g, %g, %g) rad/s, allowed: %g to %g deg, %g to %g m/s, spins of %g to "
              "%g V/a (%s)", REBOUND_SETTINGS_FILE, v[0], v[1], v[2], *impact->half_size, omega[0],
              omega[1], omega[2], range.alpha1[0] * 180.0 / cs_math_pi,
              range.alpha1[1] * 180.0 / cs_math_pi, range.speed[0], range.speed[1], range.spin[0],
              range.spin[1], rbt_strerror(code));
}

/* Draw the rebound of a particle `rest` [s] before the end of the time step, and the works of its impulses
   [J/kg]. If the particle leaves the wall already, or rests, returns 0 and changes nothing. */
static int draw(cs_lagr_particle_set_t *particles, cs_lnum_t p_id, const double normal[3],
                double rest, cs_real_t velocity[3], double works[2])
{
    double *attributes = rebound_particles_attributes(particles, p_id), *omega = attributes + REBOUND_OMEGA;
    const double diameter = cs_lagr_particles_get_real(particles, p_id, CS_LAGR_DIAMETER);
    const double roughness = rebound_settings_roughness(&settings, diameter);
    const double a = settings.half_size * diameter;
    const uint64_t index = identity_of(attributes);
    const uint32_t hit = (uint32_t)attributes[REBOUND_HITS];
    const double inertia = attributes[REBOUND_INERTIA];
    double before[3] = {omega[0], omega[1], omega[2]}, new_velocity[3], new_omega[3], new_inertia;
    if (!(attributes[REBOUND_STEP] >= 1.0))
        bft_error(__FILE__, __LINE__, 0, "rebound_wall: a particle has no identity; call "
                  "rebound_wall_new in cs_user_lagr_in");
    /* rebound_wall_flight has flown the whole time step already, so go back to the time of the hit */
    fly(particles, p_id, -rest, inertia, before);
    const rbt_impacts impact = {.velocity = velocity,
                                .normal = normal,
                                .half_size = &a,
                                .omega = settings.spin ? before : NULL,
                                .inertia = settings.spin ? &inertia : NULL,
                                .roughness = &roughness,
                                .index = &index,
                                .hit = &hit,
                                .fresh = !rbt_has_spin_law(table),
                                .isotropic = settings.isotropic};
    rbt_rebounds after = {.velocity = new_velocity,
                          .omega = new_omega,
                          .inertia = &new_inertia,
                          .works = rebound_sums_have_works() ? works : NULL};
    const int code = rbt_rebound(table, 1, &impact, settings.seed, &after);
    if (code == RBT_ERR_NOT_APPROACHING || code == RBT_ERR_SPEED_NOT_POSITIVE)
        return 0;
    if (code < RBT_OK || (settings.refuse_outside && (code & RBT_OUTSIDE)))
        refuse(&impact, code);
    fly(particles, p_id, rest, new_inertia, new_omega);
    memcpy(velocity, new_velocity, sizeof new_velocity);
    memcpy(omega, new_omega, sizeof new_omega);
    attributes[REBOUND_INERTIA] = new_inertia;
    attributes[REBOUND_HITS] += 1.0;
    counts[HITS]++;
    for (int kind = 0; kind < 4; kind++)
        counts[ANGLE + kind] += after.flagged[kind];
    return 1;
}

/* Rebound a particle: set its velocity and the works, and turn the rest of its path, which comes in as it
   would go on behind the wall. If the particle leaves the wall already, or rests, its path is mirrored, and 0
   returned: this is no hit. */
static int rebound(cs_lagr_particle_set_t *particles, cs_lnum_t p_id, const double normal[3],
                   cs_real_t velocity[3], double path[3], double works[2])
{
    const double speed = cs_math_3_norm(velocity);
    const double rest = speed > 0.0 ? cs_math_3_norm(path) / speed : 0.0;
    const int drawn = draw(particles, p_id, normal, rest, velocity, works);
    if (!drawn)
        mirror(normal, path);
    for (int k = 0; k < 3 && drawn; k++)
        path[k] = rest * velocity[k];
    return drawn;
}

/* Reflect a particle at a symmetry plane, as code_saturne does, and its spin, an axial vector. */
static void reflect(cs_lagr_particle_set_t *particles, cs_lnum_t p_id, const double normal[3],
                    cs_real_t velocity[3], double path[3])
{
    double *omega = rebound_particles_attributes(particles, p_id) + REBOUND_OMEGA;
    mirror(normal, velocity);
    mirror(normal, path);
    mirror(normal, omega);
    for (int k = 0; k < 3; k++)
        omega[k] = -omega[k];
}

/* Add a hit, with the velocities before and after it, to the statistics of its face. */
static void add_to_face(cs_lagr_particle_set_t *particles, cs_lnum_t p_id, cs_lnum_t face_id,
                        const double normal[3], const double before[3], const double after[3],
                        int stays, const double works[2])
{
    rbt_face_hit hit = {0};
    hit.number = cs_lagr_particles_get_real(particles, p_id, CS_LAGR_STAT_WEIGHT);
    hit.mass = cs_lagr_particles_get_real(particles, p_id, CS_LAGR_MASS);
    memcpy(hit.before, before, sizeof hit.before);
    memcpy(hit.after, after, sizeof hit.after);
    memcpy(hit.normal, normal, sizeof hit.normal);
    memcpy(hit.works, works, sizeof hit.works);
    hit.stays = stays;
    rebound_sums_add(face_id, &hit);
}

void rebound_wall_interaction(cs_lagr_particle_set_t *particles, cs_lnum_t p_id, cs_lnum_t face_id,
                              const cs_real_t face_norm[3], const cs_real_t c_intersect[3],
                              cs_real_t t_intersect, int b_zone_id, int *event_flag,
                              cs_lagr_tracking_state_t *tracking_state)
{
    cs_real_t *end = cs_lagr_particles_attr(particles, p_id, CS_LAGR_COORDS);
    cs_real_t *velocity = cs_lagr_particles_attr(particles, p_id, CS_LAGR_VELOCITY);
    cs_real_t *seen = cs_lagr_particles_attr(particles, p_id, CS_LAGR_VELOCITY_SEEN);
    cs_real_t *start = start_of(particles, p_id, end, c_intersect, t_intersect);
    const cs_lnum_t cell = cs_lagr_particles_get_lnum(particles, p_id, CS_LAGR_CELL_ID);
    const cs_real_t *centre = cs_glob_mesh_quantities->cell_cen + 3 * (size_t)cell;
    const double before[3] = {velocity[0], velocity[1], velocity[2]};
    double normal[3], path[3], works[2] = {0.0, 0.0};

    if (b_zone_id < 0 || b_zone_id >= n_zones || is_symmetry[b_zone_id] < 0)
        bft_error(__FILE__, __LINE__, 0, "rebound_wall: zone %d has the type CS_LAGR_BC_USER; "
                  "give it CS_LAGR_REBOUND or CS_LAGR_SYM before rebound_wall_zones", b_zone_id);
    normal_into_gas(face_id, face_norm, normal);
    for (int k = 0; k < 3; k++)
        path[k] = end[k] - c_intersect[k];
    const int stays = !is_symmetry[b_zone_id] && deposit(particles, p_id, normal, velocity);
    if (is_symmetry[b_zone_id])
        reflect(particles, p_id, normal, velocity, path);
    else if (stays || rebound(particles, p_id, normal, velocity, path, works))
        add_to_face(particles, p_id, face_id, normal, before, velocity, stays, works);
    for (int k = 0; k < 3; k++) {
        start[k] = c_intersect[k] + START_SHIFT * (centre[k] - c_intersect[k]);
        end[k] = stays ? start[k] : c_intersect[k] + path[k];
        seen[k] = stays ? 0.0 : seen[k];
    }
    mirror(normal, seen); /* the gas that it meets next moves away from the wall with it */

    if (!is_symmetry[b_zone_id]) {
        const cs_lagr_boundary_interactions_t *statistics = cs_glob_lagr_boundary_interactions;
        *event_flag |= stays ? CS_EVENT_DEPOSITION : CS_EVENT_REBOUND;
        if (statistics->has_part_impact_nbr > 0)
            bound_stat[statistics->inbr * cs_glob_mesh->n_b_faces + face_id] +=
                cs_lagr_particles_get_real(particles, p_id, CS_LAGR_STAT_WEIGHT);
    }
    *tracking_state = stays ? CS_LAGR_PART_STUCK : CS_LAGR_PART_TO_SYNC;
}

void rebound_wall_log(void)
{
    cs_gnum_t all[COUNTS];
    if (cs_glob_time_step->nt_cur != cs_glob_time_step->nt_max &&
        (cs_glob_lagr_log_frequency_n < 1 ||
         cs_glob_time_step->nt_cur % cs_glob_lagr_log_frequency_n != 0))
        return;
    memcpy(all, counts, sizeof counts);
    cs_parall_counter(all, COUNTS);
    bft_printf("   ** Tabulated rebounds of this run (hits, deposited, angle, speed, spin, "
               "extrapolated)");
    for (int i = 0; i < COUNTS; i++)
        bft_printf("%s%llu", i == 0 ? " = " : ", ", (unsigned long long)all[i]);
    bft_printf("\n");
}
