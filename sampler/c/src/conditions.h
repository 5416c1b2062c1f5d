/* -- spin draw, steps 1 to 3: the condition, its leaf, its features --------------------------------

   From the condition of an impact to the features of tables/FORMAT.md, "The spin law", steps 1 to 3.
   Powers and logarithms are computed here, and not by a library, so that their bits are the same
   everywhere. */

/* Limit an exponent from below, since no weight counts below 2^-126. The result is used in a separate
   loop, because compilers branch on a number that may be a constant. */
RBTI_INLINE RBT_DEVICE float rbti_least_power(float y)
{
    return y > -126.0f ? y : -126.0f;
}

/* 2^y, for y from -126 to 0. */
RBTI_INLINE RBT_DEVICE float rbti_power_of_two(float y)
{
    const int32_t n = (int32_t)(y - 0.5f);
    const float r = y - (float)n;
    const float p =
        1.0f +
        r * (0.6931471805599453f +
             r * (0.2402265069591007f +
                  r * (0.05550410866482158f +
                       r * (0.009618129107628477f +
                            r * (0.0013333558146428443f + r * 0.00015403530393381608f)))));
    const uint32_t bits = (uint32_t)(n + 127) << 23;
    float power;
    memcpy(&power, &bits, sizeof power);
    return p * power;
}

/* Logarithm to the base 2 of a positive number. */
RBTI_INLINE RBT_DEVICE float rbti_logarithm_to_two(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    bits -= 0x3f3504f3u; /* 1 / sqrt(2) */
    const float exponent = (float)((int32_t)bits >> 23);
    bits = (bits & 0x7fffffu) + 0x3f3504f3u;
    float mantissa;
    memcpy(&mantissa, &bits, sizeof mantissa);
    const float s = (mantissa - 1.0f) / (mantissa + 1.0f), q = s * s;
    return exponent +
           s * (2.8853900817779268f +
                q * (0.9617966939259757f +
                     q * (0.5770780163555854f +
                          q * (0.41219858311113243f + q * 0.3205988979753252f))));
}

/* Coordinate of the speed of a contact, exp(-k (V q)^n), from V q in m/s. */
RBTI_INLINE RBT_DEVICE void rbti_fill_speed_coordinate(size_t m, const rbt_spin_law *law,
                                                       const double *speed, double *values)
{
    const float exponent = (float)law->speed_exponent, scale = -(float)law->speed_scale;
    const double last = law->speed_last;
    float y[RBTI_BLOCK] RBTI_ALIGNED;
    RBTI_EACH_DRAW(r) {
        const float power = exponent * rbti_logarithm_to_two((float)(speed[r] / last));
        y[r] = rbti_least_power(power < 0.0f ? power : 0.0f);
    }
    RBTI_EACH_DRAW(r) {
        const float x = scale * rbti_power_of_two(y[r]);
        y[r] = rbti_least_power(x * RBTI_LOG2_E);
    }
    RBTI_EACH_DRAW(r)
        values[r] = (double)rbti_power_of_two(y[r]);
}

/* The smallest and the largest moment of inertia of each grain, over m a^2. */
RBTI_INLINE RBT_DEVICE void rbti_fill_moments(size_t m, const rbt_population *population,
                                              rbti_spin_draws *d)
{
    const double *b_a = d->inputs + RBTI_IN_B_A * m, *c_b = d->inputs + RBTI_IN_C_B * m;
    double g1[RBTI_BLOCK] RBTI_ALIGNED, g3[RBTI_BLOCK] RBTI_ALIGNED;
    RBTI_EACH_DRAW(r) {
        g1[r] = population->shape_inertia[2 * d->shape[r]];
        g3[r] = population->shape_inertia[2 * d->shape[r] + 1];
    }
    RBTI_EACH_DRAW(r) {
        const double b = b_a[r] * b_a[r], most = g1[r] * (1.0 + b);
        d->least[r] = g3[r] * b * (1.0 + c_b[r] * c_b[r]);
        d->most[r] = most > d->least[r] ? most : d->least[r];
    }
}

