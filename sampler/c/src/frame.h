/* -- rebounds: the lab frame and the frame of the impact ------------------------------------------

   Velocities in the lab frame, m/s, and angular velocities, rad/s, to the state of an impact and back.
   The frame of the impact has y along the wall normal into the gas, x along the tangential part of the
   velocity relative to the wall, and z = x cross y. At normal impact, where there is no tangential part,
   the direction of x is drawn from word 8. */

RBTI_INLINE RBT_DEVICE double rbti_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

RBTI_INLINE RBT_DEVICE void rbti_cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* out = p a + q b; out may be a or b. */
RBTI_INLINE RBT_DEVICE void rbti_combine(double p, const double a[3], double q, const double b[3],
                                         double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = p * a[k] + q * b[k];
}

/* Unit vector along a nonzero finite vector of any magnitude; out may be a. */
RBTI_INLINE RBT_DEVICE void rbti_unit(const double a[3], double out[3])
{
    const double x = fabs(a[0]), y = fabs(a[1]), z = fabs(a[2]);
    double largest = x > y ? x : y;
    largest = largest > z ? largest : z;
    double scaled[3];
    for (int k = 0; k < 3; k++)
        scaled[k] = a[k] / largest;
    const double inverse = 1.0 / sqrt(rbti_dot(scaled, scaled));
    for (int k = 0; k < 3; k++)
        out[k] = inverse * scaled[k];
}

RBTI_INLINE RBT_DEVICE int rbti_all_finite(const double a[3])
{
    return rbti_finite(a[0]) && rbti_finite(a[1]) && rbti_finite(a[2]);
}

/* Unit vector perpendicular to e_y, at an angle about it. */
RBTI_INLINE RBT_DEVICE void rbti_perpendicular(const double e_y[3], double azimuth, double e_x[3])
{
    const double x = fabs(e_y[0]), y = fabs(e_y[1]), z = fabs(e_y[2]);
    double axis[3] = {0.0, 0.0, 0.0}, zero[3], side[3];
    axis[x <= y && x <= z ? 0 : y <= z ? 1 : 2] = 1.0;
    rbti_combine(1.0, axis, -rbti_dot(axis, e_y), e_y, zero);
    rbti_unit(zero, zero);
    rbti_cross(e_y, zero, side);
    rbti_combine(cos(azimuth), zero, sin(azimuth), side, e_x);
}

/* Unit vector along the tangential part of a velocity, projected twice against rounding. */
RBTI_INLINE RBT_DEVICE void rbti_along_wall(const double relative[3], const double e_y[3],
                                            double e_x[3])
{
    rbti_combine(1.0, relative, -rbti_dot(relative, e_y), e_y, e_x);
    rbti_unit(e_x, e_x);
    rbti_combine(1.0, e_x, -rbti_dot(e_x, e_y), e_y, e_x);
    rbti_unit(e_x, e_x);
}

/* Vector of the lab frame from its components along three axes, times a scale. */
RBTI_INLINE RBT_DEVICE void rbti_along_axes(const double state[3], const double e_x[3],
                                            const double e_y[3], const double e_z[3], double scale,
                                            double out[3])
{
    double plane[3];
    rbti_combine(state[0], e_x, state[1], e_y, plane);
    rbti_combine(scale, plane, scale * state[2], e_z, out);
}

/* An impact. */
typedef struct rbti_impact {
    double relative[3], wall[3];   /* velocity relative to the wall, and of the wall, m/s */
    double e_x[3], e_y[3], e_z[3]; /* axes of its frame */
    double alpha1, speed;          /* impact angle, rad, and speed, m/s */
    double half_size;              /* m */
} rbti_impact;

/* Check the numbers of an impact. Returns RBT_OK or an error. */
RBTI_INLINE RBT_DEVICE int rbti_impact_status(const double velocity[3], const double normal[3],
                                              double half_size, const double wall[3])
{
    if (!(rbti_all_finite(velocity) && rbti_all_finite(wall) && rbti_all_finite(normal) &&
          rbti_finite(half_size)))
        return RBT_ERR_NOT_FINITE;
    if (normal[0] == 0.0 && normal[1] == 0.0 && normal[2] == 0.0)
        return RBT_ERR_NORMAL_NOT_USABLE;
    return rbti_is_outside(half_size, RBT_LEAST_HALF_SIZE, RBT_MOST_HALF_SIZE) ? RBT_ERR_HALF_SIZE
                                                                               : RBT_OK;
}

