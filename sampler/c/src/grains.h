/* -- grains ---------------------------------------------------------------------------------------

   The grain of a particle: a shape, by its code, and the ratios b/a and c/b of its half-sizes. It is a
   function of (seed, index), or with fresh grains of (seed, index, hit). Ratios follow truncated normal
   laws. Source of the normal quantile: Wichura, algorithm AS 241, Appl. Statist. 37 (1988) 477-484. */

/* Value of a polynomial of degree 7; the highest coefficient comes first. */
RBTI_INLINE RBT_DEVICE double rbti_horner(const double c[8], double x)
{
    double sum = c[0];
    for (int k = 1; k < 8; k++)
        sum = sum * x + c[k];
    return sum;
}

/* Standard normal quantile at p = 1/2 + q, for |q| <= 0.425. */
RBTI_INLINE RBT_DEVICE double rbti_central_quantile(double q)
{
    const double num[8] = {2.5090809287301226727e3, 3.3430575583588128105e4,
                           6.7265770927008700853e4, 4.5921953931549871457e4,
                           1.3731693765509461125e4, 1.9715909503065514427e3,
                           1.3314166789178437745e2, 3.3871328727963666080e0};
    const double den[8] = {5.2264952788528545610e3, 2.8729085735721942674e4,
                           3.9307895800092710610e4, 2.1213794301586595867e4,
                           5.3941960214247511077e3, 6.8718700749205790830e2,
                           4.2313330701600911252e1, 1.0};
    const double r = 0.180625 - q * q;
    return q * (rbti_horner(num, r) / rbti_horner(den, r));
}

/* Standard normal quantile at p, for |p - 1/2| > 0.425. */
RBTI_INLINE RBT_DEVICE double rbti_outer_quantile(double p)
{
    const double near_num[8] = {7.74545014278341407640e-4, 2.27238449892691845833e-2,
                                2.41780725177450611770e-1, 1.27045825245236838258e0,
                                3.64784832476320460504e0,  5.76949722146069140550e0,
                                4.63033784615654529590e0,  1.42343711074968357734e0};
    const double near_den[8] = {1.05075007164441684324e-9, 5.47593808499534494600e-4,
                                1.51986665636164571966e-2, 1.48103976427480074590e-1,
                                6.89767334985100004550e-1, 1.67638483018380384940e0,
                                2.05319162663775882187e0,  1.0};
    const double far_num[8] = {2.01033439929228813265e-7, 2.71155556874348757815e-5,
                               1.24266094738807843860e-3, 2.65321895265761230930e-2,
                               2.96560571828504891230e-1, 1.78482653991729133580e0,
                               5.46378491116411436990e0,  6.65790464350110377720e0};
    const double far_den[8] = {2.04426310338993978564e-15, 1.42151175831644588870e-7,
                               1.84631831751005468180e-5,  7.86869131145613259100e-4,
                               1.48753612908506148525e-2,  1.36929880922735805310e-1,
                               5.99832206555887937690e-1,  1.0};
    double r = sqrt(-log(p < 0.5 ? p : 1.0 - p));
    const int is_near = r <= 5.0;
    r -= is_near ? 1.6 : 5.0;
    const double tail = rbti_horner(is_near ? near_num : far_num, r) /
                        rbti_horner(is_near ? near_den : far_den, r);
    return p < 0.5 ? -tail : tail;
}

/* Ratios of one kind, b/a or c/b, from random words. `law` is the mean, the deviation, and the lowest and
   the highest probability of the truncated normal law. */
RBTI_INLINE RBT_DEVICE void rbti_fill_ratios(size_t m, const double law[4], const uint32_t *words,
                                             double *ratios)
{
    const double mean = law[0], deviation = law[1], low = law[2], high = law[3];
    double p[RBTI_BLOCK] RBTI_ALIGNED;
    RBTI_EACH_DRAW(r) {
        p[r] = low + rbti_uniform(words[r]) * (high - low);
        ratios[r] = rbti_central_quantile(p[r] - 0.5);
    }
    RBTI_EACH_DRAW(r)
        if (fabs(p[r] - 0.5) > 0.425 && deviation > 0.0)
            ratios[r] = rbti_outer_quantile(p[r]);
    RBTI_EACH_DRAW(r) {
        double ratio = deviation > 0.0 ? mean + deviation * ratios[r] : mean;
        /* laws that were simulated stay within this range; the limits keep damaged files finite */
        ratio = ratio > RBTI_LEAST_RATIO ? ratio : RBTI_LEAST_RATIO;
        ratios[r] = ratio < 1.0 ? ratio : 1.0;
    }
}

/* Where the grains of particles come from: the caller prescribes them, or they belong to a seed. All
   bounces of one hit have the same grain, although each bounce has a seed of its own. */
typedef struct rbti_grains {
    const double *prescribed; /* 3 numbers a particle: shape code, b/a, c/b; NULL: grains of the seed */
    uint64_t seed;
    int fresh; /* whether a particle has another grain at each hit */
} rbti_grains;

