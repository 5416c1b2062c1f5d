"""How finely one node is resolved: simulated particles, quantile knots, mixture components."""

from typing import NamedTuple

from tablegen.config.config import Config

#: Sizes of a mixture that the generator chooses from, about a factor of 1.4 apart.
LADDER = (32, 48, 64, 96, 128, 192, 256, 384, 512, 768, 1024, 1536)

#: An empirical distribution function of n points is off by 1.4 / sqrt(n) in the worst of six
#: channels, typically: a fifth of the allowed distance at this many over its square.
_SAMPLES = 40.0
_LEAST_SAMPLES = 150_000

#: Allowed Kolmogorov-Smirnov distances from which on this many knots are enough.
_KNOTS = ((0.015, 65), (0.004, 129), (0.0, 257))


class Resolution(NamedTuple):
    """Sizes of one node.

    Attributes
    ----------
    samples : int
        Simulated particles.
    knots : int
        Of each quantile function.
    components : int
        Of the mixture, all classes together.
    """

    samples: int
    knots: int
    components: int


def resolution(config: Config, components: int | None = None) -> Resolution:
    """Resolution that a configuration names, or that its accuracy needs.

    Parameters
    ----------
    config : Config
    components : int, optional
        Components where the configuration names none; a measurement must choose them, by default
        they are the first of `LADDER`.

    Returns
    -------
    Resolution
    """
    table, ks = config.table, config.accuracy.ks
    return Resolution(
        samples=table.samples_per_node or max(int(_SAMPLES / ks**2), _LEAST_SAMPLES),
        knots=table.quantile_knots or next(knots for least, knots in _KNOTS if ks >= least),
        components=table.components or components or LADDER[0],
    )