/* Place kappa of an inertia between two moments of inertia, 0 at the smaller and 1 at the larger. With P
   linear in 1 / k it is sqrt(P) / (sqrt(P) + sqrt(1 - P)). Between equal moments it is 1/2. */
RBTI_INLINE RBT_DEVICE double rbti_kappa(double inertia, double least, double most)
{
    const double range = most - least;
    const int apart = range > RBTI_EQUAL_MOMENTS * most;
    const double share = most * (inertia - least) / (inertia * (apart ? range : 1.0));
    const double root = sqrt(rbti_bounded(share, 0.0, 1.0));
    const double other = sqrt(1.0 - rbti_bounded(share, 0.0, 1.0));
    return apart ? root / (root + other) : 0.5;
}

/* Inertia at the place kappa between two moments of inertia. */
RBTI_INLINE RBT_DEVICE double rbti_inertia_at(double kappa, double least, double most)
{
    const double range = most - least, square = kappa * kappa;
    const double other = (1.0 - kappa) * (1.0 - kappa);
    const double share = range > RBTI_EQUAL_MOMENTS * most ? square / (square + other) : 1.0;
    return rbti_bounded(least * most / (most - share * range), least, most);
}

/* Place kappa of an inertia that rebounds of a shape leave, drawn by a random word. */
RBTI_INLINE RBT_DEVICE double rbti_drawn_kappa(const rbt_spin_law *law, int32_t shape,
                                               uint32_t word)
{
    const double *quantiles = law->kappa_quantiles + RBTI_KAPPA_QUANTILES * shape;
    const double position = rbti_uniform(word) * (RBTI_KAPPA_QUANTILES - 1);
    const int32_t k = (int32_t)position; /* below the last: the uniform number is below 1 */
    return quantiles[k] + (position - k) * (quantiles[k + 1] - quantiles[k]);
}

/* Inertias about the spin, and their places kappa. An inertia is limited to what the grain can have, and
   is_beyond[r] says whether it lay beyond; an inertia that is not known is drawn. Without a spin kappa is
   1/2, and the inertia the mean of both moments. */
RBTI_INLINE RBT_DEVICE void rbti_fill_inertia(size_t m, const rbt_spin_law *law, rbti_spin_draws *d,
                                              int *is_beyond)
{
    double square[RBTI_BLOCK] RBTI_ALIGNED;
    int unknown[RBTI_BLOCK] RBTI_ALIGNED, any = 0;
    RBTI_EACH_DRAW(r) {
        const double inertia = d->inertia[r], least = d->least[r], most = d->most[r];
        const double known = rbti_bounded(inertia, least, most);
        square[r] = rbti_square(d->spin[r], d->spin[m + r], d->spin[2 * m + r]);
        is_beyond[r] = rbti_inertia_is_beyond(inertia, square[r], least, most);
        unknown[r] = (inertia <= 0.0) & (square[r] > 0.0);
        any |= unknown[r];
        d->inertia[r] = square[r] > 0.0 ? known : 0.5 * (least + most);
        d->kappa[r] = square[r] > 0.0 ? rbti_kappa(known, least, most) : 0.5;
    }
    for (size_t r = 0; r < m && any; r++) {
        if (!unknown[r])
            continue;
        const int apart = d->most[r] - d->least[r] > RBTI_EQUAL_MOMENTS * d->most[r];
        const double drawn = rbti_drawn_kappa(law, d->shape[r], d->words[11 * m + r]);
        d->kappa[r] = apart ? drawn : 0.5;
        d->inertia[r] = rbti_inertia_at(drawn, d->least[r], d->most[r]);
    }
}

/* Input of a component of sigma along the wall. Its root spreads small tilts of the spin, by which a grain
   leaves rolling. */
RBTI_INLINE RBT_DEVICE double rbti_tilt(double sigma)
{
    return sigma / sqrt((sigma < 0.0 ? -sigma : sigma) + RBTI_TILT_CORE);
}

