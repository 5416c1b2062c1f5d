"""The layout of the spin law in a table file: rebounds of particles that arrive spinning.

A table has all of these datasets or none. They follow the rules of `sampler.formats.layout`,
and the formulae that use them are in `sampler.drawing.spin_steps`.
"""

from collections.abc import Iterable

from sampler.formats import hdf5_checks as checks
from sampler.formats import spin_checks
from sampler.formats.bounds import (
    ALPHA_DEG,
    FACTOR_UNIT,
    GATE_UNIT,
    GROUP_SIZE,
    LEAST_RATIO,
    MEAN_UNIT,
    MOST_CUT,
    MOST_MIDDLE,
    MOST_SCALE,
    N_CONDITIONS,
    N_EXPERTS,
    N_FACTORS,
    N_FEATURES,
    N_GROUPS,
    N_INPUTS,
    N_OUTCOMES,
    OUTCOME,
    SCORE_MAX,
    SPEED,
    SPEED_COORDINATE,
)
from sampler.formats.layout import DATASETS, Dataset

#: Where the datasets of the spin law begin, and those of its accuracy.
GROUP, ACCURACY = "spin/", "spin_accuracy/"

_EXPERTS = ("n_leaves", N_EXPERTS)
_SHARE = (checks.within(0.0, 1.0),)

