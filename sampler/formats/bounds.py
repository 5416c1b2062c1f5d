"""Bounds on table values, and numbers that a table, its readers and the draw share.

Within these bounds every draw is finite and physical, and every table fits into a binary table.
They are far wider than the values of any real table. `sampler.formats.layout` checks values when a
table file is read or made, and the reader in C checks those that a draw takes as an index.
"""

import re

from sampler.formats.channels import CHANNELS, MOST_NAMES, RANGES

#: Least and greatest length of the dimensions of arrays. Components and their classes are counted
#: in 16 bits, and a draw finds its knot in single precision.
LENGTHS = {
    "n_alpha": (1, 2**16),
    "n_speed": (1, 2**16),
    "n_alpha_grid": (2, 2**24),
    "n_speed_grid": (2, 2**24),
    "n_knots": (2, 2**16),
    "n_components": (1, 2**16),
    "n_classes": (1, 2**16),
    "n_channels": (1, MOST_NAMES),
    "n_marginals": (1, MOST_NAMES),
    "n_columns": (1, MOST_NAMES),
    "n_shapes": (1, 2**10),
    "n_nodes": (1, 2**20),
    "n_leaves": (1, 2**20),
    "n_spin_knots": (2, 2**12),
    "n_outcomes": (7, 8),
    "n_law_parameters": (8, 2**20),
}

#: Impact angle of a node, degrees.
ALPHA_DEG = (1e-9, 90.0)

#: Impact speed of a node, m/s.
SPEED = (1e-9, 1e9)

#: Least distance of neighbouring nodes, and of the ends of an axis, over the larger of the two:
#: degrees must stay apart as radians.
LEAST_STEP = 1e-9

#: Largest number of a node. Numbers begin at 0: a draw rounds them towards 0, which must be down.
MOST_NUMBER = 1e6

#: How far the coordinate of a node may be from its number: it is interpolated between steps.
NUMBER_ROUNDING = 0.02

#: Mixture variate of the last knot; single precision must tell knots apart.
VARIATE_MAX = (1e-3, 1e6)

#: Open interval of the quantiles of each channel; physics does not limit angular velocities.
QUANTILES = {**dict.fromkeys(CHANNELS, (-1e9, 1e9)), "collisions": (0.0, 1e9), **RANGES}

#: Longest name of a material pair, in bytes of UTF-8: it must fit into a binary table.
PAIR_BYTES = 127

#: Longest text of any other attribute in one line, in characters.
LINE_CHARACTERS = 1000


#: Characters that control a terminal, but ends of lines and tabs; halves of characters.
_CONTROL = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff]")


def is_line(text: str) -> bool:
    """Tell whether a text is one line that does not control a terminal."""
    return text.isprintable()


def is_text(text: str) -> bool:
    """Tell whether no line of a text controls a terminal.

    Other characters that `str.isprintable` refuses, such as spaces that do not break, stand in
    comments that people paste, and do no harm.
    """
    return _CONTROL.search(text) is None


#: Least and largest speed, m/s, of a table whose rebounds do not depend on the speed. They are not
#: the limits of the type: compilers may drop a comparison with these.
ANY_SPEED = (1e-300, 1e300)

#: Relative rounding of a unit conversion: a smaller excess is no excess.
ROUNDING = 1e-12

#: Relative excess of an argument beyond an end of its range, as rounding to single precision makes
#: it, two units of the last place at most: such an argument counts as the end.
SINGLE_ROUNDING = 1.2e-7

#: Rows of a factor that a draw computes side by side, those that a table lacks included.
LANES = MOST_NAMES

#: Numbers of a unit in the means and factors of a mixture. Its variates have variance 1, so steps
#: of 1/4096 on a range of +-8 move a draw by less than a thousandth of a standard deviation.
MIXTURE_SCALE = 4096


