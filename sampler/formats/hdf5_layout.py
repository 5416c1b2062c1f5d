"""The layout of a table file: the one description that writer, reader and documentation follow.

A file is HDF5 with root attributes (`ATTRIBUTES`) and datasets (`DATASETS`), every dataset with
its units and a long name. A new dataset or rule is added here and nowhere else.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from tablegen.fitting.fixed_point import MIXTURE_SCALE

from sampler.formats import hdf5_checks as checks
from sampler.formats.bounds import ALPHA_DEG, LINE_CHARACTERS, PAIR_BYTES, SPEED, VARIATE_MAX
from sampler.formats.checks import Check

FORMAT = "rebound-table"
#: Major and minor version. A reader takes any minor version of its major version.
FORMAT_VERSION = (1, 2)
#: What is written where nothing of a later minor version is held: older readers know all of it.
#: The second has the spin law and the range of speeds, the third the work of the impulses.
FIRST_VERSION = (1, 0)
SECOND_VERSION = (1, 1)


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


_NODES = ("n_alpha", "n_speed")
_SHARE = (checks.within(0.0, 1.0),)

DATASETS = (
    Dataset(
        "axes/alpha_deg",
        "<f8",
        ("n_alpha",),
        "degree",
        "impact angle of the nodes, from the wall",
        (checks.within(*ALPHA_DEG), checks.apart),
    ),
    Dataset(
        "axes/speed",
        "<f8",
        ("n_speed",),
        "m s-1",
        "impact speed of the nodes",
        (checks.within(*SPEED), checks.apart),
    ),
    Dataset(
        "axes/alpha_span_deg",
        "<f8",
        (2,),
        "degree",
        "impact angles at the first and the last entry of axes/alpha_coordinate",
        (checks.encloses("axes/alpha_deg", ALPHA_DEG[1]),),
    ),
    Dataset(
        "axes/alpha_coordinate",
        "<f8",
        ("n_alpha_grid",),
        "1",
        "fractional node index at equal steps of the impact angle",
        (checks.node_index("axes/alpha_deg", "axes/alpha_span_deg"),),
    ),
    Dataset(
        "axes/speed_span",
        "<f8",
        (2,),
        "m s-1",
        "impact speeds at the first and the last entry of axes/speed_coordinate",
        (checks.encloses("axes/speed", SPEED[1]),),
    ),
    Dataset(
        "axes/speed_coordinate",
        "<f8",
        ("n_speed_grid",),
        "1",
        "fractional node index at equal steps of the impact speed",
        (checks.node_index("axes/speed", "axes/speed_span"),),
    ),
    Dataset(
        "marginals/variate_knots",
        "<f8",
        ("n_knots",),
        "1",
        "mixture variates z of the quantile knots",
        (checks.symmetric_knots(*VARIATE_MAX),),
    ),
    Dataset(
        "marginals/quantiles",
        "<f4",
        (*_NODES, "n_classes", "n_marginals", "n_knots"),
        "1",
        "by class and channel, the quantile that belongs to a mixture variate; "
        "velocities over V, angular velocities times a/V",
        (checks.non_decreasing,),
        compressed=True,
    ),
    Dataset(
        "dependence/first_of_class",
        "<u2",
        (*_NODES, "n_classes"),
        "1",
        "first mixture component of each class of rebounds; a class ends where the next begins",
        (checks.class_starts,),
    ),
    Dataset(
        "dependence/alias_probability",
        "<u2",
        (*_NODES, "n_components"),
        "1/65536",
        "alias method: probability to stay in the column",
        compressed=True,
    ),
    Dataset(
        "dependence/alias_index",
        "<u2",
        (*_NODES, "n_components"),
        "1",
        "alias method: component that takes the rest of the column",
        (checks.below_length,),
        compressed=True,
    ),
    Dataset(
        "dependence/reflection",
        "<i2",
        (*_NODES, "n_components"),
        f"1/{MIXTURE_SCALE}",
        "probability of each mixture component to be reflected in the impact plane",
        (checks.within(0, MIXTURE_SCALE),),
        compressed=True,
    ),
    Dataset(
        "dependence/mean",
        "<i2",
        (*_NODES, "n_components", "n_channels"),
        f"1/{MIXTURE_SCALE}",
        "means of the mixture components, by channel",
        compressed=True,
    ),
    Dataset(
        "dependence/cholesky",
        "<i2",
        (*_NODES, "n_components", "n_factors"),
        f"1/{MIXTURE_SCALE}",
        "lower-triangular factors of the covariances, rows packed: L00, L10, L11, L20, ...",
        (checks.positive_diagonal,),
        compressed=True,
    ),
    Dataset(
        "accuracy/alpha_deg",
        "<f8",
        ("n_conditions",),
        "degree",
        "impact angle of the conditions where the accuracy was measured",
        (checks.within(*ALPHA_DEG),),
    ),
    Dataset(
        "accuracy/speed",
        "<f8",
        ("n_conditions",),
        "m s-1",
        "impact speed of the conditions where the accuracy was measured",
        (checks.within(*SPEED),),
    ),
    Dataset(
        "accuracy/ks",
        "<f8",
        ("n_conditions", "n_columns"),
        "1",
        "Kolmogorov-Smirnov distance to direct simulation of each component",
        _SHARE,
    ),
    Dataset(
        "accuracy/sliced_wasserstein",
        "<f8",
        ("n_conditions",),
        "1",
        "sliced Wasserstein distance to direct simulation, standardised components",
        (checks.within(0.0, 1e9),),
    ),
    Dataset(
        "accuracy/correlation_error",
        "<f8",
        ("n_conditions",),
        "1",
        "largest error of a correlation between two components",
        (checks.within(0.0, 2.0),),
    ),
    Dataset(
        "accuracy/auc",
        "<f8",
        ("n_conditions",),
        "1",
        "area under the curve of a classifier that tells draws from direct simulation",
        _SHARE,
    ),
)

#: Root attributes that some files have, and what they hold.
OPTIONAL_ATTRIBUTES: Mapping[str, tuple[type, str]] = {
    "speed_independent": (
        int,
        "1: rebounds do not depend on the speed, so that none is outside the table; "
        "left out where they do",
    ),
    "valid_speed": (
        str,
        "two numbers: speeds in m/s between which the laws of the pair were measured; draws at "
        "others are extrapolations; missing where nothing is known, and in older files",
    ),
    "processors": (
        str,
        "kinds of processor that took part in making the table, one a line of at most "
        f"{LINE_CHARACTERS} characters; missing in older files",
    ),
}

#: Root attributes and what they hold.
ATTRIBUTES: Mapping[str, tuple[type, str]] = {
    "format": (str, f'"{FORMAT}"'),
    "format_version": (list, "two integers: major, minor"),
    "content_sha256": (str, "checksum of everything else, hexadecimal"),
    "pair": (str, f"name of the material pair, one line of at most {PAIR_BYTES} bytes"),
    "config": (
        str,
        "TOML text from which the table was generated, without control characters but tabs and "
        "ends of lines",
    ),
    "seed": (int, "seed of the simulation behind the table, from 0 to 2**64 - 1"),
    "software_version": (
        str,
        "version of rebound-tables that made the file, one line of at most "
        f"{LINE_CHARACTERS} characters",
    ),
    "components": (str, "components of the state that a draw gives, separated by spaces"),
    "channels": (str, "channels of the mixture, in the order of its factors, separated by spaces"),
}
