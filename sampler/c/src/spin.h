/* -- the spin draw --------------------------------------------------------------------------------

   The spin law: states over V and a/V, and inertias over m a^2, of particles that arrive spinning, from
   the impact angle, rad, the speed, m/s, the spin, V/a, the inertia about it, and the grain. Steps,
   letters and units are those of tables/FORMAT.md, "The spin law". Each step is a loop over the draws of
   a block, and fills arrays of rbti_spin_draws that the next steps read:

     step   section       function             arrays that it fills
     words  words.h       rbti_fill_words      words
            grains.h      rbti_fill_grains     shape, ratios among the inputs
     1      conditions.h  rbti_fill_moments    least, most: moments of inertia of the grain
                          rbti_fill_inertia    inertia about the spin, drawn where it is not known
                          rbti_fill_contact    nominal contact, and the inputs that come from it
                          rbti_fill_spheres    rebounds of spheres, from which some outcomes are counted
                          rbti_fill_inputs     inputs: condition of the effective speed, mirror image
     2                    rbti_find_leaves     leaf of the shape's tree
     3                    rbti_fill_features   features
     4      experts.h     rbti_choose_expert   group, then expert of it
     5                    rbti_fill_scores     scores z = mean + L n
     6      outcomes.h    rbti_find_knots      scores become fractions between knots, entries
                          rbti_fill_outcomes   outcomes, by the leaf's quantiles
     7                    rbti_to_spin_states  states and inertias, whose energies add up
     all    spin_draw.h   rbti_spin_steps

   Steps 3 to 6 are in single precision. Coefficients that are multiplied by the features of a draw lie
   side by side in the table, so steps 4 and 5 go draw by draw. The number of outcomes is 7, or 8 with
   works; where it matters for speed, in single draws and in factors, the compiler knows it. */

#define RBTI_LINE 32 /* 16-bit numbers of a cache line */

/* Rows of inputs are RBTI_IN_..., those of outcomes and scores RBTI_OUT_... (prelude.h). */
typedef struct rbti_spin_draws {
    /* conditions: rad, m/s, a Omega / V, and over m a^2, where 0 is not known; step 1 replaces the inertia by
       the one that is drawn at */
    double alpha1[RBTI_BLOCK], speed[RBTI_BLOCK], spin[3 * RBTI_BLOCK], inertia[RBTI_BLOCK];
    double inputs[RBTI_IN_ROWS * RBTI_BLOCK];
    double energy[RBTI_BLOCK]; /* E, before, over m V^2 / 2 */
    /* nominal contact: place kappa of the inertia, cosine and sine of f; kappa + delta and
       1 - kappa + delta; the point e from which outcomes o count; units of the outcomes o and h */
    double kappa[RBTI_BLOCK], cosine[RBTI_BLOCK], sine[RBTI_BLOCK];
    double odds[2 * RBTI_BLOCK], base[3 * RBTI_BLOCK];
    double o_unit[RBTI_BLOCK], h_unit[RBTI_BLOCK];
    /* whether the plane of the impact is taken for a mirror of the grain; distance A from a motion in this
       plane; unit of outcomes that leave it, unit of p_v, the part of p_u that p_w has if the contact slides
       as before, and directions of the tilt: 1, 1, 0, 0, 0 where it is not */
    int32_t mirrored[RBTI_BLOCK];
    double tilt[RBTI_BLOCK], side_unit[RBTI_BLOCK], rise[RBTI_BLOCK], slide[RBTI_BLOCK];
    double direction[RBTI_DIRECTIONS * RBTI_BLOCK];
    /* whether outcomes p count from a sphere; its u and v after the impact, the energy W that the wall
       takes from it, and the units of p_v and of p_u and p_w */
    int32_t by_sphere[RBTI_BLOCK];
    double sphere[2 * RBTI_BLOCK], taken[RBTI_BLOCK], p_unit[2 * RBTI_BLOCK];
    double sign[RBTI_BLOCK];   /* -1: the draw is of the mirror image */
    double least[RBTI_BLOCK], most[RBTI_BLOCK]; /* moments of inertia of the grain, over m a^2 */
    uint32_t words[12 * RBTI_BLOCK];
    int32_t shape[RBTI_BLOCK], leaf[RBTI_BLOCK], group[RBTI_BLOCK], expert[RBTI_BLOCK];
    float features[RBTI_FEATURES * RBTI_BLOCK];
    float scores[RBTI_MOST_OUTCOMES * RBTI_BLOCK]; /* normals, then scores, then fractions of knots */
    int32_t entries[RBTI_MOST_OUTCOMES * RBTI_BLOCK]; /* quantiles at the knot below */
    float outcomes[RBTI_MOST_OUTCOMES * RBTI_BLOCK];
} rbti_spin_draws;