def record_stride(channels: int) -> int:
    """Count the numbers of a component's record: a power of two, within a cache line."""
    needed = 1 + channels + channels * (channels + 1) // 2
    return 1 << (needed - 1).bit_length()


# -- laws of contact -----------------------------------------------------------------------------

#: Laws of restitution, and of resistance, as files name them. The code of a law is its place, so a
#: new law goes to the end.
RESTITUTION_LAWS = ("exponential", "polynomial", "constant", "power", "tabulated")
RESISTANCE_LAWS = ("exponential-orientation", "constant", "tabulated", "coulomb")


# -- the spin law --------------------------------------------------------------------------------
#
# A rebound is a change at a nominal contact, which lies straight towards the wall at the distance
# rho from the centre of the grain. The energy E before, over m V^2 / 2, is |g|^2 + |d|^2, where g
# belongs to the velocity of the contact, and d to what a force at the contact cannot change. The
# outcomes o move d, in units of the share Q of E that is at the contact, and p divides what is left
# between the contact and the wall. So energies add up, whatever the outcomes are, and a positive
# p_v leaves the wall. tables/FORMAT.md has the formulae.

OUTCOMES = ("p_u", "p_v", "p_w", "o_x", "o_y", "o_z", "h", "a")
#: sqrt(alpha1), the coordinate of the speed of the contact, the three of the spin, the slip of the
#: contact over its speed, and the place of the inertia about the spin.
CONDITIONS = ("root_angle", "speed", "sigma_x", "sigma_y", "sigma_z", "slip", "place")
N_CONDITIONS = len(CONDITIONS)
#: Ratios of a grain. The inputs that follow from them are sqrt(1 - b/a) and sqrt(1 - c/b).
RATIOS = ("b_a", "c_b")
N_INPUTS = N_CONDITIONS + len(RATIOS)
#: Of ellipsoids with a spin: the three parts of their tilt A from a motion in the plane of the
#: impact, over A, and the part of their rise that the velocity towards the wall makes.
N_DIRECTIONS = 4
#: 1, the inputs, the products of two of them, and the directions.
N_FEATURES = 1 + N_INPUTS + N_INPUTS * (N_INPUTS + 1) // 2 + N_DIRECTIONS
N_OUTCOMES = 7
N_OUTCOMES_WITH_WORKS = len(OUTCOMES)

#: Size of the coordinate sigma of the slowest spin, which keeps its direction: the law depends on
#: it however slow it is. sigma = s / |s| (SPIN_CORE + |s| / (1 + |s|^2)^(1/4)).
SPIN_CORE = 0.3

#: Along the wall the inputs are sigma_x and sigma_y over the root of their size plus this: a grain
#: that rolls leaves rolling by tilts of its spin of a few hundredths.
TILT_CORE = 0.02

#: The place of an inertia among the inputs is log((kappa + PLACE_CORE) / (1 - kappa + PLACE_CORE)).
PLACE_CORE = 0.03

#: Scatter of the distance of the contact: what is added to its square, and the weight of a product.
LEAST_WOBBLE, WOBBLE = 1e-6, 2.4

#: A rolling ellipsoid rises from the wall with the speed at which its distance from the contact
#: changes: weight of the square of this speed beside that of sin alpha1 in the unit of p_v.
RISE = 8.0

#: A grain is away from a motion in the plane of its impact by A, at least LEAST_TILT. The odds of
#: kappa after an impact are over those before, (kappa + delta) / (1 - kappa + delta). delta is A
#: times the share of the speed of rotation that the contact has. A kappa after an impact counts as
#: being at least END_OF_KAPPA from 0 and 1.
LEAST_TILT, END_OF_KAPPA = 1e-3, 1e-4

#: An ellipsoid is out of round by 2 (1 - c/a) plus this. The wall takes at least this share of the
#: energy that a sphere keeps.
ROUND_CORE, LEAST_TAKEN = 0.02, 1e-3

#: Least share of the energy, as its root, that is left to the contact and the wall.
LEAST_LEFT = 1e-6

