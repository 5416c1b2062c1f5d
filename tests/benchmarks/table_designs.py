"""What limits the accuracy of a table: the experiments behind tablegen/fitting/EXPERIMENTS.md.

Run ``python tests/benchmarks/table_designs.py NAME``, where NAME is one of

interpolation   error between two nodes, without any fit: by class of rebounds or all together
abscissa        the same in the angle, by the abscissa in which it is linear
mixture         error at a node and time of the fit, by number of components
reflection      error at a node with fitted probabilities of reflection and with 1/2
knots           error at a node, by knots of the quantile functions
"""

import sys
from functools import lru_cache

import numpy as np
from scipy.special import ndtr

from sampler.formats.channels import to_channels
from sampler.table import Table
from tablegen.accuracy.metrics import DISTANCES, ks_distances
from tablegen.checkpoints import Stopwatch
from tablegen.config.config import load_config
from tablegen.config.metric_table import METRICS
from tablegen.fitting.classes import class_of
from tablegen.fitting.node import fit_node
from tablegen.fitting.resolution import Resolution
from tablegen.fitting.scores import normal_scores
from tablegen.simulation.simulate import simulate
from tablegen.tables.assembly import assemble
from tablegen.tables.axes import make_axes
from tablegen.tables.intervals import Grid

CONFIG = load_config("corundum-steel")
COUNT = 400_000
KNOTS = np.linspace(-4.5, 4.5, 3001)

#: Cells (alpha, V), (alpha1, alpha2), (V1, V2): hard ones of every kind.
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
    """States and classes of fresh particles."""
    result = simulate(CONFIG, np.radians(alpha_deg), speed, COUNT, seed=1, stream=stream, threads=1)
    return result.state, class_of(result.collisions)


def distances(drawn, direct):
    """Every metric, as text."""
    found = []
    for name, metric in METRICS.items():
        a, b = drawn[: metric.trial_states], direct[: metric.trial_states]
        found.append(f"{metric.head} {np.max(DISTANCES[name](a, b, 16, 0)):.4f}")
    return "  ".join(found)


def states_of(channels):
    """States of channels: what a draw does last."""
    v, u_hat, omega_z, w_hat, omega_x, omega_y = channels.T
    rest = (1.0 - v) * (1.0 + v)
    u = u_hat * np.sqrt(rest)
    w = w_hat * np.sqrt(rest * (1.0 - u_hat) * (1.0 + u_hat))
    return np.column_stack([u, v, w, omega_x, omega_y, omega_z])


def blended(corners, weights, by_class):
    """States between nodes whose law is known: scores of one node, quantiles averaged.

    This is what an infinitely large mixture would draw.
    """
    rng, parts = np.random.default_rng(9), []
    laws = []
    for alpha_deg, speed in corners:
        state, kind = simulated(alpha_deg, speed, 1)
        kind = kind if by_class else np.zeros_like(kind)
        laws.append([to_channels(state[kind == k]) for k in range(2) if (kind == k).any()])
    for weight, law in zip(weights, laws, strict=True):
        for k, channels in enumerate(law):
            chosen = rng.permutation(len(channels))[: round(weight * len(channels))]
            scores = normal_scores(channels, np.ones(6))[chosen]
            parts.append(np.zeros_like(scores))
            for other_weight, other in zip(weights, laws, strict=True):
                quantiles = np.quantile(other[k], ndtr(KNOTS), axis=0, method="hazen")
                for j in range(6):
                    parts[-1][:, j] += other_weight * np.interp(
                        scores[:, j], KNOTS, quantiles[:, j]
                    )
    return rng.permutation(states_of(np.concatenate(parts)))


def interpolation():
    """Two nodes of one angle, then of one speed."""
    for alpha, speed, low, high in SPEED_CELLS:
        x = CONFIG.speed_coordinate(np.array([low, speed, high]))
        weight = (x[0] - x[1]) / (x[0] - x[2])
        for by_class in (False, True):
            drawn = blended([(alpha, low), (alpha, high)], (1.0 - weight, weight), by_class)
            name = f"{alpha:g} deg, {speed:g} m/s from {low:g} and {high:g}"
            report(name, by_class, drawn, simulated(alpha, speed, 2)[0])
    for alpha, speed, low, high in ANGLE_CELLS:
        weight = (np.sqrt(alpha) - np.sqrt(low)) / (np.sqrt(high) - np.sqrt(low))
        for by_class in (False, True):
            drawn = blended([(low, speed), (high, speed)], (1.0 - weight, weight), by_class)
            name = f"{speed:g} m/s, {alpha:g} deg from {low:g} and {high:g}"
            report(name, by_class, drawn, simulated(alpha, speed, 2)[0])


