"""Accuracy of tables of first impacts: the experiments behind tablegen/fitting/EXPERIMENTS.md.

    python tests/benchmarks/table_designs.py NAME

where NAME is one of

interpolation   error between two nodes, without any fit: by class of rebounds or all together
abscissa        the same in the angle, by the abscissa in which it is linear
mixture         error at a node and time of the fit, by number of components
reflection      error at a node with fitted probabilities of reflection and with 1/2
knots           error at a node, by knots of the quantile functions
"""

import sys
import time
from functools import lru_cache

import harness  # noqa: F401  (makes the imports from a checkout possible)
import numpy as np
from scipy.special import ndtr

from sampler.formats.channels import to_channels
from sampler.table import Table
from tablegen.accuracy.metrics import ESTIMATES, Settings
from tablegen.config.config import load_config
from tablegen.config.metric_table import METRICS
from tablegen.fitting.components import class_of
from tablegen.fitting.marginals import normal_scores
from tablegen.fitting.node import fit_node
from tablegen.fitting.resolution import Resolution
from tablegen.simulation.simulate import simulate
from tablegen.tables.assembly import assemble
from tablegen.tables.axes import make_axes
from tablegen.tables.intervals import Grid

CONFIG = load_config("corundum-steel")
COUNT = 400_000
KNOTS = np.linspace(-4.5, 4.5, 3001)

#: Difficult cells: alpha, V and two speeds, or two angles, between which they lie.
SPEED_CELLS = (
    (88.0, 250.0, 203.0, 300.0),
    (77.5, 140.0, 115.0, 170.0),
    (85.0, 60.0, 52.0, 70.0),
    (42.5, 140.0, 80.0, 250.0),
    (9.0, 100.0, 50.0, 200.0),
)
ANGLE_CELLS = (
    (0.7, 100.0, 0.5, 0.9),
    (3.0, 100.0, 2.4, 3.6),
    (9.0, 63.0, 7.0, 11.0),
    (20.0, 100.0, 17.5, 22.5),
    (77.5, 140.0, 75.0, 80.0),
)
ABSCISSAS = {"angle": lambda x: x, "root": np.sqrt, "logarithm": np.log, "square": np.square}


@lru_cache(32)
def simulated(alpha_deg, speed, stream):
    """Simulate states and their classes."""
    result = simulate(CONFIG, np.radians(alpha_deg), speed, COUNT, seed=1, stream=stream, threads=1)
    return result.state, class_of(result.collisions)


def report(name, drawn, alpha, speed):
    """Print every distance of drawn states from direct simulation."""
    direct, found = simulated(alpha, speed, 2)[0], []
    for key, metric in METRICS.items():
        a, b = drawn[: metric.trial_states], direct[: metric.trial_states]
        found.append(f"{metric.head} {ESTIMATES[key](a, b, Settings(0, 16)).value:.4f}")
    print(f"{alpha:g} deg, {speed:g} m/s, {name:38}", *found, flush=True)


def states_of(channels):
    """Turn channels into states."""
    v, u_hat, omega_z, w_hat, omega_x, omega_y = channels.T
    rest = (1.0 - v) * (1.0 + v)
    u = u_hat * np.sqrt(rest)
    w = w_hat * np.sqrt(rest * (1.0 - u_hat) * (1.0 + u_hat))
    return np.column_stack([u, v, w, omega_x, omega_y, omega_z])


def blended(corners, weight, by_class=True):
    """Draw between two nodes with known laws: scores of one node, averaged quantiles.

    An infinitely large mixture would draw the same.
    """
    rng, parts, laws, weights = np.random.default_rng(9), [], [], (1.0 - weight, weight)
    for alpha_deg, speed in corners:
        state, kind = simulated(alpha_deg, speed, 1)
        kind = kind if by_class else np.zeros_like(kind)
        laws.append([to_channels(state[kind == k]) for k in range(2) if (kind == k).any()])
    for own, law in zip(weights, laws, strict=True):
        for k, channels in enumerate(law):
            chosen = rng.permutation(len(channels))[: round(own * len(channels))]
            scores = normal_scores(channels, np.ones(6))[chosen]
            part = np.zeros_like(scores)
            for share, other in zip(weights, laws, strict=True):
                quantiles = np.quantile(other[k], ndtr(KNOTS), axis=0, method="hazen")
                for j in range(6):
                    part[:, j] += share * np.interp(scores[:, j], KNOTS, quantiles[:, j])
            parts.append(part)
    return rng.permutation(states_of(np.concatenate(parts)))


def between(x, low, high):
    """Weight of the upper of two nodes."""
    return (x - low) / (high - low)


def interpolation():
    """Two nodes of one angle, then of one speed."""
    for by_class in (False, True):
        name = "by class" if by_class else "together"
        for alpha, speed, low, high in SPEED_CELLS:
            weight = between(*CONFIG.speed_coordinate(np.array([speed, low, high])))
            drawn = blended([(alpha, low), (alpha, high)], weight, by_class)
            report(f"from {low:g} and {high:g} m/s {name}", drawn, alpha, speed)
        for alpha, speed, low, high in ANGLE_CELLS:
            weight = between(*np.sqrt([alpha, low, high]))
            drawn = blended([(low, speed), (high, speed)], weight, by_class)
            report(f"from {low:g} and {high:g} deg {name}", drawn, alpha, speed)


def abscissa():
    """Two nodes of one speed with weights from several abscissas."""
    for alpha, speed, low, high in ANGLE_CELLS:
        for name, function in ABSCISSAS.items():
            weight = between(*function(np.array([alpha, low, high])))
            drawn = blended([(low, speed), (high, speed)], weight)
            report(f"from {low:g} and {high:g} deg {name}", drawn, alpha, speed)


def at_node(alpha, speed, knots, components, mirror=False):
    """Error at a node, bytes of its mixture, and seconds of its fit."""
    begin, config = time.thread_time(), CONFIG.with_changes({"table": {"mirror": mirror}})
    node = fit_node(config, alpha, speed, Resolution(COUNT, knots, components))
    seconds = time.thread_time() - begin
    table = Table(assemble(config, make_axes(config, Grid((alpha,), (speed,))), [node]))
    drawn = table.sample(np.radians(alpha), speed, seed=2, index=np.arange(COUNT))
    size = sum(array.nbytes for array in node) - node.quantiles.nbytes
    name = f"{components} components {size / 1e3:.1f} kB {knots} knots"
    name += f" mirror {mirror} {seconds:.1f} s"
    report(name, drawn, alpha, speed)


def mixture():
    """Nodes of several numbers of components."""
    for alpha, speed in ((0.7, 100.0), (9.0, 63.0), (42.5, 140.0), (77.5, 140.0), (88.0, 250.0)):
        for components in (32, 64, 128, 256, 512):
            at_node(alpha, speed, 129, components)


def reflection():
    """Nodes with reflection fitted, or with probability 1/2."""
    for alpha, speed in ((9.0, 63.0), (35.7, 300.0), (88.0, 250.0)):
        for components in (256, 512):
            for mirror in (True, False):
                at_node(alpha, speed, 129, components, mirror)


def knots():
    """Nodes of several numbers of knots."""
    for alpha, speed in ((0.7, 100.0), (35.7, 300.0), (88.0, 250.0)):
        for count in (257, 129, 65, 33):
            at_node(alpha, speed, count, 128)


if __name__ == "__main__":
    experiments = (interpolation, abscissa, mixture, reflection, knots)
    {experiment.__name__: experiment for experiment in experiments}[sys.argv[1]]()