/* -1 if a draw is made at the mirror image of its condition, else 1. The law is stored for a positive
   input of sigma_x only, so a negative one is mirrored. Within RBTI_FOLD of 0 either image is taken, with a chance
   that goes from 0 to 1 across the fold; so the law is continuous there, and mirror images of a condition
   have mirror images of one law. The chance takes the bits of words 0 and 1 that step 4 does not use. */
RBTI_INLINE RBT_DEVICE double rbti_mirror_sign(double tilt_x, uint32_t word_0, uint32_t word_1)
{
    const double chance = 0.5 + tilt_x * (0.5 / RBTI_FOLD);
    const uint32_t bits = (word_0 & 0xffu) << 8 | (word_1 & 0xffu);
    return ((double)(int32_t)bits + 0.5) / 65536.0 < chance ? 1.0 : -1.0;
}

/* Coordinate sigma of a spin, over the spin; `square` is the square of its size. The coordinate keeps the
   direction of a slow spin, because the law depends on it however slow the spin is. */
RBTI_INLINE RBT_DEVICE double rbti_sigma_over_spin(double square)
{
    const double core = RBTI_SPIN_CORE / sqrt(square > 0.0 ? square : 1.0);
    return (square > 0.0 ? core : 0.0) + 1.0 / sqrt(sqrt(1.0 + square));
}

/* Cosine and sine of an angle from 0 to pi / 2, by Taylor series about pi / 4. */
RBTI_INLINE RBT_DEVICE void rbti_cosine_and_sine(double angle, double *cosine, double *sine)
{
    const double x = angle - 0.5 * RBTI_HALF_PI, q = -x * x;
    double even = 1.0 + q * (1.0 / 240.0), odd = 1.0 + q * (1.0 / 210.0);
    even = 1.0 + q * (1.0 / 182.0) * even;
    odd = 1.0 + q * (1.0 / 156.0) * odd;
    even = 1.0 + q * (1.0 / 132.0) * even;
    odd = 1.0 + q * (1.0 / 110.0) * odd;
    even = 1.0 + q * (1.0 / 90.0) * even;
    odd = 1.0 + q * (1.0 / 72.0) * odd;
    even = 1.0 + q * (1.0 / 56.0) * even;
    odd = 1.0 + q * (1.0 / 42.0) * odd;
    even = 1.0 + q * (1.0 / 30.0) * even;
    odd = 1.0 + q * (1.0 / 20.0) * odd;
    even = 1.0 + q * (1.0 / 12.0) * even;
    odd = 1.0 + q * (1.0 / 6.0) * odd;
    even = 1.0 + q * 0.5 * even;
    odd = x * odd;
    *cosine = RBTI_ROOT_HALF * (even - odd);
    *sine = RBTI_ROOT_HALF * (even + odd);
}

/* The nominal contact of each draw, from its angle, and from the spin that it is drawn with, in d->spin:
   what outcomes are relative to, the speed q of the contact, and its slip among the inputs. */
