/* -- the spin draw --------------------------------------------------------------------------------

   The law of particles that arrive spinning, given their spin and their grain. Steps, letters and units
   are those of tables/FORMAT.md, "The spin law". Each step is a loop over the draws of a block, which
   fills the arrays of rbti_spin_draws that the next one reads:

     step   section       function             arrays that it fills
     words  words.h       rbti_fill_words      words
            grains.h      rbti_fill_grains     shape, ratios among the inputs
     1      conditions.h  rbti_fill_inputs     inputs: condition of the effective speed, mirror image
     2                    rbti_find_leaves     leaf of the shape's tree
     3                    rbti_fill_features   features
     4      experts.h     rbti_choose_expert   group, then expert of it
     5                    rbti_fill_scores     scores z = mean + L n
     6      outcomes.h    rbti_find_knots      scores become fractions between knots, entries
                          rbti_fill_outcomes   outcomes, by the leaf's quantiles
                          rbti_add_spheres     outcomes of round grains: those of a sphere are added
     7                    rbti_to_spin_states  states, with no more energy than before
     all    spin_draw.h   rbti_spin_steps

   Steps 3 to 6 are in single precision. Coefficients that are multiplied by the features of a draw lie
   side by side in the table, and are taken draw by draw. The compiler knows the number of outcomes, 6
   or with works 8, where it matters: in single draws and in the factors. */

#define RBTI_LINE 32 /* 16-bit numbers of a cache line */

/* Rows of inputs are RBTI_IN_..., those of outcomes and scores RBTI_OUT_... (prelude.h). */
typedef struct rbti_spin_draws {
    double alpha1[RBTI_BLOCK], speed[RBTI_BLOCK], spin[3 * RBTI_BLOCK]; /* rad, m/s, a Omega / V */
    double inputs[RBTI_IN_ROWS * RBTI_BLOCK];
    double factor[RBTI_BLOCK];   /* root of E, the most energy before, over m V^2 / 2 */
    double sign[RBTI_BLOCK];     /* -1: the draw is of the mirror image */
    double smallest[RBTI_BLOCK]; /* moment of inertia of the grain, over m a^2 */
    uint32_t words[12 * RBTI_BLOCK];
    int32_t shape[RBTI_BLOCK], leaf[RBTI_BLOCK], group[RBTI_BLOCK], expert[RBTI_BLOCK];
    float features[RBTI_FEATURES * RBTI_BLOCK];
    float scores[RBTI_MOST_OUTCOMES * RBTI_BLOCK]; /* normals, then scores, then fractions of knots */
    int32_t entries[RBTI_MOST_OUTCOMES * RBTI_BLOCK]; /* quantiles at the knot below */
    float outcomes[RBTI_MOST_OUTCOMES * RBTI_BLOCK];
} rbti_spin_draws;

/* Numbers of an expert with some outcomes, whole cache lines. */
RBTI_INLINE RBT_DEVICE size_t rbti_expert_stride(size_t outcomes)
{
    const size_t numbers = RBTI_FEATURES * outcomes + outcomes * (outcomes + 1) / 2;
    return (numbers + RBTI_LINE - 1) / RBTI_LINE * RBTI_LINE;
}

RBTI_INLINE RBT_DEVICE double rbti_square(double x, double y, double z)
{
    return x * x + y * y + z * z;
}

/* V_e / V of a spin. */
RBTI_INLINE RBT_DEVICE double rbti_spin_factor(double x, double y, double z)
{
    return sqrt(1.0 + RBTI_INERTIA * rbti_square(x, y, z));
}

/* Flags of a condition with a spin, without branches. Where angle, speed and spin are in range but the
   effective speed is not, it is the spin that is beyond. */
RBTI_INLINE RBT_DEVICE int rbti_spin_flags(const rbt_table *table, double alpha1, double speed,
                                           double x, double y, double z)
{
    const rbt_spin_law *law = &table->spin;
    const double square = rbti_square(x, y, z), effective = speed * rbti_spin_factor(x, y, z);
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
