/* -- spheres --------------------------------------------------------------------------------------

   A rebound of a sphere follows from its laws of contact by a formula, without random numbers; sources:
   tables/LAWS.md. Velocities are over V and spins over V/a. The laws are stored as the numbers of the
   enumeration below, then the numbers of the law of restitution, then those of the law of resistance. If
   one of them is a table, it begins with the numbers of its angles and of its speeds; then come the
   angles, rad, the speeds, m/s, and the values by angle. */
enum {
    RBTI_RESOLUTION, RBTI_RESTITUTION, RBTI_COEFFICIENT, RBTI_EXPONENT, RBTI_RESISTANCE,
    RBTI_STRENGTH, RBTI_FACTOR, RBTI_LENGTH, RBTI_NUMBERS
};
/* begin laws */
enum { RBTI_RESTITUTION_EXPONENTIAL, RBTI_RESTITUTION_POLYNOMIAL, RBTI_RESTITUTION_CONSTANT,
       RBTI_RESTITUTION_POWER, RBTI_RESTITUTION_TABULATED, RBTI_RESTITUTION_LAWS };
enum { RBTI_RESISTANCE_EXPONENTIAL_ORIENTATION, RBTI_RESISTANCE_CONSTANT,
       RBTI_RESISTANCE_TABULATED, RBTI_RESISTANCE_COULOMB, RBTI_RESISTANCE_LAWS };
/* end laws */
#define RBTI_SPHERE_INERTIA 0.4
#define RBTI_MOBILITY 3.5 /* of the contact of a sphere, along the wall */
#define RBTI_GRAZING 0.0087 /* sine of the impact angle below which the resolution shrinks to 0 */
#define RBTI_LEAST_ANGLE 1e-300

/* Lower one of the two neighbours of x among growing numbers, and the weight of the upper one. */
RBTI_INLINE RBT_DEVICE int rbti_lower_neighbour(const double *nodes, int count, double x, double *weight)
{
    int k = 0;
    while (k < count - 2 && nodes[k + 1] <= x)
        k++;
    *weight = count > 1 ? rbti_bounded((x - nodes[k]) / (nodes[k + 1] - nodes[k]), 0.0, 1.0) : 0.0;
    return k;
}

/* Value of a table of angles and speeds: bilinear, and constant beyond its ends. */
RBTI_INLINE RBT_DEVICE double rbti_tabulated(const double *table, double angle, double speed)
{
    const int n = (int)table[0], m = (int)table[1], right = m > 1;
    double p, q;
    const int i = rbti_lower_neighbour(table + 2, n, angle, &p);
    const int j = rbti_lower_neighbour(table + 2 + n, m, speed, &q);
    const double *low = table + 2 + n + m + i * m + j, *high = low + (n > 1 ? m : 0);
    return (1.0 - p) * ((1.0 - q) * low[0] + q * low[right]) +
           p * ((1.0 - q) * high[0] + q * high[right]);
}

/* Restitution: the normal contact velocity after over that before. From 0 to 1, whatever the numbers
   are. */
RBTI_INLINE RBT_DEVICE double rbti_restitution(const double *law, double speed, double sine)
{
    const double c = law[RBTI_COEFFICIENT], exponent = law[RBTI_EXPONENT], angle = asin(sine);
    const int kind = (int)law[RBTI_RESTITUTION];
    double e = c;
    if (kind == RBTI_RESTITUTION_EXPONENTIAL)
        e = 1.0 + (exp(-c * pow(speed, exponent)) - 1.0) * sine;
    else if (kind == RBTI_RESTITUTION_POWER)
        e = c / pow(speed * sine, exponent);
    else if (kind == RBTI_RESTITUTION_TABULATED)
        e = rbti_tabulated(law + RBTI_NUMBERS, angle, speed);
    else if (kind == RBTI_RESTITUTION_POLYNOMIAL) {
        e = 0.0;
        for (int k = (int)law[RBTI_LENGTH] - 1; k >= 0; k--)
            e = e * angle + law[RBTI_NUMBERS + k];
    }
    return rbti_bounded(e, 0.0, 1.0);
}

/* Normal velocity after an impact that would leave the velocity `bounce`, of the one before it. */
RBTI_INLINE RBT_DEVICE double rbti_velocity_away(const double *law, double bounce, double before)
{
    const double least = law[RBTI_RESOLUTION] * rbti_bounded(before / RBTI_GRAZING, 0.0, 1.0);
    return bounce > least ? bounce : least;
}

/* Tangential impulse over minus the tangential contact velocity, whose size is `slide`. `normal` is the
   normal impulse; `size` is the size of the contact velocity and `sine` the sine of its angle; `ahead` is
   the sine of the impact angle. */
