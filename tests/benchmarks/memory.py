"""How much of the errors along chains is memory: what three numbers of spin do not tell.

Particles rebound from six walls by direct simulation. In a second chain each gets, before every
wall, the orientation of another particle of nearly the same angle, speed, spin and grain: no law of
these can do better. The other is of the same chain and hit ("chain"), of the impacts to which the
spin law is fitted ("fit"), or any of the hit ("any"). Neighbours are not quite equal, which adds
about 1 % by the sixth hit.

    python tests/benchmarks/memory.py --shape ellipsoid --walls opposite
"""

import argparse

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from sampler.formats.shape_codes import SHAPE_CODES
from tablegen import load_config
from tablegen.accuracy.chains import after_hit
from tablegen.fitting.law_conditions import Range, spinning_impacts
from tablegen.fitting.spin_coordinates import SpeedCoordinate, coordinates, folded
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import (
    WALLS,
    depart,
    first_impacts,
    joined_impacts,
    next_impacts,
    speeds_measured,
    uniform_numbers,
)

SHAPES = tuple(SHAPE_CODES)[:4]
#: Coordinate of the shapes, which are never neighbours.
APART = 100.0
HITS, SEED = 6, 1
#: Coordinate of the speed, which counts little.
SLOWNESS = SpeedCoordinate(0.03, 0.5)


def place(impacts):
    """Coordinates in which particles are neighbours, (n, 8)."""
    conditions = np.column_stack([impacts.alpha1, impacts.speed, impacts.spin])
    q, _ = folded(coordinates(conditions, SLOWNESS))
    return np.hstack([q, impacts.grain[:, 1:], APART * impacts.grain[:, :1]])


def exchanged(model, impacts, others, tree, rng):
    """Impacts with the orientation, seen from the spin, of one of the nearest of some others."""
    if tree is None:
        pick = rng.integers(len(others.index), size=len(impacts.index))
    else:
        near = tree.query(place(impacts), k=4)[1]
        pick = near[np.arange(len(near)), rng.integers(1, 4, len(near))]
    a, b = (x / np.linalg.norm(x, axis=1)[:, None] for x in (others.spin[pick], impacts.spin))
    turn = np.column_stack([1.0 + np.sum(a * b, axis=1), np.cross(a, b)])
    turned = Rotation.from_quat(turn, scalar_first=True) * Rotation.from_quat(
        others.orientation[pick], scalar_first=True
    )
    time = rng.uniform(3.0, 15.0, len(pick)) / np.linalg.norm(impacts.spin, axis=1)
    orientation, _ = model.tumble(
        turned.as_quat(scalar_first=True), impacts.spin, impacts.grain, 1.0, time
    )
    return impacts._replace(orientation=orientation)


def chain(model, start, walls, kind, pool, rng):
    """Largest KS, and energy and squared spin less 1, beside particles that keep orientations."""
    count = len(start[0])
    index = np.arange(count, dtype=np.uint64)
    kept = given = first_impacts(*start, model.grains(SEED, index), index)
    found, walls = [], np.full(count, WALLS.index(walls))
    for hit in range(1, HITS + 1):
        both = [depart(model, impacts, SEED) for impacts in (kept, given)]
        hits = after_hit("", both[1], both[0])
        found.append((hits.estimates["chain_ks"].value, hits.energy - 1.0, hits.spin - 1.0))
        numbers = uniform_numbers(SEED, index, hit)
        kept, given = (next_impacts(model, of, walls, numbers) for of in both)
        kept, given = (x._replace(alpha1=np.maximum(x.alpha1, 2e-4)) for x in (kept, given))
        others = pool if kind == "fit" else kept
        tree = None if kind == "any" else cKDTree(place(others))
        given = exchanged(model, given, others, tree, rng)
    return np.array(found)


def main():
    raw = argparse.RawTextHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=raw)
    parser.add_argument("--pair", default="corundum-steel")
    parser.add_argument("--shape", choices=(*SHAPES, "all"), default="ellipsoid")
    parser.add_argument("--walls", choices=WALLS, default="opposite")
    parser.add_argument("--alpha", type=float, default=30.0, help="first angle, degrees")
    parser.add_argument("--count", type=int, default=100_000)
    given = parser.parse_args()
    shapes = {name: float(given.shape in (name, "all")) for name in SHAPES}
    config = load_config(given.pair).with_changes({"population": {"shapes": shapes}})
    model, rng = DirectModel(config), np.random.default_rng(SEED)
    codes = [SHAPE_CODES[name] for name, share in shapes.items() if share]
    how = 4 * given.count, lambda hit: hit, rng
    pool = joined_impacts(
        [spinning_impacts(model, Range.of(config), config.population, code, *how) for code in codes]
    )
    speed = 0.8 * speeds_measured(config)[1]
    start = [np.full(given.count, x) for x in (np.radians(given.alpha), speed)]
    for kind in ("chain", "fit", "any"):
        found = 100.0 * chain(model, start, given.walls, kind, pool, rng).T
        for name, values in zip(("KS", "energy", "spin²"), found, strict=True):
            print(f"{kind:6s} {name:6s}", *(f"{value:+6.1f} %" for value in values), flush=True)


if __name__ == "__main__":
    main()
