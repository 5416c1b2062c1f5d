/* -- sizes and shapes of grains --------------------------------------------------------------------

   Volumes, moments of inertia and surfaces of grains with the half-sizes a, b and c. Lengths are in m;
   moments of inertia are over m a^2. Formulae of the shapes: tables/LAWS.md. */

/* Volume of a shape over a b c, by its code; 0 for a mesh. */
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
        const double *ratios = law->shape_ratios + 2 * row;
        const int are_drawn = ratios[0] == 0.0;
        const double grain[3] = {(double)law->shape_codes[row], are_drawn ? 1.0 : ratios[0],
                                 are_drawn ? 1.0 : ratios[1]};
        const double half = rbt_half_size(diameter, grain);
        if (half == 0.0)
            return 0.0;
        sum += (law->shape_shares[row] - before) * half *
               (are_drawn ? rbti_mean_power(law->aspect, -2.0 / 3.0) *
                            rbti_mean_power(law->aspect + 4, -1.0 / 3.0)
                      : 1.0);
        before = law->shape_shares[row];
    }
    return sum;
}

RBT_API RBT_DEVICE double rbt_moment_of_inertia(const rbt_table *table, uint64_t seed, uint64_t index,
                                                double inertia, double mass, double half_size,
                                                double diameter)
{
    double grain[3];
    if (!(inertia > 0.0) && rbt_grains(table, 1, seed, &index, NULL, grain) == RBT_OK)
        inertia = rbt_inertia(grain);
    return inertia > 0.0 ? inertia * mass * half_size * half_size : 0.1 * mass * diameter * diameter;
}
