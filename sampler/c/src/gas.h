/* -- torque of the gas -----------------------------------------------------------------------------

   The torque of the gas on a sphere, N m, and how it slows a spin down, rad/s. Source: Dennis, Singh &
   Ingham, J. Fluid Mech. 101 (1980) 257-279. */

/* From Re = RBTI_TORQUE_FROM on, the torque over that of Stokes is A + B sqrt(Re). */
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
    if (!(viscosity > 0.0)) /* not divided by: flow codes trap divisions by zero */
        return 0.0;
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
    const double back = -0.5 * a * above;              /* above 0 if the time goes back */
    const double gone = expm1(back < 50.0 ? back : 50.0); /* beyond, it grew without end long before */
    const double part = a - b * root * gone;
    double share = part > 0.0 ? a * (1.0 + gone) / part : 0.0;
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

RBT_API RBT_DEVICE void rbt_spin_after(const double omega[3], double time, double moment,
                                       double diameter, double density, double viscosity,
                                       const double gas_rotation[3], double new_omega[3])
{
    double slip[3];
    const double reynolds = rbti_slip(omega, diameter, density, viscosity, gas_rotation, slip);
    const double stokes = RBTI_PI * viscosity * diameter * diameter * diameter;
    const double share_left = rbti_slip_left(reynolds, stokes * time / moment);
    for (int k = 0; k < 3; k++)
        new_omega[k] = (gas_rotation == NULL ? 0.0 : gas_rotation[k]) - share_left * slip[k];
}
