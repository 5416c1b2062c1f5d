/* -- torque of the gas ------------------------------------------------------------------------- */

/* Over that of Stokes, from RBTI_TORQUE_FROM on: A + B sqrt(Re). */
#define RBTI_TORQUE_FROM 32.0
#define RBTI_TORQUE_A (128.4 / (64.0 * RBTI_PI))
#define RBTI_TORQUE_B (12.9 / (64.0 * RBTI_PI))

/* The rotation of the gas less that of the particle, and its Reynolds number; 0 without viscosity, where
   there is no torque. */
RBTI_INLINE RBT_DEVICE double rbti_slip(const double omega[3], double diameter, double density,
                                        double viscosity, const double gas_rotation[3],
                                        double slip[3])
{
    for (int k = 0; k < 3; k++)
        slip[k] = (gas_rotation == NULL ? 0.0 : gas_rotation[k]) - omega[k];
    const double size = sqrt(slip[0] * slip[0] + slip[1] * slip[1] + slip[2] * slip[2]);
    const double reynolds = density * diameter * diameter * size / viscosity;
    return rbti_finite(reynolds) ? reynolds : 0.0;
}

/* Share of the slip that is left after a time in relaxation times of Stokes. From RBTI_TORQUE_FROM on
   root = sqrt(Re) follows root' = -(A + B root) root / 2, so root / (A + B root) decays as
   exp(-A time / 2); the rest of the time the slip decays as exp(-time). */
RBTI_INLINE RBT_DEVICE double rbti_slip_left(double reynolds, double time)
{
    const double a = RBTI_TORQUE_A, b = RBTI_TORQUE_B, last = sqrt(RBTI_TORQUE_FROM);
    double root = last, above; /* part of the time that is spent there */
    if (reynolds < RBTI_TORQUE_FROM) {
        above = time + log(RBTI_TORQUE_FROM / (reynolds > 1e-200 ? reynolds : 1e-200));
        above = above < 0.0 ? above : 0.0;
    } else {
        root = sqrt(reynolds);
        above = 2.0 / a * log(root * (a + b * last) / (last * (a + b * root)));
        above = time < above ? time : above;
    }
    const double gone = expm1(-0.5 * a * above);
    double share = a * (1.0 + gone) / (a - b * root * gone);
    if (above < 0.0 && !(share > 0.0 && share * root < 1e3)) /* back in time it grew without end */
        share = root < 1e3 ? 1e3 / root : 1.0;
    return share * share * exp(above - time);
}

RBT_API RBT_DEVICE void rbt_gas_torque(const double omega[3], double diameter, double density,
                                       double viscosity, const double gas_rotation[3],
                                       double torque[3])
{
    double slip[3];
    const double reynolds = rbti_slip(omega, diameter, density, viscosity, gas_rotation, slip);
    const double law = reynolds < RBTI_TORQUE_FROM
                           ? 1.0
                           : RBTI_TORQUE_A + RBTI_TORQUE_B * sqrt(reynolds);
    for (int k = 0; k < 3; k++)
        torque[k] = RBTI_PI * viscosity * diameter * diameter * diameter * law * slip[k];
}

RBT_API RBT_DEVICE void rbt_spin_after(const double omega[3], double time, double inertia,
                                       double diameter, double density, double viscosity,
                                       const double gas_rotation[3], double new_omega[3])
{
    double slip[3];
    const double reynolds = rbti_slip(omega, diameter, density, viscosity, gas_rotation, slip);
    const double stokes = RBTI_PI * viscosity * diameter * diameter * diameter;
    const double left = rbti_slip_left(reynolds, stokes * time / inertia);
    for (int k = 0; k < 3; k++)
        new_omega[k] = (gas_rotation == NULL ? 0.0 : gas_rotation[k]) - left * slip[k];
}

/* -- sizes, and particles that stay on the wall -------------------------------------------------- */

/* Volume of a shape over a b c, by its code; 0: a mesh. */
RBTI_INLINE RBT_DEVICE double rbti_volume(double shape)
{
    const double volumes[5] = {4.0 / 3.0 * RBTI_PI, 8.0, 7.731986497631108, 8.0 / 3.0,
                               4.0 / 3.0 * RBTI_PI};
    return shape >= 0.0 && shape <= 4.0 ? volumes[(int)shape] : 0.0;
}

RBT_API RBT_DEVICE double rbt_half_size(double diameter, const double grain[3])
{
    const double volume = rbti_volume(grain[0]) * grain[1] * grain[1] * grain[2];
    return volume > 0.0 ? 0.5 * diameter * cbrt(4.0 / 3.0 * RBTI_PI / volume) : 0.0;
}

RBT_API RBT_DEVICE double rbt_inertia(const double grain[3])
{
    const double squares[5] = {0.2, 1.0 / 3.0, 0.3191877964358231, 0.2, 0.2}; /* mean of x^2 / a^2 */
    const double b = grain[1], c = b * grain[2];
    if (!(rbti_volume(grain[0]) > 0.0))
        return 0.0;
    return 2.0 / 3.0 * squares[(int)grain[0]] * (1.0 + b * b + c * c);
}

/* Surface of an ellipsoid with half-axes 1, b, c over 4 pi: R_G(b^2, c^2, b^2 c^2), by duplication of
   R_F and R_D. Source: Carlson, Numer. Algorithms 10 (1995) 13-26, eqs 1.5 to 1.7 and 2.1 to 2.24. */
