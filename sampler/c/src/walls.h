/* -- walls: measured profiles, and particles that stay ---------------------------------------------

   The tilt of facets of a wall with a measured profile, rad (Sommerfeld & Huber, Int. J. Multiphase Flow
   25 (1999) 1457-1489), and the normal speed, m/s, below which particles stay on a wall (Brach & Dunn,
   Aerosol Sci. Technol. 16 (1992) 51-64). */

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

RBT_API RBT_DEVICE double rbt_critical_speed_at(double diameter, double speed,
                                                double reference_diameter)
{
    return reference_diameter > 0.0 ? speed * pow(reference_diameter / diameter, 10.0 / 7.0) : speed;
}

RBT_API RBT_DEVICE int rbt_deposits(const double velocity[3], const double normal[3],
                                    double critical_speed, const double wall_velocity[3])
{
    double relative[3], e_y[3];
    for (int k = 0; k < 3; k++)
        relative[k] = velocity[k] - (wall_velocity ? wall_velocity[k] : 0.0);
    /* Looked at first: flow codes trap comparisons with NaN and divisions by zero. */
    if (!rbti_all_finite(relative) || !rbti_all_finite(normal) || critical_speed != critical_speed ||
        (normal[0] == 0.0 && normal[1] == 0.0 && normal[2] == 0.0))
        return 0;
    rbti_unit(normal, e_y);
    const double approach = -rbti_dot(relative, e_y);
    return approach > 0.0 && approach < critical_speed;
}
