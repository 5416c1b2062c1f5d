"""First hits in flow codes: conditions, states, and distances to direct simulation."""

import subprocess
from dataclasses import replace
from typing import NamedTuple

import numpy as np

import sampler
from sampler.formats.image import write_binary_table
from tablegen import load_config, simulate
from tablegen.accuracy.metrics import TOLERANCE, correlations, ks_distances
from tablegen.simulation.direct_law import DirectParts
from tablegen.simulation.exported_law import OBJECT, Target, direct_files

#: Impact angles [rad] and speeds [m/s] relative to the wall.
CONDITIONS = tuple(
    (np.radians(alpha_deg), speed)
    for alpha_deg, speed in ((5, 280), (15, 75), (30, 150), (45, 250), (60, 100), (90, 200))
)
#: Seed of the flow codes' draws; diameter and half-size of the grains [m].
SEED, DIAMETER = 7, 50e-6
HALF_SIZE = float(sampler.load("corundum-steel").mean_half_size(DIAMETER))
#: Allowed Kolmogorov-Smirnov distance of any variable and error of any correlation.
KS, CORRELATION = 0.02, 0.03
#: Rebounds compared with. Of 40,000 hits a KS above 0.0122 is noise once in 10,000 variables.
REFERENCE = 200_000


class Distances(NamedTuple):
    """Distances of some hits: name, number of hits, largest KS distance, error of a correlation."""

    name: str
    hits: int
    ks: float
    correlation: float

    @property
    def holds(self):
        return self.ks <= KS and self.correlation <= CORRELATION


def direct_states(count):
    """Simulate states (count, 6) at each condition."""
    config = load_config("corundum-steel")
    simulations = [
        simulate(config, *at, count, seed=11, stream=k) for k, at in enumerate(CONDITIONS)
    ]
    return [simulation.state for simulation in simulations]


def states_of(before, normal, after, omega, straight):
    """Return states (n, 6) in the frame of each impact; ``straight`` impacts are normal.

    Velocities are relative to the wall, and divided by V; spins are times a/V.
    """
    along = before - (before * normal).sum(axis=1, keepdims=True) * normal
    along[straight] = (1.0, 0.0, 0.0)
    e_x = along / np.linalg.norm(along, axis=1, keepdims=True)
    frame = np.stack([e_x, normal, np.cross(e_x, normal)], axis=1)
    speed = np.linalg.norm(before, axis=1, keepdims=True)
    parts = [after / speed, omega * HALF_SIZE / speed]
    return np.hstack([np.einsum("nij,nj->ni", frame, part) for part in parts])


def distances(name, sample, reference):
    """Compute distances of two samples of states; without spins, of their velocities."""
    columns = 6 if sample[:, 3:].any() else 3
    pair = sample[:, :columns], reference[:, :columns]
    found, expected = (correlations(states)[0] for states in pair)
    error = float(np.abs(found - expected).max())
    ks = float(max(ks_distances(*pair, TOLERANCE)))  # as `tablegen validate` compares spin laws
    return Distances(name, len(sample), ks, error)


def compare(states, condition, reference):
    """Compare states (n, 6) with simulated ones; ``condition`` (n,) numbers their conditions."""
    return [
        distances(f"{np.degrees(alpha):.0f} deg, {speed} m/s", states[condition == k], reference[k])
        for k, (alpha, speed) in enumerate(CONDITIONS)
    ]


def torque_on(mass, density, viscosity, factor=1.0):
    """Return the torque of a gas on the spins of these grains, as `slow` of `free_flight.fly`.

    The moment about a spin is inertia m a^2. Before the first wall there is no spin.
    """

    def slow(rows, omega, inertia, time):
        moment = np.where(inertia > 0.0, inertia, 1.0) * mass * HALF_SIZE**2 / factor
        return sampler.spin_after(omega, time, moment, DIAMETER, density, viscosity)

    return slow


def unfit_tables(path, contents):
    """Write tables that cannot be used: none at all, one cut short, and one without a spin law."""
    tables = {name: path.with_name(f"{name}.rbt") for name in ("none", "short", "plain")}
    tables["short"].write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    datasets = {path: x for path, x in contents.datasets.items() if not path.startswith("spin")}
    write_binary_table(tables["plain"], replace(contents, datasets=datasets))
    return tables


def direct_libraries(folder):
    """Build shared libraries with direct simulation: one that goes with the table, and others.

    These are of another pair, of another version of the header, and missing.
    """
    fits = DirectParts.from_config(load_config("corundum-steel"))
    parts = {
        "fits": fits,
        "other-pair": fits._replace(pair="other"),
        "other-version": fits._replace(numbers=fits.numbers | {"version": 0}),
    }
    libraries = {name: folder / f"{name}.so" for name in (*parts, "missing")}
    for name, part in parts.items():
        (folder / OBJECT).write_bytes(direct_files(part, Target.of_this_machine())[OBJECT])
        command = ["gcc", "-shared", folder / OBJECT, "-lm", "-o", libraries[name]]
        subprocess.run(command, check=True)
    return libraries


def check_bins(recorded, face, alpha, speed, most):
    """Check that histograms (faces, 20) of faces, by angle and by speed, have the hits on them."""
    counts = np.zeros(recorded.shape)
    np.add.at(counts, (face, np.digitize(np.degrees(alpha), np.arange(9, 90, 9))), 1.0)
    np.add.at(counts, (face, 10 + np.digitize(speed, most * np.arange(1, 10) / 10)), 1.0)
    for bins in (counts, recorded):
        bins[:, 4] += bins[:, 5]  # many hits are at 45 degrees, between two bins
    np.testing.assert_array_equal(*(np.delete(bins, 5, axis=1) for bins in (recorded, counts)))


def print_rows(rows):
    for row in rows:
        print("  {:16}  {:6d} hits  KS {:.4f}  error of a correlation {:.4f}".format(*row))