/* Row k of an array of vectors, NULL if there is no array. */
RBTI_INLINE RBT_DEVICE const double *rbti_vector_of(const double *vectors, size_t k)
{
    return vectors ? vectors + 3 * k : NULL;
}

/* Row of a shape among the shapes of a population; n_shapes if it does not have the shape. */
RBTI_INLINE RBT_DEVICE int32_t rbti_row_of_shape(const rbt_population *population, double code)
{
    int32_t row = 0;
    while (row < population->n_shapes && (double)population->shape_codes[row] != code)
        row++;
    return row;
}

/* Whether a grain has a shape of the population, and ratios between those that were simulated. */
RBTI_INLINE RBT_DEVICE int rbti_grain_is_known(const rbt_population *population, const double grain[3])
{
    const int32_t row = rbti_row_of_shape(population, grain[0]);
    if (row == population->n_shapes || !rbti_finite(grain[1]) || !rbti_finite(grain[2]))
        return 0;
    const double *range = population->ratio_range + 4 * row;
    return !(rbti_is_outside(grain[1], range[0], range[1]) |
             rbti_is_outside(grain[2], range[2], range[3]));
}

/* Take the grains that the caller prescribes. A block that is not full repeats its last grain. */
RBTI_INLINE RBT_DEVICE void rbti_take_grains(size_t m, const rbt_population *population,
                                             const double *prescribed, size_t count, int32_t *shapes,
                                             double *ratios)
{
    RBTI_EACH_DRAW(r) {
        const double *grain = prescribed + 3 * (r < count ? r : count - 1);
        /* a row whose grain is not known has an error, and takes a grain that can be drawn */
        const int is_known = rbti_grain_is_known(population, grain);
        shapes[r] = is_known ? rbti_row_of_shape(population, grain[0]) : 0;
        ratios[r] = is_known ? rbti_bounded(grain[1], RBTI_LEAST_RATIO, 1.0) : 1.0;
        ratios[m + r] = is_known ? rbti_bounded(grain[2], RBTI_LEAST_RATIO, 1.0) : 1.0;
    }
}

/* Grains of a seed, from random words that no draw takes. */
RBTI_INLINE RBT_DEVICE void rbti_fill_grains(size_t m, const rbt_population *population, uint64_t seed,
                                             int fresh, const uint64_t *index,
                                             const uint32_t *hit, size_t count, int32_t *shapes,
                                             double *ratios)
{
    uint32_t zeros[RBTI_BLOCK] RBTI_ALIGNED, words[8 * RBTI_BLOCK] RBTI_ALIGNED;
    RBTI_EACH_DRAW(r)
        zeros[r] = 0;
    const uint32_t *hits = fresh ? hit : zeros;
    for (uint32_t block = 0; block < 2; block++)
        rbti_fill_words(m, block, seed ^ RBTI_SIMULATION_KEY, index, hits, count,
                        words + 4 * block * m);
    rbti_fill_ratios(m, population->aspect, words, ratios);
    rbti_fill_ratios(m, population->aspect + 4, words + m, ratios + m);
    RBTI_EACH_DRAW(r) {
        const double u = rbti_uniform(words[5 * m + r]);
        int32_t row = 0;
        for (int32_t k = 0; k < population->n_shapes - 1; k++)
            row += u >= population->shape_shares[k];
        shapes[r] = row;
        if (population->shape_ratios[2 * row] > 0.0) {
            ratios[r] = population->shape_ratios[2 * row];
            ratios[m + r] = population->shape_ratios[2 * row + 1];
        }
    }
}

RBT_API RBT_DEVICE int rbt_grains(const rbt_table *table, size_t n, uint64_t seed,
                                  const uint64_t *index, const uint32_t *hit, double *grains)
{
    if (!table || !index || !grains)
        return RBT_ERR_MISSING;
    if (table->population.n_shapes == 0)
        return RBT_ERR_NO_SPIN_LAW;
    const rbt_population *population = &table->population;
    for (size_t first = 0, count = 0; first < n; first += count) {
        const uint32_t zeros[RBTI_BLOCK] = {0};
        int32_t shapes[RBTI_BLOCK] RBTI_ALIGNED;
        double ratios[2 * RBTI_BLOCK] RBTI_ALIGNED;
        count = n - first < RBTI_BLOCK ? n - first : RBTI_BLOCK;
        rbti_fill_grains(RBTI_BLOCK, population, seed, hit != NULL, index + first,
                         hit ? hit + first : zeros, count, shapes, ratios);
        for (size_t r = 0; r < count; r++) {
            double *grain = grains + 3 * (first + r);
            grain[0] = (double)population->shape_codes[shapes[r]];
            grain[1] = ratios[r];
            grain[2] = ratios[RBTI_BLOCK + r];
        }
    }
    return RBT_OK;
}