/* Impact angle from the wall, rad, and the tangential speed. If the particle recedes the angle is not
   above 0. */
RBTI_INLINE RBT_DEVICE double rbti_impact_angle(const double relative[3], const double e_y[3],
                                                double *tangential)
{
    const double approach = -rbti_dot(relative, e_y);
    double along[3];
    rbti_combine(1.0, relative, approach, e_y, along);
    *tangential = sqrt(rbti_dot(along, along));
    return atan2(approach, *tangential);
}

/* Unit vector along the tangential velocity. At normal impact, where there is none, its azimuth is
   drawn. */
RBTI_INLINE RBT_DEVICE void rbti_tangent(const double relative[3], const double e_y[3],
                                         double tangential, double speed, uint64_t seed,
                                         uint64_t index, uint32_t hit, double e_x[3])
{
    if (tangential <= RBTI_NORMAL_IMPACT * speed) {
        uint32_t words[4];
        rbti_fill_words(1, 2, seed, &index, &hit, 1, words);
        rbti_perpendicular(e_y, RBTI_TWO_PI * rbti_uniform(words[0]), e_x);
    } else {
        rbti_along_wall(relative, e_y, e_x);
    }
}

/* Find angle, speed and frame of an impact. Returns RBT_OK or an error. */
RBTI_INLINE RBT_DEVICE int rbti_find_impact(const double velocity[3], const double normal[3],
                                            double half_size, const double *wall_velocity,
                                            uint64_t seed, uint64_t index, uint32_t hit,
                                            rbti_impact *impact)
{
    for (int k = 0; k < 3; k++)
        impact->wall[k] = wall_velocity ? wall_velocity[k] : 0.0;
    const int code = rbti_impact_status(velocity, normal, half_size, impact->wall);
    if (code != RBT_OK)
        return code;
    impact->half_size = half_size;
    rbti_combine(1.0, velocity, -1.0, impact->wall, impact->relative);
    impact->speed = sqrt(rbti_dot(impact->relative, impact->relative));
    if (impact->speed < RBTI_LEAST_SPEED)
        return RBT_ERR_SPEED_NOT_POSITIVE;
    rbti_unit(normal, impact->e_y);
    double tangential;
    impact->alpha1 = rbti_impact_angle(impact->relative, impact->e_y, &tangential);
    rbti_tangent(impact->relative, impact->e_y, tangential, impact->speed, seed, index, hit,
                 impact->e_x);
    rbti_cross(impact->e_x, impact->e_y, impact->e_z);
    return RBT_OK;
}

/* Turn an angular velocity of the lab frame into a spin in the frame of the impact. Returns RBT_OK or an
   error. */
RBTI_INLINE RBT_DEVICE int rbti_to_spin(const rbti_impact *impact, const double omega[3],
                                        double spin[3])
{
    if (!rbti_all_finite(omega))
        return RBT_ERR_NOT_FINITE;
    const double scale = impact->half_size / impact->speed;
    spin[0] = scale * rbti_dot(omega, impact->e_x);
    spin[1] = scale * rbti_dot(omega, impact->e_y);
    spin[2] = scale * rbti_dot(omega, impact->e_z);
    return RBT_OK;
}

/* Turn a drawn state into a velocity and an angular velocity in the lab frame. */
RBTI_INLINE RBT_DEVICE void rbti_to_lab_frame(const rbti_impact *impact, const double state[6],
                                              double velocity[3], double omega[3])
{
    const double *e_x = impact->e_x, *e_y = impact->e_y, *e_z = impact->e_z;
    rbti_along_axes(state, e_x, e_y, e_z, impact->speed, velocity);
    rbti_along_axes(state + 3, e_x, e_y, e_z, impact->speed / impact->half_size, omega);
    for (int k = 0; k < 3; k++)
        velocity[k] += impact->wall[k];
}

/* Add the works of a drawn state, J/kg; `works` may be NULL. */
RBTI_INLINE RBT_DEVICE void rbti_add_works(const rbti_impact *impact, const double *state,
                                           double *works)
{
    for (int k = 0; k < 2 && works; k++)
        works[k] += 0.5 * impact->speed * impact->speed * state[RBT_WORK_NORMAL + k];
}
