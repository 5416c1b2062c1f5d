"""Energy at six hits of a table that lives in a plane, against the same table in three dimensions.

python tests/benchmarks/plane_hits.py
"""

import numpy as np

import sampler
from sampler.files import find_table
from sampler.formats.hdf5 import read_table
from tablegen.config.config import scene_over, stored_config
from tablegen.tables.prune import pruned

COUNT, SPEED, HITS, HALF_SIZE = 200_000, 250.0, 6, 2e-5
UP = np.array([0.0, 1.0, 0.0])


def energies(table, turn, alpha_deg):
    """Mean energy after each hit, J/kg; `turn` mirrors the velocity before the next one or not."""
    alpha, omega, inertia, means = np.radians(alpha_deg), np.zeros(3), 0.0, []
    velocity = np.tile(SPEED * np.array([np.cos(alpha), -np.sin(alpha), 0.0]), (COUNT, 1))
    normal = UP
    for hit in range(HITS):
        keys = {"seed": 1, "index": np.arange(COUNT), "hit": hit}
        spin = {"omega": omega, "inertia": inertia}
        velocity, omega, inertia = table.rebound(velocity, normal, HALF_SIZE, **spin, **keys)
        means.append(0.5 * (velocity**2).sum(axis=1).mean())
        velocity = velocity * [1.0, -1.0, 1.0] if turn else velocity
        normal = normal if turn else -normal
    return np.array(means)


def main():
    contents = read_table(find_table("corundum-steel"))
    scene, _ = scene_over(stored_config(contents.config, "config"), "plane-flow")
    whole, plane = sampler.Table(contents), sampler.Table(pruned(contents, scene))
    for walls, turn in (("one wall", True), ("opposite walls", False)):
        for alpha_deg in (15.0, 45.0):
            ratios = energies(plane, turn, alpha_deg) / energies(whole, turn, alpha_deg)
            print(f"{walls}, {alpha_deg:g} degrees first:", *np.round(ratios, 3))


if __name__ == "__main__":
    main()