RBTI_INLINE RBT_DEVICE void rbti_fill_contact(size_t m, const double *angle, rbti_spin_draws *d,
                                              double *speed)
{
    const double *b_a = d->inputs + RBTI_IN_B_A * m, *c_b = d->inputs + RBTI_IN_C_B * m;
    double *slip = d->inputs + RBTI_IN_SLIP * m;
    double u[RBTI_BLOCK] RBTI_ALIGNED, v[RBTI_BLOCK] RBTI_ALIGNED;
    RBTI_EACH_DRAW(r)
        rbti_cosine_and_sine(angle[r], u + r, v + r);
    RBTI_EACH_DRAW(r) {
        const double b = b_a[r], c = b * c_b[r], kappa = d->kappa[r], other = 1.0 - kappa;
        const double x = d->spin[r], y = d->spin[m + r], z = d->spin[2 * m + r];
        const double square = rbti_square(x, y, z), k = d->inertia[r];
        const double rho = 0.5 * (b + c) + 0.5 * kappa * (1.0 - c);
        const double first = (1.0 - b) * kappa, second = (b - c) * other, third = 1.0 - c;
        const double wobble = first * first + second * second +
                              RBTI_WOBBLE * kappa * other * third * third;
        const double ahead = u[r] + rho * z, across = rho * x;
        const double scatter = (0.5 * wobble + RBTI_LEAST_WOBBLE) * square;
        const double q = sqrt(ahead * ahead + across * across + v[r] * v[r] + scatter);
        const double energy = 1.0 + k * square, per_energy = 1.0 / sqrt(energy);
        const double per_size = 1.0 / sqrt(k + rho * rho), root = sqrt(k);
        const double cosine = root * per_size, sine = rho * per_size;
        const double turning = root * sqrt(square);
        const double delta = (q < turning ? q / turning : 1.0) * d->tilt[r];
        const double part = q * per_energy, share = part < 1.0 ? part : 1.0;
        const double apart = (1.0 - share * share) * per_energy;
        speed[r] = q;
        slip[r] = ahead / q;
        d->energy[r] = energy;
        d->cosine[r] = cosine;
        d->sine[r] = sine;
        d->o_unit[r] = share;
        d->odds[r] = kappa + delta;
        d->odds[m + r] = other + delta;
        d->h_unit[r] = delta / (kappa * other + delta);
        const int mirrored = d->mirrored[r];
        const double aside = mirrored ? per_energy : apart;
        d->rise[r] = mirrored ? sqrt(v[r] * v[r] + RBTI_RISE * scatter) / q : 1.0;
        d->slide[r] = mirrored ? -ahead * across / (q * q) : 0.0;
        d->direction[3 * m + r] = mirrored ? v[r] / (d->rise[r] * q) : 0.0;
        d->base[r] = aside * root * x * cosine;
        d->base[m + r] = aside * root * y;
        d->base[2 * m + r] = apart * (root * z * cosine - u[r] * sine);
    }
}

/* Ellipsoids without spin, in a table of a tabulated law: their outcomes count from the rebound of a sphere,
   in units of how far the grain is from round. All other draws are by themselves. */
RBTI_INLINE RBT_DEVICE void rbti_fill_spheres(size_t m, const rbt_table *table, const double *angle,
                                              const double *speed, rbti_spin_draws *d)
{
    RBTI_EACH_DRAW(r)
        d->by_sphere[r] = 0;
    for (size_t r = 0; r < m && table->laws; r++) {
        double u, v, after[2];
        if (table->population.shape_codes[d->shape[r]] != RBT_ELLIPSOID ||
            d->inputs[RBTI_IN_SQUARE * m + r] > 0.0)
            continue;
        rbti_cosine_and_sine(angle[r], &u, &v);
        rbti_tabulated_sphere(table->laws, angle[r], speed[r], u, v, after);
        const double ratio = d->inputs[RBTI_IN_B_A * m + r] * d->inputs[RBTI_IN_C_B * m + r];
        const double shape = 2.0 * (1.0 - ratio) + RBTI_ROUND_CORE;
        const double out_of_round = shape < 1.0 ? shape : 1.0;
        const double slower = u - after[0], normal = v + after[1], shear = 2.0 * slower;
        const double squares = after[0] * after[0] + after[1] * after[1];
        const double taken = (v - after[1]) * normal + slower * (2.0 * u - RBTI_MOBILITY * slower);
        const double least = RBTI_LEAST_TAKEN * squares, most = taken > least ? taken : least;
        const double per_p = out_of_round / sqrt(most);
        d->by_sphere[r] = 1;
        d->sphere[r] = after[0];
        d->sphere[m + r] = after[1];
        d->taken[r] = most;
        d->p_unit[r] = per_p * (normal + shear);
        d->p_unit[m + r] = per_p * (shear + 0.1 * out_of_round * normal);
        d->o_unit[r] = out_of_round * (normal + shear < 1.0 ? normal + shear : 1.0);
        d->base[r] = d->base[m + r] = 0.0;
        d->base[2 * m + r] = (out_of_round - 1.0) * u * d->sine[r];
    }
}

