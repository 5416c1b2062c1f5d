/* -- sizes and shapes of grains --------------------------------------------------------------------

   Volumes, moments of inertia and surfaces of grains with the half-sizes a, b and c. Lengths are in m;
   moments of inertia are over m a^2. Formulae of the shapes: tables/LAWS.md. */

/* Volume, mean moment of inertia and two numbers of the surface of a shape, as spin/shape_geometry in
   tables/FORMAT.md has them; NULL for a shape that the table does not have. */
RBTI_INLINE RBT_DEVICE const double *rbti_geometry(const rbt_table *table, double shape)
{
    if (!table)
        return NULL;
    const int32_t row = rbti_row_of_shape(&table->population, shape);
    return row < table->population.n_shapes ? table->population.shape_geometry + 4 * row : NULL;
}

RBTI_INLINE RBT_DEVICE double rbti_half_size(const double geometry[4], double diameter,
                                             const double grain[3])
{
    const double volume = geometry[0] * grain[1] * grain[1] * grain[2];
    return volume > 0.0 ? 0.5 * diameter * cbrt(4.0 / 3.0 * RBTI_PI / volume) : 0.0;
}

RBTI_INLINE RBT_DEVICE double rbti_inertia(const double geometry[4], const double grain[3])
{
    const double b = grain[1], c = b * grain[2];
    return geometry[1] * (1.0 + b * b + c * c);
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

RBTI_INLINE RBT_DEVICE double rbti_sphericity(const double geometry[4], const double grain[3])
{
    const double b = grain[1], c = b * grain[2], half = rbti_half_size(geometry, 2.0, grain);
    double surface = geometry[2] * (b + b * c + c) +
                     geometry[3] * sqrt(b * b + c * c + b * b * c * c);
    if (surface == 0.0) /* of an ellipsoid */
        surface = 4.0 * RBTI_PI * rbti_ellipsoid_surface(b, c);
    return half > 0.0 ? 4.0 * RBTI_PI / (half * half * surface) : 0.0;
}

RBT_API RBT_DEVICE double rbt_half_size(const rbt_table *table, double diameter,
                                        const double grain[3])
{
    const double *geometry = rbti_geometry(table, grain[0]);
    return geometry ? rbti_half_size(geometry, diameter, grain) : 0.0;
}

RBT_API RBT_DEVICE double rbt_mean_inertia(const rbt_table *table, const double grain[3])
{
    const double *geometry = rbti_geometry(table, grain[0]);
    return geometry ? rbti_inertia(geometry, grain) : 0.0;
}

RBT_API RBT_DEVICE double rbt_sphericity(const rbt_table *table, const double grain[3])
{
    const double *geometry = rbti_geometry(table, grain[0]);
    return geometry ? rbti_sphericity(geometry, grain) : 0.0;
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
    const rbt_population *population = &table->population;
    double before = 0.0, sum = 0.0;
    for (int32_t row = 0; row < population->n_shapes; row++) {
        const double *ratios = population->shape_ratios + 2 * row;
        const int are_drawn = ratios[0] == 0.0;
        const double grain[3] = {(double)population->shape_codes[row], are_drawn ? 1.0 : ratios[0],
                                 are_drawn ? 1.0 : ratios[1]};
        sum += (population->shape_shares[row] - before) * rbt_half_size(table, diameter, grain) *
               (are_drawn ? rbti_mean_power(population->aspect, -2.0 / 3.0) *
                            rbti_mean_power(population->aspect + 4, -1.0 / 3.0)
                      : 1.0);
        before = population->shape_shares[row];
    }
    return sum;
}

RBT_API RBT_DEVICE double rbt_moment_of_inertia(const rbt_table *table, uint64_t seed, uint64_t index,
                                                double inertia, double mass, double half_size,
                                                double diameter)
{
    double grain[3];
    if (!(inertia > 0.0) && rbt_grains(table, 1, seed, &index, NULL, grain) == RBT_OK)
        inertia = rbt_mean_inertia(table, grain);
    return inertia > 0.0 ? inertia * mass * half_size * half_size : 0.1 * mass * diameter * diameter;
}