def report(name, by_class, drawn, direct):
    print(f"{name:38} {'by class' if by_class else 'together':9} {distances(drawn, direct)}")


def abscissa():
    """The same nodes with weights from several abscissas, by class."""
    for alpha, speed, low, high in ANGLE_CELLS:
        for name, function in ABSCISSAS.items():
            weight = (function(alpha) - function(low)) / (function(high) - function(low))
            drawn = blended([(low, speed), (high, speed)], (1.0 - weight, weight), True)
            direct = simulated(alpha, speed, 2)[0]
            place = f"{speed:g} m/s, {alpha:g} deg from {low:g} and {high:g}"
            print(f"{place:38} {name:10} KS {ks_distances(drawn, direct).max():.4f}")


def one_node(alpha, speed, size, mirror=False):
    """Table of one node, and the seconds that its fit took beside the simulation."""
    watch, config = Stopwatch(), CONFIG.with_changes({"table": {"mirror": mirror}})
    node = fit_node(config, alpha, speed, size, watch)
    axes = make_axes(config, Grid((alpha,), (speed,)))
    return Table(assemble(config, axes, [node])), watch.seconds[1]


def mixture():
    """Accuracy at the very condition, by number of components."""
    for alpha, speed in ((0.7, 100.0), (9.0, 63.0), (42.5, 140.0), (77.5, 140.0), (88.0, 250.0)):
        for components in (32, 64, 128, 256, 512):
            table, seconds = one_node(alpha, speed, Resolution(COUNT, 129, components))
            drawn = table.sample(np.radians(alpha), speed, seed=2, index=np.arange(COUNT))
            stored = sum(
                table.contents[f"dependence/{name}"].nbytes
                for name in ("reflection", "mean", "cholesky", "alias_probability", "alias_index")
            )
            print(
                f"{alpha:5g} deg {speed:4g} m/s  {components:4d} components {stored / 1e3:5.1f} kB "
                f"{seconds:5.1f} s  {distances(drawn, simulated(alpha, speed, 2)[0])}",
                flush=True,
            )


def reflection():
    """Accuracy at the very condition, with reflection fitted or at random."""
    for alpha, speed in ((9.0, 63.0), (35.7, 300.0), (88.0, 250.0)):
        for mirrored, components in ((True, 256), (False, 256), (True, 512), (False, 512)):
            table, seconds = one_node(alpha, speed, Resolution(COUNT, 129, components), mirrored)
            drawn = table.sample(np.radians(alpha), speed, seed=2, index=np.arange(COUNT))
            print(
                f"{alpha:g} deg {speed:g} m/s {'1/2' if mirrored else 'fitted':6} {components} "
                f"{seconds:5.1f} s  {distances(drawn, simulated(alpha, speed, 2)[0])}",
                flush=True,
            )


def knots():
    """Accuracy of the marginals at the very condition, by number of knots."""
    for alpha, speed in ((0.7, 100.0), (35.7, 300.0), (88.0, 250.0)):
        for quantile_knots in (257, 129, 65, 33):
            table, _ = one_node(alpha, speed, Resolution(COUNT, quantile_knots, 128))
            drawn = table.sample(np.radians(alpha), speed, seed=2, index=np.arange(COUNT))
            ks = ks_distances(drawn, simulated(alpha, speed, 2)[0])
            print(f"{alpha:g} deg {speed:g} m/s {quantile_knots:4d}  {ks.round(4)}", flush=True)


EXPERIMENTS = (interpolation, abscissa, mixture, reflection, knots)

if __name__ == "__main__":
    chosen = {experiment.__name__: experiment for experiment in EXPERIMENTS}
    if len(sys.argv) != 2 or sys.argv[1] not in chosen:
        raise SystemExit(f"usage: table_designs.py {{{','.join(chosen)}}}")
    chosen[sys.argv[1]]()