RBTI_INLINE RBT_DEVICE double rbti_tangential_impulse(const rbt_table *table, double normal,
                                                      double slide, double size, double sine,
                                                      double ahead)
{
    const double *law = table->laws;
    const int kind = (int)law[RBTI_RESISTANCE], before = RBTI_NUMBERS + (int)law[RBTI_LENGTH];
    const double number =
        before < table->n_law_parameters ? rbti_tabulated(law + before, asin(sine), 1.0) : 0.0;
    if (kind == RBTI_RESISTANCE_COULOMB) {
        const double back = (1.0 + rbti_bounded(number, -1.0, 1.0)) / RBTI_MOBILITY;
        return slide > 0.0 ? rbti_bounded(law[RBTI_FACTOR] * normal / slide, 0.0, back) : 0.0;
    }
    double c = kind == RBTI_RESISTANCE_TABULATED ? number : law[RBTI_FACTOR];
    if (kind == RBTI_RESISTANCE_EXPONENTIAL_ORIENTATION)
        c *= exp(law[RBTI_STRENGTH] * ahead);
    c = rbti_bounded(c, 0.0, 1e9) / size * normal;
    return c / (1.0 + 0.5 * RBTI_MOBILITY * c);
}

/* Velocities u and v of a sphere after an impact without spin, by tables of restitution and resistance,
   without functions of the C library. */
RBTI_INLINE RBT_DEVICE void rbti_tabulated_sphere(const double *law, double angle, double speed,
                                                  double u, double v, double after[2])
{
    const double *first = law + RBTI_NUMBERS, *second = first + (int)law[RBTI_LENGTH];
    const double bounce = rbti_bounded(rbti_tabulated(first, angle, speed), 0.0, 1.0) * v;
    const double away = rbti_velocity_away(law, bounce, v);
    const double c = rbti_bounded(rbti_tabulated(second, angle, 1.0), 0.0, 1e9) * (away + v);
    after[0] = u - c / (1.0 + 0.5 * RBTI_MOBILITY * c) * u;
    after[1] = away;
}

/* Rebound of a sphere: all variables of its state. `spin` may be NULL. The rotational energy is over the
   kinetic energy before, works are over m V^2 / 2. No energy is gained, whatever the numbers of the
   laws. */
RBTI_INLINE RBT_DEVICE void rbti_rebound_sphere(const rbt_table *table, double alpha1, double speed,
                                        const double *spin, double values[RBT_VALUES])
{
    const double angle = rbti_bounded(alpha1, RBTI_LEAST_ANGLE, RBTI_HALF_PI);
    const double j = RBTI_SPHERE_INERTIA, *law = table->laws;
    const double x = spin ? spin[0] : 0.0, y = spin ? spin[1] : 0.0, z = spin ? spin[2] : 0.0;
    const double u = cos(angle), v = sin(angle), slide = sqrt((u + z) * (u + z) + x * x);
    const double size = sqrt(slide * slide + v * v), sine = v < size ? v / size : 1.0;
    const double bounce = rbti_restitution(law, speed * size, sine) * v;
    const double away = rbti_velocity_away(law, bounce, v);
    const double pull = rbti_tangential_impulse(table, away + v, slide, size, sine, v);
    const double turn_x = x - pull / j * x, turn_z = z - pull / j * (u + z);
    const double energy = 1.0 + j * (x * x + y * y + z * z);
    values[RBT_U] = u - pull * (u + z);
    values[RBT_V] = away;
    values[RBT_W] = pull * x;
    values[RBT_OMEGA_X] = turn_x;
    values[RBT_OMEGA_Y] = y;
    values[RBT_OMEGA_Z] = turn_z;
    values[RBT_ROTATIONAL_ENERGY] = j * (turn_x * turn_x + y * y + turn_z * turn_z) / energy;
    values[RBT_COLLISIONS] = 1.0;
    values[RBT_WORK_NORMAL] = (v - away) * (v + away);
    values[RBT_WORK_SHEAR] = pull * (2.0 - pull * RBTI_MOBILITY) * slide * slide;
}

/* The first variables of a sphere's state; 0 for those that the table lacks. */
RBTI_NOT_INLINED RBT_DEVICE void rbti_sphere_state(const rbt_table *table, double alpha1,
                                                   double speed, const double *spin, int variables,
                                                   double *state)
{
    double values[RBT_VALUES];
    rbti_rebound_sphere(table, alpha1, speed, spin, values);
    for (int k = 0; k < variables; k++)
        state[k] = rbti_has_variable(table, k) ? values[k] : 0.0;
}
