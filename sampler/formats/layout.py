"""The layout of a table file: the one description that writer, reader and documentation follow.

A file is HDF5 with root attributes (`ATTRIBUTES`) and datasets (`DATASETS`), every dataset with
its units and a long name. A new dataset or rule is added here and nowhere else.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, NamedTuple

from sampler.formats import checks
from sampler.formats.bounds import (
    ALPHA_DEG,
    FACTOR_UNIT,
    GATE_UNIT,
    GROUP_SIZE,
    INERTIA_COEFFICIENT,
    LEAST_INERTIA,
    LEAST_RATIO,
    LINE_CHARACTERS,
    MEAN_UNIT,
    MIXTURE_SCALE,
    MOST_CUT,
    MOST_GEOMETRY,
    MOST_MIDDLE,
    MOST_SCALE,
    N_CONDITIONS,
    N_EXPERTS,
    N_FEATURES,
    N_GROUPS,
    N_INPUTS,
    N_KAPPA_QUANTILES,
    OUTCOME,
    PAIR_BYTES,
    RATIOS,
    SCORE_MAX,
    SPEED,
    SPEED_COORDINATE,
    SPIN_SIZE,
    SPIN_SPEED,
    VARIATE_MAX,
    is_line,
    is_text,
)
from sampler.formats.checks import Check

FORMAT = "rebound-table"
#: Major and minor version. A reader takes any minor version of its major version.
FORMAT_VERSION = (1, 0)


@dataclass(frozen=True)
class Dataset:
    """One dataset of the file.

    Attributes
    ----------
    path : str
        Group and name.
    dtype : str
        As numpy's ``dtype.str``.
    dims : tuple of str or int
        Shape; a name stands for the same length wherever it occurs.
    units, long_name : str
        Stored beside the values.
    checks : tuple of Check
        What the values must fulfil, besides being finite; quantiles also
        `sampler.formats.bounds.QUANTILES`.
    compressed : bool
        Whether it is large enough to be worth gzip.
    """

    path: str
    dtype: str
    dims: tuple[str | int, ...]
    units: str
    long_name: str
    checks: tuple[Check, ...] = ()
    compressed: bool = False


# Each has name, type, shape and units in its first line, then its meaning and its checks.

_NODES = ("n_alpha", "n_speed")
_SHARE = (checks.within(0.0, 1.0),)


def _distances(group: str, conditions: str, columns: str) -> tuple[Dataset, ...]:
    """Describe the distances to direct simulation of a group, by condition."""
    return (
        Dataset(f"{group}/ks", "<f8", (conditions, columns), "1",
            "Kolmogorov-Smirnov distance to direct simulation of each variable", _SHARE),
        Dataset(f"{group}/sliced_wasserstein", "<f8", (conditions,), "1",
            "sliced Wasserstein distance to direct simulation, standardised variables",
            (checks.within(0.0, 1e9),)),
        Dataset(f"{group}/correlation_error", "<f8", (conditions,), "1",
            "largest error of a correlation between two variables", (checks.within(0.0, 2.0),)),
        Dataset(f"{group}/auc", "<f8", (conditions,), "1",
            "area under the curve of a classifier that tells draws from direct simulation", _SHARE),
    )  # fmt: skip


DATASETS = (
    Dataset("axes/alpha_deg", "<f8", ("n_alpha",), "degree",
        "impact angle of the nodes, from the wall", (checks.within(*ALPHA_DEG), checks.apart)),
    Dataset("axes/speed", "<f8", ("n_speed",), "m s-1",
        "impact speed of the nodes", (checks.within(*SPEED), checks.apart)),
    Dataset("axes/alpha_span_deg", "<f8", (2,), "degree",
        "impact angles at the first and the last entry of axes/alpha_coordinate",
        (checks.encloses("axes/alpha_deg", ALPHA_DEG[1]),)),
    Dataset("axes/alpha_coordinate", "<f8", ("n_alpha_grid",), "1",
        "fractional node index at equal steps of the impact angle",
        (checks.node_index("axes/alpha_deg", "axes/alpha_span_deg"),)),
    Dataset("axes/speed_span", "<f8", (2,), "m s-1",
        "impact speeds at the first and the last entry of axes/speed_coordinate",
        (checks.encloses("axes/speed", SPEED[1]),)),
    Dataset("axes/speed_coordinate", "<f8", ("n_speed_grid",), "1",
        "fractional node index at equal steps of the impact speed",
        (checks.node_index("axes/speed", "axes/speed_span"),)),
    Dataset("marginals/variate_knots", "<f8", ("n_knots",), "1",
        "mixture variates z of the quantile knots", (checks.symmetric_knots(*VARIATE_MAX),)),
    Dataset("marginals/quantiles", "<f4", (*_NODES, "n_classes", "n_marginals", "n_knots"), "1",
        "by class and channel, the quantile that belongs to a mixture variate; "
        "velocities over V, angular velocities times a/V",
        (checks.non_decreasing,), compressed=True),
    Dataset("dependence/first_of_class", "<u2", (*_NODES, "n_classes"), "1",
        "first mixture component of each class of rebounds; a class ends where the next begins",
        (checks.class_starts,)),
    Dataset("dependence/alias_probability", "<u2", (*_NODES, "n_components"), "1/65536",
        "alias method: probability of the component of the column", compressed=True),
    Dataset("dependence/alias_index", "<u2", (*_NODES, "n_components"), "1",
        "alias method: the other component of the column",
        (checks.below_length,), compressed=True),
    Dataset("dependence/reflection", "<i2", (*_NODES, "n_components"), f"1/{MIXTURE_SCALE}",
        "probability that a draw of a component is reflected in the impact plane",
        (checks.within(0, MIXTURE_SCALE),), compressed=True),
    Dataset("dependence/mean", "<i2", (*_NODES, "n_components", "n_channels"), f"1/{MIXTURE_SCALE}",
        "means of the mixture components, by channel", compressed=True),
    Dataset("dependence/cholesky", "<i2", (*_NODES, "n_components", "n_factors"),
        f"1/{MIXTURE_SCALE}",
        "lower-triangular factors of the covariances, rows packed: L00, L10, L11, L20, ...",
        (checks.positive_diagonals_of("dependence/mean"),), compressed=True),
    Dataset("accuracy/alpha_deg", "<f8", ("n_conditions",), "degree",
        "impact angle of the conditions at which the accuracy was measured",
        (checks.within(*ALPHA_DEG),)),
    Dataset("accuracy/speed", "<f8", ("n_conditions",), "m s-1",
        "impact speed of these conditions", (checks.within(*SPEED),)),
    *_distances("accuracy", "n_conditions", "n_columns"),
)  # fmt: skip

#: Where the datasets of the spin law begin, and those of its accuracy.
GROUP, ACCURACY = "spin/", "spin_accuracy/"

_EXPERTS = ("n_leaves", N_EXPERTS)

SPIN_DATASETS = (
    Dataset("spin/shape_codes", "<i4", ("n_shapes",), "1",
        "shapes and meshes of the particles for which the law was made",
        (checks.increasing, checks.within(0, 2**30))),
    Dataset("spin/shape_weights", "<f8", ("n_shapes",), "1",
        "share of each shape in the population of the configuration",
        (*_SHARE, checks.spin_adds_up)),
    Dataset("spin/ratio_range", "<f8", ("n_shapes", 2, 2), "1",
        "smallest and largest b/a, then c/b, that were simulated",
        (checks.within(LEAST_RATIO, 1.0), checks.non_decreasing)),
    Dataset("spin/shape_inertia", "<f8", ("n_shapes", 2), "1",
        "coefficients g1, g3: moments of inertia over m a^2 of a grain with beta = b/a, "
        "gamma = c/b, largest g1 (1 + beta^2), smallest g3 beta^2 (1 + gamma^2); so the moments of "
        "a shape that is drawn with several ratios must be q (b^2 + c^2), as no cylinder's are",
        (checks.within(*INERTIA_COEFFICIENT),)),
    Dataset("spin/shape_geometry", "<f8", ("n_shapes", 4), "1",
        "volume over a b c; mean moment of inertia over m (a^2 + b^2 + c^2); s, t of the surface "
        "s (a b + b c + c a) + t (a^2 b^2 + b^2 c^2 + c^2 a^2)^(1/2), both 0 for an ellipsoid",
        (checks.within(0.0, MOST_GEOMETRY), checks.bodies)),
    Dataset("spin/kappa_quantiles", "<f8", ("n_shapes", N_KAPPA_QUANTILES), "1",
        "place kappa of the inertia about the spin, by shape, that rebounds leave: at equal steps "
        "of probability from 0 to 1; 0 at the smallest moment of inertia, 1 at the largest",
        (*_SHARE, checks.non_decreasing)),
    Dataset("spin/aspect", "<f8", (2, 4), "1",
        "normal laws of b/a and c/b in the population: mean, standard deviation, and the standard "
        "normal probabilities of the ends of the range; with a deviation of 0 always the mean",
        (checks.spin_aspect_law,)),
    Dataset("spin/speed_coordinate", "<f8", (2,), "1",
        "coefficient k and exponent n of the speed's coordinate exp(-k V_e^n), V_e in m/s",
        (checks.within(*SPEED_COORDINATE),)),
    Dataset("spin/alpha_range_deg", "<f8", (2,), "degree",
        "smallest and largest impact angle of the law",
        (checks.within(*ALPHA_DEG), checks.non_decreasing)),
    Dataset("spin/speed_range", "<f8", (2,), "m s-1",
        "smallest and largest effective speed V_e of the law",
        (checks.within(*SPIN_SPEED), checks.non_decreasing)),
    Dataset("spin/spin_range", "<f8", (2,), "1",
        "smallest and largest size of the spin, a |Omega| / V, of the law",
        (checks.within(*SPIN_SIZE), checks.non_decreasing)),
    Dataset("spin/roots", "<i4", ("n_shapes",), "1",
        "node at which the tree of a shape begins", (checks.spin_roots,)),
    Dataset("spin/node_axis", "|i1", ("n_nodes",), "1",
        f"what a node compares: 0 to {N_CONDITIONS - 1} a condition, {N_CONDITIONS} the square of "
        f"the coordinate of the spin, {N_CONDITIONS + 1} sqrt(1 - b/a), {N_CONDITIONS + 2} "
        "sqrt(1 - c/b)",
        (checks.within(0, N_CONDITIONS + len(RATIOS)),)),
    Dataset("spin/node_cut", "<f8", ("n_nodes",), "1",
        "values of this size or more belong to the second child",
        (checks.within(-MOST_CUT, MOST_CUT),)),
    Dataset("spin/node_child", "<i4", ("n_nodes", 2), "1",
        "children: a later node, or -1 - the number of a leaf", (checks.spin_children,)),
    Dataset("spin/centre", "<f4", ("n_leaves", N_INPUTS), "1",
        "by leaf: middle of the seven numbers of a condition, sqrt(1 - b/a), sqrt(1 - c/b)",
        (checks.within(-MOST_MIDDLE, MOST_MIDDLE),)),
    Dataset("spin/scale", "<f4", ("n_leaves", N_INPUTS), "1",
        "by leaf: factors for the distances from the middle",
        (checks.within(0.0, MOST_SCALE),)),
    Dataset("spin/group_gate", "<i2", ("n_leaves", N_FEATURES, N_GROUPS), f"1/{GATE_UNIT}",
        "coefficients of the features in the logarithm of each group's weight", compressed=True),
    Dataset("spin/gate", "<i2", ("n_leaves", N_GROUPS, N_FEATURES, GROUP_SIZE), f"1/{GATE_UNIT}",
        "coefficients of the features in the logarithm of each expert's weight within its group",
        compressed=True),
    Dataset("spin/mean", "<i2", (*_EXPERTS, N_FEATURES, "n_outcomes"), f"1/{MEAN_UNIT}",
        "coefficients of the features in the mean score of each outcome, by expert",
        compressed=True),
    Dataset("spin/factor", "<i2", (*_EXPERTS, "n_spin_factors"), f"1/{FACTOR_UNIT}",
        "lower-triangular factors of the scores' covariances, rows packed: L00, L10, L11, ...",
        (checks.positive_diagonals_of("spin/mean"),), compressed=True),
    Dataset("spin/quantiles", "<f4", ("n_leaves", "n_outcomes", "n_spin_knots"), "1",
        "outcomes p_u, p_v, p_w, o_x, o_y, o_z, h, and of a law with works a, at equal steps "
        f"of the bounded score, from -{SCORE_MAX:g} to {SCORE_MAX:g}",
        (checks.within(*OUTCOME), checks.non_decreasing, checks.spin_leaves_the_wall),
        compressed=True),
    Dataset("spin_accuracy/alpha_deg", "<f8", ("n_spin_conditions",), "degree",
        "impact angle of the conditions at which the accuracy of the spin law was measured",
        (checks.within(*ALPHA_DEG),)),
    Dataset("spin_accuracy/speed", "<f8", ("n_spin_conditions",), "m s-1",
        "impact speed of these conditions", (checks.within(*SPEED),)),
    Dataset("spin_accuracy/spin", "<f8", ("n_spin_conditions", 3), "1",
        "spin before the impact of these conditions, times a/V", (checks.within(-1e6, 1e6),)),
    *_distances("spin_accuracy", "n_spin_conditions", "n_spin_columns"),
    *(
        Dataset(f"spin_accuracy/{name}", "<f8", ("n_chained",), "1", f"{what} at hits of chains")
        for name, what in (
            ("chain_ks", "largest Kolmogorov-Smirnov distance"),
            ("chain_energy", "error of the share of the energy that is kept"),
            ("chain_spin", "error of the mean squared spin"),
            ("chain_angle", "error of the median angle"),
        )
    ),
)  # fmt: skip

#: Of a table of spheres, whose laws of contact take the place of nodes.
SPHERE_DATASETS = (
    Dataset("sphere/laws", "<f8", ("n_law_parameters",), "1",
        "laws of contact: eight numbers, then the coefficients and tables of the laws, as the "
        "section on spheres of tables/FORMAT.md describes them",
        (checks.contact_laws,)),
)  # fmt: skip

#: Of a spin law whose ellipsoids without spin count from the rebound of a sphere.
BY_SPHERE = Dataset("spin/laws", "<f8", ("n_law_parameters",), "1",
    "laws of contact by which ellipsoids without spin are drawn, as sphere/laws; both are tables",
    (checks.contact_laws, checks.tabulated_laws))  # fmt: skip

#: What a table of spheres shares with others.
_SHARED = (
    "axes/alpha_deg axes/speed spin/shape_codes spin/shape_weights spin/ratio_range "
    "spin/shape_geometry spin/aspect"
)


def layout_of(paths: Iterable[str]) -> tuple[Dataset, ...]:
    """Give the datasets that a table with these paths must have: of spheres, or of nodes."""
    given = set(paths)
    if SPHERE_DATASETS[0].path in given:
        every = (*DATASETS, *SPIN_DATASETS)
        shared = (d for d in every if d.path in _SHARED.split() or d.path.startswith("accuracy/"))
        return (*shared, *SPHERE_DATASETS)
    has_spin = any(path.startswith((GROUP, ACCURACY)) for path in given)
    by_sphere = (BY_SPHERE,) if BY_SPHERE.path in given else ()
    return (*DATASETS, *SPIN_DATASETS, *by_sphere) if has_spin else DATASETS


class Attribute(NamedTuple):
    """A root attribute: its type, what it holds, and whether it may hold a value."""

    kind: type
    meaning: str
    holds: Callable[[Any], bool] = lambda _: True


def _is_pair(value: str) -> bool:
    return is_line(value) and len(value.encode()) <= PAIR_BYTES


def _are_speeds(value: list[Any]) -> bool:
    numbers = [type(speed) for speed in value] == [float, float]
    return numbers and 0.0 <= value[0] <= value[1] <= SPEED[1]


#: Root attributes that tell of the file, and those that tell of the table.
FILE_ATTRIBUTES = {
    "format": Attribute(str, f'"{FORMAT}"'),
    "format_version": Attribute(list, "two integers: major, minor"),
    "content_sha256": Attribute(str, "checksum of the datasets and attributes, hexadecimal"),
    "file_sha256": Attribute(str, "checksum of the bytes of the file, hexadecimal"),
}
ATTRIBUTES = {
    "pair": Attribute(
        str, f"name of the material pair, one line of at most {PAIR_BYTES} bytes", _is_pair
    ),
    "config": Attribute(
        str,
        "TOML text from which the table was generated, without control characters but tabs and "
        "ends of lines",
        is_text,
    ),
    "seed": Attribute(
        int,
        "seed of the simulation behind the table, from 0 to 2**64 - 1",
        lambda value: 0 <= value < 2**64,
    ),
    "software_version": Attribute(
        str,
        "version of rebound-tables that made the file, one line of at most "
        f"{LINE_CHARACTERS} characters",
        lambda value: is_line(value) and len(value) <= LINE_CHARACTERS,
    ),
    "variables": Attribute(str, "variables of the state that a draw gives, separated by spaces"),
    "channels": Attribute(
        str, "channels of the mixture, in the order of its factors, separated by spaces"
    ),
    "speed_independent": Attribute(
        int,
        "1: rebounds do not depend on the speed, so that none is outside the table; else 0",
        lambda value: value in (0, 1),
    ),
    "least_inertia": Attribute(
        float,
        "smallest principal moment of inertia over m a^2 of any grain of the population, "
        f"{LEAST_INERTIA[0]:g} to {LEAST_INERTIA[1]:.3g}",
        lambda value: LEAST_INERTIA[0] <= value <= LEAST_INERTIA[1],
    ),
    "valid_speed": Attribute(
        list,
        "two numbers: speeds in m/s between which the laws of the pair were measured; draws at "
        "others are extrapolations; missing where nothing is known",
        _are_speeds,
    ),
}

#: The attribute that may be missing.
OPTIONAL_ATTRIBUTE = "valid_speed"