/* Length of the record of an expert, which fills whole cache lines. */
RBTI_INLINE RBT_DEVICE size_t rbti_expert_stride(size_t outcomes)
{
    const size_t numbers = RBTI_FEATURES * outcomes + outcomes * (outcomes + 1) / 2;
    return (numbers + RBTI_LINE - 1) / RBTI_LINE * RBTI_LINE;
}

RBTI_INLINE RBT_DEVICE double rbti_square(double x, double y, double z)
{
    return x * x + y * y + z * z;
}

/* Effective speed V_e at which the spin law is drawn, m/s: the speed that the particle would have if all
   of its kinetic energy were translation. `speed` is V and `root` is the square root of E. A particle
   that is faster than the table is drawn at the table's fastest V, with its spin over V/a. */
RBTI_INLINE RBT_DEVICE double rbti_effective_speed(const rbt_table *table, double speed, double root)
{
    const double last = table->speed.last, covered = speed < last ? speed : last;
    return rbti_bounded(covered * root, table->spin.speed_first, table->spin.speed_last);
}

/* Flags of a condition with a spin, without branches. `root` is the square root of E, `square` is the
   square of the size of the spin, and `inertia_is_beyond` says whether the inertia lies beyond the
   moments of the grain. A speed is outside if V is above the speeds of the table, or if
   V_e = root V is outside the speeds of the spin law. */
RBTI_INLINE RBT_DEVICE int rbti_spin_flags(const rbt_table *table, double alpha1, double speed,
                                           double root, double square, int inertia_is_beyond)
{
    const rbt_spin_law *law = &table->spin;
    const double effective = speed * root;
    const double rounding = 2.0 * RBTI_SINGLE_ROUNDING; /* as of rbti_is_outside, for a square */
    const int beyond = (square < law->least_spin * (1.0 - rounding)) |
                       (square > law->most_spin * (1.0 + rounding));
    const int fast = rbti_is_outside(effective, law->speed_low, law->speed_high) |
                     rbti_is_outside(speed, 0.0, table->speed.high);
    const int unmeasured = rbti_is_outside(effective, table->valid_speed[0], table->valid_speed[1]);
    return rbti_is_outside(alpha1, law->alpha_first, law->alpha_last) * RBT_ANGLE | fast * RBT_SPEED |
           (beyond | inertia_is_beyond) * RBT_SPIN | unmeasured * RBT_EXTRAPOLATED;
}

/* Whether an inertia lies beyond two moments of inertia by more than rounding to single precision. An
   inertia that is not known, and the inertia of a particle without spin, does not. */
RBTI_INLINE RBT_DEVICE int rbti_inertia_is_beyond(double inertia, double square, double least,
                                                  double most)
{
    const int outside = (inertia < least * (1.0 - RBTI_INERTIA_ROUNDING)) |
                        (inertia > most * (1.0 + RBTI_INERTIA_ROUNDING));
    return outside & (inertia > 0.0) & (square > 0.0);
}

/* Whether the energy of an impact is finite, and its inertia is 0 or more. */
RBTI_INLINE RBT_DEVICE int rbti_has_energy(double speed, double x, double y, double z,
                                           double inertia)
{
    const double effective = speed * sqrt(1.0 + rbti_square(x, y, z));
    return rbti_finite(effective * effective) & rbti_finite(inertia) & (inertia >= 0.0);
}

/* Error of a condition with a spin, or RBT_OK. `grain` may be NULL. */
RBTI_INLINE RBT_DEVICE int rbti_spin_error(const rbt_table *table, double alpha1, double speed,
                                           const double spin[3], double inertia,
                                           const double *grain)
{
    const int error = rbti_error(alpha1, speed);
    if (error < RBT_OK)
        return error;
    if (table->population.n_shapes == 0)
        return RBT_ERR_NO_SPIN_LAW;
    if (!rbti_has_energy(speed, spin[0], spin[1], spin[2], inertia))
        return RBT_ERR_NOT_FINITE;
    return !grain || rbti_grain_is_known(&table->population, grain) ? RBT_OK : RBT_ERR_GRAIN_NOT_KNOWN;
}

/* Flags of a condition of a sphere, whose moments of inertia are equal. */
RBTI_INLINE RBT_DEVICE int rbti_sphere_flags(const rbt_table *table, double alpha1, double speed,
                                             const double spin[3], double inertia)
{
    const double j = RBTI_SPHERE_INERTIA, square = rbti_square(spin[0], spin[1], spin[2]);
    return rbti_spin_flags(table, alpha1, speed, sqrt(1.0 + j * square), square,
                           rbti_inertia_is_beyond(inertia, square, j, j));
}
