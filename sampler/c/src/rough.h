/* -- rough walls ----------------------------------------------------------------------------------

   Facets of a rough wall: their tilts, rad, and the bounces of one hit. A particle that arrives at an
   angle alpha meets facets whose tilt g is normal with a standard deviation, the roughness, and which it
   sees by their projected area: their density is ~ exp(-g^2 / (2 roughness^2)) sin(alpha + g), 0 < alpha
   + g < pi, |g| < pi/2 (Sommerfeld & Huber, Int. J. Multiphase Flow 25 (1999) 1457-1489). The tangent of
   the sine bounds the density by phi(z) (c + z), z = g / roughness, c = tan(alpha) / roughness; a tilt is
   proposed from the bound and accepted with the ratio. Trials take blocks 3, 4, ... of random words.
   Bounce k of the same hit has the seed XOR k 0x9E3779B97F4A7C15.

   Where roughness is isotropic, facets are tilted by h across the plane of incidence as well: their
   normals are along e_y - tan(g) e_x + tan(h) e_z, and h has a density ~ exp(-h^2 / (2 roughness^2))
   cos(h), whatever g is (docs/method.md). Its trials take blocks 67, 68, ... */

#define RBTI_TILT_BLOCK 3u    /* block of random words of the first trial */
#define RBTI_MAX_TRIALS 64u   /* of one tilt */
#define RBTI_MAX_BOUNCES 64u  /* of one hit */
#define RBTI_SHADOW 1e-9      /* least angle between path and facet, rad, at which a facet is met */
#define RBTI_STEEP 1e9        /* largest c of the bound */
#define RBTI_BOUNCE_KEY 0x9e3779b97f4a7c15u
#define RBTI_PI 3.141592653589793
#define RBTI_PER_ROOT_TWO_PI 0.3989422804014327
#define RBTI_PER_ROOT_TWO 0.7071067811865476

RBTI_INLINE RBT_DEVICE double rbti_normal_cdf(double x)
{
    return 0.5 * erfc(-x * RBTI_PER_ROOT_TWO);
}

RBTI_INLINE RBT_DEVICE double rbti_normal_quantile(double p)
{
    const double q = p - 0.5;
    return fabs(q) <= 0.425 ? rbti_central_quantile(q) : rbti_outer_quantile(p);
}

/* z with a density ~ phi(z) (c + z), z > -c, from three uniform numbers. */
RBTI_INLINE RBT_DEVICE double rbti_proposed_score(double c, double u_part, double u_size,
                                                  double u_side)
{
    const double plain = c * rbti_normal_cdf(c);
    const double rayleigh = RBTI_PER_ROOT_TWO_PI * exp(-0.5 * c * c);
    if (u_part * (plain + rayleigh) >= plain)
        return sqrt(c * c - 2.0 * log(u_size)); /* z phi(z) for z > c */
    const double below = rbti_normal_cdf(-c);
    const double z = rbti_normal_quantile(below + u_size * (1.0 - below));
    /* phi(z) becomes phi(z) (1 + z / c) for |z| < c: each -z gives as much as z lacks */
    return z < c && 2.0 * u_side * c < c - z ? -z : z;
}

/* One trial of a tilt from four random words: whether it is accepted. */
RBTI_INLINE RBT_DEVICE int rbti_try_tilt(double alpha1, double roughness, const uint32_t words[4],
                                         double *tilt)
{
    const double steepness = tan(alpha1) / roughness;
    const double c = steepness < RBTI_STEEP ? steepness : RBTI_STEEP;
    *tilt = roughness * rbti_proposed_score(c, rbti_uniform(words[0]), rbti_uniform(words[1]),
                                            rbti_uniform(words[2]));
    const double local = alpha1 + *tilt;
    if (!(RBTI_SHADOW < local && local < RBTI_PI - RBTI_SHADOW) || fabs(*tilt) >= RBTI_HALF_PI)
        return 0;
    const double bound = sin(alpha1) + *tilt * cos(alpha1);
    return rbti_uniform(words[3]) * bound < sin(local);
}

/* One trial of a tilt across the plane of incidence. */
RBTI_INLINE RBT_DEVICE int rbti_try_across(double roughness, const uint32_t words[4], double *tilt)
{
    *tilt = roughness * rbti_normal_quantile(rbti_uniform(words[0]));
    return fabs(*tilt) < RBTI_HALF_PI && rbti_uniform(words[1]) < cos(*tilt);
}

