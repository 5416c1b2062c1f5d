"""How large and how small what stands in a table may be: the one place where that is stated.

Within these bounds every draw is finite and physical, whatever else the numbers are, and every
table can be written as a binary table that its readers accept. They lie far beyond what a table can
mean. The reader of table files takes them through `sampler.formats.layout`, the reader in C
through `sampler.formats.generated_code`.
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
    "n_joint": (0, 1),
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
    """Whether a text can be shown on a terminal as it is: one line, nothing that controls it."""
    return text.isprintable()


def is_text(text: str) -> bool:
    """Whether a text of several lines can be shown on a terminal as it is.

    Other characters that `str.isprintable` refuses, such as spaces that do not break, stand in
    comments that people paste, and do no harm.
    """
    return _CONTROL.search(text) is None