/* Step 1: the inputs of the condition, and its flags. The spin becomes the one that is drawn with, which
   is not longer than the law covers, and belongs to the mirror image if that is drawn. */
RBTI_INLINE RBT_DEVICE void rbti_fill_inputs(size_t m, const rbt_table *table, rbti_spin_draws *d,
                                             int *flags)
{
    const rbt_spin_law *law = &table->spin;
    double effective[RBTI_BLOCK] RBTI_ALIGNED, speed[RBTI_BLOCK] RBTI_ALIGNED;
    double angle[RBTI_BLOCK] RBTI_ALIGNED, *inputs = d->inputs;
    float place[RBTI_BLOCK] RBTI_ALIGNED;
    int inertia_is_beyond[RBTI_BLOCK] RBTI_ALIGNED;
    rbti_fill_moments(m, &table->population, d);
    rbti_fill_inertia(m, law, d, inertia_is_beyond);
    RBTI_EACH_DRAW(r) {
        const double x = d->spin[r], y = d->spin[m + r], z = d->spin[2 * m + r];
        const double square = rbti_square(x, y, z), most = law->most_spin;
        const double covered = square < most ? square : most;
        const double shorter = square > most ? sqrt(most / square) : 1.0;
        const double root = sqrt(1.0 + d->inertia[r] * covered);
        const double scale = rbti_sigma_over_spin(covered) * shorter;
        const double tilt_x = rbti_tilt(scale * x), other = 1.0 - d->kappa[r];
        const double per_size = 1.0 / (square > 0.0 ? sqrt(square) : 1.0);
        const double tilt = sqrt(rbti_square(x * per_size, y * per_size, RBTI_LEAST_TILT)) + other;
        const int mirrored = (table->population.shape_codes[d->shape[r]] == RBT_ELLIPSOID) & (square > 0.0);
        const double sign = rbti_mirror_sign(tilt_x, d->words[r], d->words[m + r]);
        flags[r] = rbti_spin_flags(table, d->alpha1[r], d->speed[r], root, square,
                                   inertia_is_beyond[r]);
        effective[r] = rbti_effective_speed(table, d->speed[r], root) / root;
        angle[r] = rbti_bounded(d->alpha1[r], law->alpha_first, law->alpha_last);
        inputs[RBTI_IN_ROOT_ANGLE * m + r] = sqrt(angle[r]);
        inputs[RBTI_IN_SIGMA_X * m + r] = sign * tilt_x;
        inputs[RBTI_IN_SIGMA_Y * m + r] = sign * rbti_tilt(scale * y);
        inputs[RBTI_IN_SIGMA_Z * m + r] = scale * z;
        inputs[RBTI_IN_SQUARE * m + r] = scale * scale * square;
        d->spin[r] = sign * (shorter * x);
        d->spin[m + r] = sign * (shorter * y);
        d->spin[2 * m + r] = shorter * z;
        d->sign[r] = sign;
        const double direction = mirrored ? sign * per_size / tilt : 0.0;
        d->mirrored[r] = mirrored;
        d->tilt[r] = tilt;
        d->side_unit[r] = mirrored ? tilt : 1.0;
        d->direction[r] = direction * x;
        d->direction[m + r] = direction * y;
        d->direction[2 * m + r] = mirrored ? other / tilt : 0.0;
        place[r] = (float)((d->kappa[r] + RBTI_PLACE_CORE) / (1.0 - d->kappa[r] + RBTI_PLACE_CORE));
        place[r] = RBTI_LOG_2 * rbti_logarithm_to_two(place[r]);
    }
    rbti_fill_contact(m, angle, d, speed);
    rbti_fill_spheres(m, table, angle, effective, d);
    RBTI_EACH_DRAW(r) {
        effective[r] *= speed[r];
        inputs[RBTI_IN_PLACE * m + r] = (double)place[r];
        /* from here on the law needs the ratios no more, but how far they are from 1 */
        inputs[RBTI_IN_B_A * m + r] = sqrt(1.0 - inputs[RBTI_IN_B_A * m + r]);
        inputs[RBTI_IN_C_B * m + r] = sqrt(1.0 - inputs[RBTI_IN_C_B * m + r]);
    }
    rbti_fill_speed_coordinate(m, law, effective, inputs + RBTI_IN_SPEED * m);
}