/* A particle within one hit of a rough wall. */
typedef struct rbti_cascade {
    double velocity[3];         /* relative to the wall, m/s */
    double wall[3];             /* velocity of the wall, m/s */
    double e_y[3];              /* unit normal of the mean wall, into the gas */
    double half_size;           /* m */
    double roughness;           /* standard deviation of the tilt of facets, rad */
    int isotropic;              /* whether facets are tilted across the plane of incidence as well */
} rbti_cascade;

/* Begin a cascade, before its first bounce. Returns RBT_OK or an error. */
RBTI_INLINE RBT_DEVICE int rbti_begin_cascade(const double velocity[3], const double normal[3],
                                              double half_size, const double *wall_velocity,
                                              double roughness, int isotropic, rbti_cascade *c)
{
    if (!rbti_finite(roughness) || rbti_is_outside(roughness, 0.0, RBT_MOST_ROUGHNESS))
        return RBT_ERR_ROUGHNESS_NOT_USABLE;
    for (int k = 0; k < 3; k++)
        c->wall[k] = wall_velocity ? wall_velocity[k] : 0.0;
    const int code = rbti_impact_status(velocity, normal, half_size, c->wall);
    if (code != RBT_OK)
        return code;
    rbti_combine(1.0, velocity, -1.0, c->wall, c->velocity);
    if (sqrt(rbti_dot(c->velocity, c->velocity)) < RBTI_LEAST_SPEED)
        return RBT_ERR_SPEED_NOT_POSITIVE;
    rbti_unit(normal, c->e_y);
    c->half_size = half_size;
    c->roughness = rbti_bounded(roughness, 0.0, RBT_MOST_ROUGHNESS);
    c->isotropic = isotropic;
    return rbti_dot(c->velocity, c->e_y) < 0.0 ? RBT_OK : RBT_ERR_NOT_APPROACHING;
}

/* Draw the tilt in the plane of incidence, or across it, rad. Trials take successive blocks of random
   words. If none of them is accepted the tilt is 0; this happens only where path and roughness are as
   flat as RBTI_SHADOW. */
RBTI_INLINE RBT_DEVICE double rbti_find_tilt(const rbti_cascade *c, int across, double alpha1,
                                             uint64_t seed, uint64_t index, uint32_t hit)
{
    const uint32_t first = RBTI_TILT_BLOCK + (across ? RBTI_MAX_TRIALS : 0u);
    for (uint32_t trial = 0; trial < RBTI_MAX_TRIALS; trial++) {
        uint32_t words[4];
        double tilt;
        rbti_fill_words(1, first + trial, seed, &index, &hit, 1, words);
        if (across ? rbti_try_across(c->roughness, words, &tilt)
                   : rbti_try_tilt(alpha1, c->roughness, words, &tilt))
            return tilt;
    }
    return 0.0;
}

/* Find the impact on the facet that the particle meets next. Returns RBT_OK or an error. */
RBTI_ONCE_ON_HOST RBT_DEVICE int rbti_meet_facet(const rbti_cascade *c, uint64_t seed,
                                                 uint64_t index, uint32_t hit, rbti_impact *impact)
{
    const double speed = sqrt(rbti_dot(c->velocity, c->velocity));
    double tangential, e_x[3], e_z[3], facet[3];
    double alpha1 = rbti_impact_angle(c->velocity, c->e_y, &tangential);
    alpha1 = alpha1 > 0.0 ? alpha1 : 0.0;
    const double tilt = rbti_find_tilt(c, 0, alpha1, seed, index, hit);
    rbti_tangent(c->velocity, c->e_y, tangential, speed, seed, index, hit, e_x);
    rbti_combine(cos(tilt), c->e_y, -sin(tilt), e_x, facet);
    if (c->isotropic) {
        const double across = rbti_find_tilt(c, 1, alpha1, seed, index, hit);
        rbti_cross(e_x, c->e_y, e_z);
        rbti_combine(cos(across), facet, cos(tilt) * sin(across), e_z, facet);
    }
    return rbti_find_impact(c->velocity, facet, c->half_size, NULL, seed, index, hit, impact);
}

/* Whether the particle leaves the mean wall. */
RBTI_INLINE RBT_DEVICE int rbti_has_left(const rbti_cascade *c)
{
    return rbti_dot(c->velocity, c->e_y) > 0.0;
}