#: Largest moment of inertia of a body of mass 1 and half-size 1.
INERTIA = 2.0 / 3.0

#: Difference of a grain's moments of inertia, over the larger, up to which they are equal.
EQUAL_MOMENTS = 1e-9

#: How far an inertia may be beyond the moments of its grain, by rounding to single precision.
INERTIA_ROUNDING = 1e-6

#: Probabilities 0 to 1 in equal steps at which the kappa of rebounds is stored by shape.
N_KAPPA_QUANTILES = 33

#: Input of sigma_x, in size, below which a draw may be of either mirror image of its condition.
FOLD = 0.1

#: Smallest moment of inertia over m a^2 of any grain, and coefficients of the moments of a shape.
LEAST_INERTIA, INERTIA_COEFFICIENT = (0.0, INERTIA), (1e-9, 1.0)

#: Largest number of the geometry of a shape; a box has a volume of 8 a b c.
MOST_GEOMETRY = 1e3

#: Sizes of the spin a |Omega| / V that a law can cover.
SPIN_SIZE = (0.0, 1e6)

#: Least energy, over that before, of which outcomes p and o are made: a sphere that keeps all
#: its energy leaves none.
LEAST_REST = 1e-6

#: Largest of the least rebound velocities over V in laws of contact: the sine of the impact angle
#: from which on it is whole.
GRAZING = 0.0087

#: Squared coordinate of the spin, |sigma|^2, below which the root of a tree takes a particle not to
#: spin.
NO_SPIN = 1e-12

#: Bound of the score zeta = z / sqrt(1 + z^2 / SCORE_MAX^2), where the quantiles end.
SCORE_MAX = 6.0

#: Numbers of a unit: coefficients of gates, those of means, and factors. As 16-bit integers they
#: are bounded, and with what the layout allows of inputs every draw is finite.
GATE_UNIT, MEAN_UNIT, FACTOR_UNIT = 512, 2048, 4096

#: The first group of a leaf makes the slowest rebounds. There the distribution function of v grows
#: as v^2, and its normal score is distributed as the lower tail of a normal law. So the normal
#: number n of p_v becomes
#:
#:     SHIFT - sqrt(SQUARE + FACTOR (sqrt((n - 1)^2 + CORE) - (n - 1))^2),
#:
#: which has the mean 0, the variance 1, and, within a hundredth, the distribution of normal numbers
#: below their quantile at 0.01. The numbers are SHIFT, SQUARE, FACTOR and CORE.
SLOW_TAIL = (15.146, 196.0, 3.0, 2.5)

#: Groups of a leaf, and experts of a group: a draw makes eight sums at once, so both are eight.
#: The same in every law, so that the compiler knows how
#: many weights lie side by side; those that a leaf does not need have a weight of almost 0.
N_GROUPS, GROUP_SIZE = 8, 8
N_EXPERTS = N_GROUPS * GROUP_SIZE

#: Effective speeds V_e, m/s.
SPIN_SPEED = (1e-9, 1e9)

#: Closed interval of outcomes: far beyond what is physical, and squares of them are finite.
OUTCOME = (-1e6, 1e6)

#: Bounds of what a leaf subtracts from its inputs and multiplies them by, and of a tree's cuts.
MOST_MIDDLE, MOST_SCALE, MOST_CUT = 1e3, 1e4, 1e3

#: Coefficient and exponent of the speed's coordinate.
SPEED_COORDINATE = (1e-6, 1e3)

#: Most of k V_e^n, which single precision must hold.
MOST_SPEED_SCALE = 1e30

#: Smallest ratio of half-sizes.
LEAST_RATIO = 1e-3


def expert_stride(outcomes: int) -> int:
    """Count the numbers of an expert: means and factor, padded to whole cache lines."""
    return -(-(N_FEATURES * outcomes + outcomes * (outcomes + 1) // 2) // 32) * 32