/* Prefetch 16-bit numbers of a table. */
RBTI_INLINE RBT_DEVICE void rbti_prefetch(const int16_t *numbers, size_t count)
{
    for (size_t k = 0; k < count; k += RBTI_LINE)
        RBTI_PREFETCH(numbers + k);
}

/* Step 2: the leaf of each draw in the tree of its shape. A negative child means the leaf -1 - child. All
   draws go down a level at a time, so that the processor need not guess where a path ends. */
RBTI_INLINE RBT_DEVICE void rbti_find_leaves(size_t m, const rbt_spin_law *law, rbti_spin_draws *d)
{
    const size_t numbers = RBTI_FEATURES * RBTI_GROUPS;
    int32_t node[RBTI_BLOCK] RBTI_ALIGNED;
    int on_the_way = 1;
    RBTI_EACH_DRAW(r)
        node[r] = law->roots[d->shape[r]];
    while (on_the_way) {
        on_the_way = 0;
        RBTI_EACH_DRAW(r) {
            const int32_t at = node[r] < 0 ? 0 : node[r]; /* any node does where the path has ended */
            const double value = d->inputs[(size_t)law->node_axis[at] * m + r];
            const int32_t child = law->node_child[2 * at + (value >= law->node_cut[at])];
            node[r] = node[r] < 0 ? node[r] : child;
            on_the_way |= node[r] >= 0;
        }
    }
    RBTI_EACH_DRAW(r) {
        d->leaf[r] = -1 - node[r];
        RBTI_PREFETCH(law->inputs + 2 * RBTI_INPUTS * (size_t)d->leaf[r]);
    }
    RBTI_EACH_DRAW(r)
        rbti_prefetch(law->group_gates + numbers * (size_t)d->leaf[r], numbers);
}

/* Step 3: the features. They are 1, the inputs t relative to the middle of the leaf, the products of
   two of them, and the directions. */
RBTI_INLINE RBT_DEVICE void rbti_fill_features(size_t m, const rbt_spin_law *law,
                                               rbti_spin_draws *d)
{
    float *features = d->features;
    RBTI_EACH_DRAW(r)
        features[r] = 1.0f;
    for (size_t k = 0; k < RBTI_INPUTS; k++) {
        const double *inputs = d->inputs + (k < RBTI_IN_SQUARE ? k : k + 1) * m; /* without it */
        float middle[RBTI_BLOCK] RBTI_ALIGNED, scale[RBTI_BLOCK] RBTI_ALIGNED;
        RBTI_EACH_DRAW(r) {
            const float *input = law->inputs + 2 * RBTI_INPUTS * (size_t)d->leaf[r] + k;
            middle[r] = input[0];
            scale[r] = input[RBTI_INPUTS];
        }
        RBTI_EACH_DRAW(r)
            features[(1 + k) * m + r] = ((float)inputs[r] - middle[r]) * scale[r];
    }
    float *product = features + (1 + RBTI_INPUTS) * m;
    for (size_t i = 1; i <= RBTI_INPUTS; i++) {
        for (size_t j = i; j <= RBTI_INPUTS; j++) {
            RBTI_EACH_DRAW(r)
                product[r] = features[i * m + r] * features[j * m + r] - (i == j ? 0.5f : 0.0f);
            product += m;
        }
    }
    for (size_t k = 0; k < RBTI_DIRECTIONS * m; k++)
        product[k] = (float)d->direction[k];
}