RBTI_INLINE RBT_DEVICE double rbti_ellipsoid_surface(double b, double c)
{
    const double first = b * b, second = b * b * c * c, last = c * c; /* the last lies between */
    double x = first, y = second, z = last, sum = 0.0, share = 1.0;
    for (int k = 0; k < 28; k++) {
        const double root = sqrt(x * y) + sqrt(y * z) + sqrt(z * x);
        sum += share / (sqrt(z) * (z + root));
        share *= 0.25;
        x = 0.25 * (x + root);
        y = 0.25 * (y + root);
        z = 0.25 * (z + root);
    }
    const double f = 1.0 / sqrt(z), d = 3.0 * sum + share / (z * sqrt(z));
    return 0.5 * (last * f - (first - last) * (second - last) * d / 3.0 +
                  sqrt(first * second / last));
}

RBT_API RBT_DEVICE double rbt_sphericity(const double grain[3])
{
    const double b = grain[1], c = b * grain[2], faces = b + b * c + c; /* of a box, over 8 */
    const double across = sqrt(b * b + c * c + b * b * c * c), cut = 0.5857864376269049;
    const double half = rbt_half_size(2.0, grain);
    double surface = 8.0 * across; /* of a tetrahedron, with half-edges 1, b, c of the box */
    if (!(half > 0.0))
        return 0.0;
    if (grain[0] == 0.0 || grain[0] == 4.0)
        surface = 4.0 * RBTI_PI * rbti_ellipsoid_surface(b, c);
    else if (grain[0] == 1.0)
        surface = 8.0 * faces;
    else if (grain[0] == 2.0)
        surface = 8.0 * faces * (1.0 - 0.5 * cut * cut) + 4.0 * cut * cut * across;
    return 4.0 * RBTI_PI / (half * half * surface);
}

/* Mean of a power of a drawn ratio, at 256 midpoints: within 1e-6. */
RBTI_INLINE RBT_DEVICE double rbti_mean_power(const double law[4], double power)
{
    double ratio[RBTI_BLOCK], sum = 0.0;
    for (uint32_t k = 0; k < 256; k++) {
        const uint32_t word = (k << 24) + 0x800000u;
        rbti_fill_ratios(1, law, &word, ratio);
        sum += pow(ratio[0], power);
    }
    return sum / 256.0;
}

RBT_API RBT_DEVICE double rbt_mean_half_size(const rbt_table *table, double diameter)
{
    if (!table)
        return 0.0;
    const rbt_spin_law *law = &table->spin;
    double before = 0.0, sum = 0.0;
    for (int32_t row = 0; row < law->n_shapes; row++) {
        const double *own = law->shape_ratios + 2 * row;
        const int drawn = own[0] == 0.0;
        const double grain[3] = {(double)law->shape_codes[row], drawn ? 1.0 : own[0],
                                 drawn ? 1.0 : own[1]};
        const double half = rbt_half_size(diameter, grain);
        if (half == 0.0)
            return 0.0;
        sum += (law->shape_shares[row] - before) * half *
               (drawn ? rbti_mean_power(law->aspect, -2.0 / 3.0) *
                            rbti_mean_power(law->aspect + 4, -1.0 / 3.0)
                      : 1.0);
        before = law->shape_shares[row];
    }
    return sum;
}

RBT_API RBT_DEVICE int rbt_wall_tilt(double ra, double rq, double rsm, double diameter,
                                     double *tilt)
{
    if (!(rbti_finite(ra) && rbti_finite(rq) && rbti_finite(rsm) && rbti_finite(diameter)))
        return RBT_ERR_NOT_FINITE;
    /* A root mean square is not below the mean of the same heights, rounding of digits apart. */
    if (ra < 0.0 || rq < 0.99 * ra || rsm <= 0.0 || diameter <= 0.0)
        return RBT_ERR_ROUGHNESS_NOT_USABLE;
    const double flank = atan(2.0 * ra / rsm), seen = diameter * sin(flank) < rsm
                                                           ? flank
                                                           : atan(2.0 * rq / rsm);
    if (rbti_is_outside(seen, 0.0, RBT_MOST_ROUGHNESS))
        return RBT_ERR_ROUGHNESS_NOT_USABLE;
    *tilt = seen;
    return RBT_OK;
}

/* Compliance of a material, 1/Pa: (1 - poisson^2) / (pi young). NaN if it has no such constants. */
RBTI_INLINE RBT_DEVICE double rbti_compliance(double young, double poisson)
{
    if (!(rbti_finite(young) && rbti_finite(poisson)) || young <= 0.0 ||
        rbti_is_outside(poisson, 0.0, 0.5))
        return rbti_nan();
    return (1.0 - poisson * poisson) / (RBTI_PI * young);
}

RBT_API RBT_DEVICE double rbt_critical_speed(double diameter, double density, double young,
                                             double poisson, double wall_young, double wall_poisson)
{
    const double both = rbti_compliance(young, poisson) + rbti_compliance(wall_young, wall_poisson);
    if (!(rbti_finite(diameter) && rbti_finite(density) && rbti_finite(both)) || diameter <= 0.0 ||
        density <= 0.0)
        return rbti_nan();
    const double e = 0.51 * pow(1.25 * RBTI_PI * RBTI_PI * both / pow(density, 1.5), 0.4);
    return pow(2.0 * e / diameter, 10.0 / 7.0);
}

RBT_API RBT_DEVICE int rbt_deposits(const double velocity[3], const double normal[3],
                                    double critical_speed, const double wall_velocity[3])
{
    double relative[3], e_y[3];
    for (int k = 0; k < 3; k++)
        relative[k] = velocity[k] - (wall_velocity ? wall_velocity[k] : 0.0);
    rbti_unit(normal, e_y);
    const double approach = -rbti_dot(relative, e_y);
    return approach > 0.0 && approach < critical_speed;
}
