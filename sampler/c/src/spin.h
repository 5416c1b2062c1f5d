/* -- the spin draw --------------------------------------------------------------------------------

   The law of particles that arrive spinning, given their spin and their grain: shape, b/a and c/b. Each
   shape has a tree of conditions; a leaf has 8 groups of 16 experts and the quantile functions of O = 6
   outcomes, p_u, p_v, p_w and omega_x, omega_y, omega_z times a/V_e, or of O = 8, with two for the
   works. The steps are those of tables/FORMAT.md, "The spin law":

     words  rbti_fill_words, rbti_fill_grains  random words; the grain, from words of its own
     1      rbti_fill_inputs     effective speed V_e = V (1 + 2/3 s^2)^(1/2), mirror image, conditions
     2      rbti_find_leaves     leaf of the shape's tree
     3      rbti_fill_features   1, inputs less the leaf's middle, products of two conditions
     4      rbti_choose_expert   a group, then an expert of it, with weights exp(gates . features)
     5      rbti_fill_scores     mean and factor of the expert: scores of O normals
     6      rbti_find_knots, rbti_fill_outcomes  bounded scores to outcomes by the leaf's quantiles
     7      rbti_to_spin_states  outcomes to the state, with no more energy than before, whatever the
                                 outcomes are

   Steps 3 to 6 are in single precision. Coefficients of a leaf or an expert that are multiplied by the
   features of a draw lie side by side in the table, and are taken draw by draw. The compiler knows O
   where it matters, in single draws and in the factors. */

/* Rows of the inputs of a draw: the conditions, the squared spin, which trees compare too, the ratios. */
#define RBTI_SQUARE RBTI_CONDITIONS
#define RBTI_RATIO (RBTI_CONDITIONS + 1)
#define RBTI_LINE 32 /* 16-bit numbers of a cache line */

typedef struct rbti_spin_draws {
    double alpha1[RBTI_BLOCK], speed[RBTI_BLOCK], spin[3 * RBTI_BLOCK];
    double inputs[(RBTI_INPUTS + 1) * RBTI_BLOCK];
    double factor[RBTI_BLOCK], turn[RBTI_BLOCK]; /* root of the energy before; -1: mirror image */
    double smallest[RBTI_BLOCK];                 /* moment of inertia of the grain, over m a^2 */
    uint32_t words[12 * RBTI_BLOCK];
    int32_t shape[RBTI_BLOCK], leaf[RBTI_BLOCK], group[RBTI_BLOCK], expert[RBTI_BLOCK];
    float features[RBTI_FEATURES * RBTI_BLOCK];
    float scores[RBTI_MOST_OUTCOMES * RBTI_BLOCK]; /* normals, then scores, then fractions of knots */
    int32_t entries[RBTI_MOST_OUTCOMES * RBTI_BLOCK];
    float outcomes[RBTI_MOST_OUTCOMES * RBTI_BLOCK];
} rbti_spin_draws;

/* Numbers of an expert with some outcomes, whole cache lines. */
RBTI_INLINE RBT_DEVICE size_t rbti_expert_stride(size_t outcomes)
{
    const size_t numbers = RBTI_FEATURES * outcomes + outcomes * (outcomes + 1) / 2;
    return (numbers + RBTI_LINE - 1) / RBTI_LINE * RBTI_LINE;
}

RBTI_INLINE RBT_DEVICE double rbti_spin_factor(double x, double y, double z)
{
    return sqrt(1.0 + RBTI_INERTIA * (x * x + y * y + z * z));
}

/* Flags of a condition with a spin, without branches. Where angle, speed and spin are in range but the
   effective speed is not, it is the spin that is beyond. */
RBTI_INLINE RBT_DEVICE int rbti_spin_flags(const rbt_table *table, double alpha1, double speed,
                                           double x, double y, double z)
{
    const rbt_spin_law *law = &table->spin;
    const double square = x * x + y * y + z * z, effective = speed * rbti_spin_factor(x, y, z);
    const int off = (square < law->least_spin) | (square > law->most_spin);
    const int fast = (effective > law->speed_high) & (speed <= table->speed.high);
    return rbti_flags(table, alpha1, speed) | (off | fast) * RBT_SPIN;
}