SPIN_DATASETS = (
    Dataset(
        "spin/shape_codes",
        "<i4",
        ("n_shapes",),
        "1",
        "shapes and meshes of the particles that the law was made for",
        (checks.increasing, checks.within(0, 2**30)),
    ),
    Dataset(
        "spin/shape_weights",
        "<f8",
        ("n_shapes",),
        "1",
        "share of each in the population of the configuration",
        (*_SHARE, spin_checks.adds_up),
    ),
    Dataset(
        "spin/ratio_range",
        "<f8",
        ("n_shapes", 2, 2),
        "1",
        "smallest and largest b/a, then c/b, that were simulated",
        (checks.within(LEAST_RATIO, 1.0), checks.non_decreasing),
    ),
    Dataset(
        "spin/aspect",
        "<f8",
        (2, 4),
        "1",
        "normal laws of b/a and c/b in the population: mean, standard deviation, and the standard "
        "normal probabilities of the ends of the range; a deviation of 0: the mean, always",
        (spin_checks.aspect_law,),
    ),
    Dataset(
        "spin/speed_coordinate",
        "<f8",
        (2,),
        "1",
        "coefficient k and exponent n of the speed's coordinate exp(-k V_e^n), V_e in m/s",
        (checks.within(*SPEED_COORDINATE),),
    ),
    Dataset(
        "spin/alpha_range_deg",
        "<f8",
        (2,),
        "degree",
        "smallest and largest impact angle of the law",
        (checks.within(*ALPHA_DEG), checks.non_decreasing),
    ),
    Dataset(
        "spin/speed_range",
        "<f8",
        (2,),
        "m s-1",
        "smallest and largest effective speed V_e of the law",
        (checks.within(*SPEED), checks.non_decreasing),
    ),
    Dataset(
        "spin/roots",
        "<i4",
        ("n_shapes",),
        "1",
        "node at which the tree of a shape begins",
        (spin_checks.roots,),
    ),
    Dataset(
        "spin/node_axis",
        "|i1",
        ("n_nodes",),
        "1",
        "what a node compares: 0 to 4 a condition, 5 the square of a Omega / V_e",
        (checks.within(0, N_CONDITIONS),),
    ),
    Dataset(
        "spin/node_cut",
        "<f8",
        ("n_nodes",),
        "1",
        "values from this on belong to the second child",
        (checks.within(-MOST_CUT, MOST_CUT),),
    ),
    Dataset(
        "spin/node_child",
        "<i4",
        ("n_nodes", 2),
        "1",
        "children: a later node, or -1 - the number of a leaf",
        (spin_checks.children,),
    ),
    Dataset(
        "spin/centre",
        "<f4",
        ("n_leaves", N_INPUTS),
        "1",
        "by leaf: middle of the five conditions, b/a and c/b",
        (checks.within(-MOST_MIDDLE, MOST_MIDDLE),),
    ),
    Dataset(
        "spin/scale",
        "<f4",
        ("n_leaves", N_INPUTS),
        "1",
        "by leaf: what the distances from the middle are multiplied by",
        (checks.within(0.0, MOST_SCALE),),
    ),
    Dataset(
        "spin/group_gate",
        "<i2",
        ("n_leaves", N_FEATURES, N_GROUPS),
        f"1/{GATE_UNIT}",
        "coefficients of the features in the logarithm of each group's weight",
        compressed=True,
    ),
    Dataset(
        "spin/gate",
        "<i2",
        ("n_leaves", N_GROUPS, N_FEATURES, GROUP_SIZE),
        f"1/{GATE_UNIT}",
        "the same of the experts within their group",
        compressed=True,
    ),
    Dataset(
        "spin/mean",
        "<i2",
        (*_EXPERTS, N_FEATURES, N_OUTCOMES),
        f"1/{MEAN_UNIT}",
        "coefficients of the features in the mean score of each outcome, by expert",
        compressed=True,
    ),
    Dataset(
        "spin/factor",
        "<i2",
        (*_EXPERTS, N_FACTORS),
        f"1/{FACTOR_UNIT}",
        "lower-triangular factors of the scores' covariances, rows packed: L00, L10, L11, ...",
        (spin_checks.positive_diagonal,),
        compressed=True,
    ),
    Dataset(
        "spin/quantiles",
        "<f4",
        ("n_leaves", N_OUTCOMES, "n_spin_knots"),
        "1",
        "outcomes p_u, p_v, p_w, omega_x, omega_y, omega_z at equal steps of the bounded score, "
        f"from -{SCORE_MAX:g} to {SCORE_MAX:g}; angular velocities times a/V_e",
        (checks.within(*OUTCOME), checks.non_decreasing, spin_checks.leaves_the_wall),
        compressed=True,
    ),
    Dataset(
        "spin_accuracy/alpha_deg",
        "<f8",
        ("n_spin_conditions",),
        "degree",
        "impact angle of the spinning conditions where the accuracy was measured",
        (checks.within(*ALPHA_DEG),),
    ),
    Dataset(
        "spin_accuracy/speed",
        "<f8",
        ("n_spin_conditions",),
        "m s-1",
        "impact speed of these conditions",
        (checks.within(*SPEED),),
    ),
    Dataset(
        "spin_accuracy/spin",
        "<f8",
        ("n_spin_conditions", 3),
        "1",
        "spin before the impact of these conditions, times a/V",
        (checks.within(-1e6, 1e6),),
    ),
    Dataset(
        "spin_accuracy/ks",
        "<f8",
        ("n_spin_conditions", N_OUTCOMES),
        "1",
        "Kolmogorov-Smirnov distance to direct simulation of each component",
        _SHARE,
    ),
    Dataset(
        "spin_accuracy/sliced_wasserstein",
        "<f8",
        ("n_spin_conditions",),
        "1",
        "sliced Wasserstein distance to direct simulation, standardised components",
        (checks.within(0.0, 1e9),),
    ),
    Dataset(
        "spin_accuracy/correlation_error",
        "<f8",
        ("n_spin_conditions",),
        "1",
        "largest error of a correlation between two components",
        (checks.within(0.0, 2.0),),
    ),
    Dataset(
        "spin_accuracy/auc",
        "<f8",
        ("n_spin_conditions",),
        "1",
        "area under the curve of a classifier that tells draws from direct simulation",
        _SHARE,
    ),
    Dataset(
        "spin_accuracy/joint_ks",
        "<f8",
        ("n_joint", N_OUTCOMES),
        "1",
        "over the conditions that occur in chains of impacts: Kolmogorov-Smirnov distances; a row, "
        "or none where nothing was measured",
        _SHARE,
    ),
    Dataset(
        "spin_accuracy/joint_auc",
        "<f8",
        ("n_joint",),
        "1",
        "the same for the classifier, which is told the conditions and the grain",
        _SHARE,
    ),
)


def layout_of(paths: Iterable[str]) -> tuple[Dataset, ...]:
    """Datasets that a table must have which has these: with the spin law, or without it."""
    held = any(path.startswith((GROUP, ACCURACY)) for path in paths)
    return DATASETS + SPIN_DATASETS if held else DATASETS