/* Whether the energy of an impact is a number. */
RBTI_INLINE RBT_DEVICE int rbti_has_energy(double speed, double x, double y, double z)
{
    const double effective = speed * rbti_spin_factor(x, y, z);
    return rbti_finite(effective * effective);
}

#ifdef RBTI_BLOCKS
RBTI_INLINE int rbti_spin_is_bad(double alpha1, double speed, double x, double y, double z)
{
    return rbti_is_bad(alpha1, speed) | (1 - rbti_has_energy(speed, x, y, z));
}
#endif

RBTI_INLINE RBT_DEVICE int rbti_spin_error(const rbt_table *table, double alpha1, double speed,
                                           double x, double y, double z, const double *grain)
{
    const int error = rbti_error(alpha1, speed);
    if (error < RBT_OK)
        return error;
    if (table->spin.n_shapes == 0)
        return RBT_ERR_NO_SPIN_LAW;
    if (!rbti_has_energy(speed, x, y, z))
        return RBT_ERR_NOT_FINITE;
    return !grain || rbti_grain_holds(&table->spin, grain) ? RBT_OK : RBT_ERR_GRAIN_NOT_KNOWN;
}

/* No weight counts below 2^-126. A clamped number is used in a loop of its own: compilers branch on a
   number that may be a constant. */
RBTI_INLINE RBT_DEVICE float rbti_least_power(float y)
{
    return y > -126.0f ? y : -126.0f;
}

/* 2^y of a number from -126 to 0; no library's, and the same in every language. */
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

/* exp(-k V_e^n), from V_e. */
RBTI_INLINE RBT_DEVICE void rbti_fill_speed_coordinate(size_t m, const rbt_spin_law *law,
                                                       const double *effective, double *values)
{
    const float exponent = (float)law->speed_exponent, scale = -(float)law->speed_scale;
    const double last = law->speed_last;
    float y[RBTI_BLOCK] RBTI_ALIGNED;
    RBTI_EACH_DRAW(r) {
        const float power = exponent * rbti_logarithm_to_two((float)(effective[r] / last));
        y[r] = rbti_least_power(power < 0.0f ? power : 0.0f);
    }
    RBTI_EACH_DRAW(r) {
        const float x = scale * rbti_power_of_two(y[r]);
        y[r] = rbti_least_power(x * RBTI_LOG2_E);
    }
    RBTI_EACH_DRAW(r)
        values[r] = (double)rbti_power_of_two(y[r]);
}

/* Moments of inertia of a grain over m a^2, the largest and the smallest. */
RBTI_INLINE RBT_DEVICE void rbti_moments(const rbt_spin_law *law, int32_t shape, double b_a,
                                         double c_b, double moments[2])
{
    const double *of = law->shape_inertia + 2 * shape, b = b_a * b_a;
    moments[0] = of[0] * (1.0 + b);
    moments[1] = of[1] * b * (1.0 + c_b * c_b);
}

RBTI_INLINE RBT_DEVICE void rbti_fill_moments(size_t m, const rbt_spin_law *law,
                                              rbti_spin_draws *d, double *largest)
{
    const double *ratios = d->inputs + RBTI_RATIO * m;
    RBTI_EACH_DRAW(r) {
        double moments[2];
        rbti_moments(law, d->shape[r], ratios[r], ratios[m + r], moments);
        largest[r] = moments[0];
        d->smallest[r] = moments[1];
    }
}

/* Conditions of the mirror image with sigma_x >= 0. Within RBTI_FOLD of 0 it is either image, by a
   chance that goes from 0 to 1 across the fold: so the law is continuous there, and mirror images of a
   condition have mirror images of one law. The chance takes 16 bits that the other steps leave. */
RBTI_INLINE RBT_DEVICE void rbti_fill_inputs(size_t m, const rbt_spin_law *law, rbti_spin_draws *d)
{
    double effective[RBTI_BLOCK] RBTI_ALIGNED, *inputs = d->inputs;
    double largest[RBTI_BLOCK] RBTI_ALIGNED;
    const double first = law->alpha_first, last = law->alpha_last, most = law->most_spin;
    rbti_fill_moments(m, law, d, largest);
    RBTI_EACH_DRAW(r) {
        const double sx = d->spin[r], sy = d->spin[m + r], sz = d->spin[2 * m + r];
        const double factor = rbti_spin_factor(sx, sy, sz);
        const double square = sx * sx + sy * sy + sz * sz, held = square < most ? square : most;
        /* the coordinate of a spin beyond the law is that of the largest */
        const double beyond = square > most ? sqrt(square / most) : 1.0;
        const double divisor = sqrt(sqrt(1.0 + held)) * beyond;
        const double tilt = sx / divisor, chance = 0.5 + tilt * (0.5 / RBTI_FOLD);
        const uint32_t bits = (d->words[r] & 0xffu) << 8 | (d->words[m + r] & 0xffu);
        const double turn = ((double)(int32_t)bits + 0.5) / 65536.0 < chance ? 1.0 : -1.0;
        const double tx = turn * tilt, ty = turn * sy / divisor, tz = sz / divisor;
        double angle = d->alpha1[r] > first ? d->alpha1[r] : first;
        angle = angle < last ? angle : last;
        double speed = d->speed[r] * factor;
        speed = speed > law->speed_first ? speed : law->speed_first;
        effective[r] = speed < law->speed_last ? speed : law->speed_last;
        inputs[r] = sqrt(angle);
        inputs[2 * m + r] = tx;
        inputs[3 * m + r] = ty;
        inputs[4 * m + r] = tz;
        inputs[RBTI_SQUARE * m + r] = tx * tx + ty * ty + tz * tz;
        d->factor[r] = sqrt(1.0 + largest[r] * square);
        d->turn[r] = turn;
    }
    rbti_fill_speed_coordinate(m, law, effective, inputs + m);
}

/* Leaf of each draw in the tree of its shape. */
RBTI_INLINE RBT_DEVICE void rbti_find_leaves(size_t m, const rbt_spin_law *law, rbti_spin_draws *d)
{
    RBTI_EACH_DRAW(r) {
        int32_t node = law->roots[d->shape[r]];
        while (node >= 0) {
            const double value = d->inputs[(size_t)law->node_axis[node] * m + r];
            node = law->node_child[2 * node + (value >= law->node_cut[node])];
        }
        d->leaf[r] = -1 - node;
        RBTI_PREFETCH(law->inputs + 2 * RBTI_INPUTS * (size_t)d->leaf[r]);
    }
    RBTI_EACH_DRAW(r) {
        const size_t numbers = RBTI_FEATURES * RBTI_GROUPS;
        const int16_t *gates = law->group_gates + numbers * (size_t)d->leaf[r];
        for (size_t k = 0; k < numbers; k += RBTI_LINE)
            RBTI_PREFETCH(gates + k);
    }
}

/* Features: 1, the inputs less the middle of the leaf, the products of two conditions. */
RBTI_INLINE RBT_DEVICE void rbti_fill_features(size_t m, const rbt_spin_law *law,
                                               rbti_spin_draws *d)
{
    float *features = d->features;
    RBTI_EACH_DRAW(r)
        features[r] = 1.0f;
    for (size_t k = 0; k < RBTI_INPUTS; k++) {
        const double *inputs = d->inputs + (k < RBTI_CONDITIONS ? k : k + 1) * m;
        float middle[RBTI_BLOCK] RBTI_ALIGNED, scale[RBTI_BLOCK] RBTI_ALIGNED;
        RBTI_EACH_DRAW(r) {
            const float *of = law->inputs + 2 * RBTI_INPUTS * (size_t)d->leaf[r] + k;
            middle[r] = of[0];
            scale[r] = of[RBTI_INPUTS];
        }
        RBTI_EACH_DRAW(r)
            features[(1 + k) * m + r] = ((float)inputs[r] - middle[r]) * scale[r];
    }
    float *product = features + (1 + RBTI_INPUTS) * m;
    for (size_t i = 1; i <= RBTI_CONDITIONS; i++) {
        for (size_t j = i; j <= RBTI_CONDITIONS; j++) {
            RBTI_EACH_DRAW(r)
                product[r] = features[i * m + r] * features[j * m + r] - (i == j ? 0.5f : 0.0f);
            product += m;
        }
    }
}
