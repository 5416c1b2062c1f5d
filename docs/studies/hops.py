"""Grains that a gas drives along a wall and a force presses to it: how many come to rest, by shape.

    python docs/studies/hops.py

A grain of 40 micrometres hops along one wall. Between hits the gas takes its slip along the wall,
and slows down its spin and its normal velocity, by Stokes's laws of a sphere. It rests where a hop
would be lower than a hundredth of its diameter. A hop that low follows from a rebound that leaves
the wall at a few thousandths of the speed, so this flow tests the slow end of a law.
"""

import argparse

import numpy as np
from tqdm import tqdm

import sampler
import tablegen

DIAMETER, DENSITY, VISCOSITY = 40e-6, 3950.0, 1.85e-5  # m, kg/m^3, Pa s
DRAG_RATE = 18.0 * VISCOSITY / (DENSITY * DIAMETER**2)  # 1/s
TORQUE_RATE = 60.0 * VISCOSITY / (DENSITY * DIAMETER**2)
LOWEST_HOP = 0.01 * DIAMETER
ANGLE = np.radians(20.0)  # of the first hit
HITS = 400
SEED = 1
#: Speed of the gas along the wall, m/s, and acceleration to the wall, m/s^2.
CASES = ((15.0, 1e3), (30.0, 2e3), (60.0, 5e3))
SHAPES = ("ellipsoid", "prism", "truncated-prism", "tetrahedron")


def come_to_rest(law, grains, half_size, gas_speed, acceleration, progress):
    """Follow grains for 400 hits; tell which of them come to rest.

    Parameters
    ----------
    law : sampler.Table or tablegen.DirectModel
    grains : (n, 3) array
        Shape, b/a and c/b of each grain; the law draws the same grains from the same keys.
    half_size : (n,) array
        Half-sizes of the grains [m].
    gas_speed, acceleration : float
        [m/s], [m/s^2]
    progress : tqdm.tqdm
        Counts hits.

    Returns
    -------
    (n,) bool
    """
    n = len(grains)
    velocity = np.tile(gas_speed * np.array([np.cos(ANGLE), -np.sin(ANGLE), 0.0]), (n, 1))
    omega, inertia = np.zeros((n, 3)), np.zeros(n)
    resting_speed = np.sqrt(2.0 * acceleration * LOWEST_HOP)
    hopping = np.arange(n)
    for hit in range(HITS):
        after, spin, inertia[hopping] = law.rebound(
            velocity[hopping],
            [0.0, 1.0, 0.0],
            half_size[hopping],
            omega=omega[hopping],
            inertia=inertia[hopping],
            seed=SEED,
            index=hopping,
            hit=hit,
        )
        flight = 2.0 * after[:, 1] / acceleration
        drag = np.exp(-DRAG_RATE * flight)
        along_wall = gas_speed + (after[:, 0] - gas_speed) * drag
        # of a hop, the drag takes a third of what it takes of a velocity in the same time
        normal = -after[:, 1] * np.exp(-DRAG_RATE * flight / 3.0)
        velocity[hopping] = np.stack([along_wall, normal, after[:, 2] * drag], axis=1)
        omega[hopping] = spin * np.exp(-TORQUE_RATE * flight)[:, np.newaxis]
        hopping = hopping[after[:, 1] >= resting_speed]
        progress.update()
        if not hopping.size:
            break
    rests = np.ones(n, dtype=bool)
    rests[hopping] = False
    return rests


def main(words=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--grains", type=int, default=20_000, help="number of grains (20000)")
    parser.add_argument(
        "--tables",
        nargs="+",
        default=["corundum-steel", "corundum-steel-compact"],
        help="names, or paths of .h5 files (corundum-steel corundum-steel-compact)",
    )
    arguments = parser.parse_args(words)
    if arguments.grains < 1:
        parser.error("argument --grains: give 1 or more")
    try:
        print_rests(arguments.grains, arguments.tables)
    except sampler.InputError as error:  # for one, a table without a spin law
        parser.error(str(error))


def print_rests(count, names):
    """Print the shares of grains that come to rest, by direct simulation and by tables."""
    tables = {name: sampler.load(name) for name in names}
    model = tablegen.DirectModel(tablegen.load_config("corundum-steel"))
    laws = {"direct simulation": model} | tables
    grains = model.grains(SEED, np.arange(count))
    half_size = sampler.half_size(model, DIAMETER, grains)
    shapes = [grains[:, 0] == code for code in range(len(SHAPES))]
    print("grains that come to rest within 400 hits, %")
    print(f"{'':24}" + "".join(f"{shape:>18}" for shape in SHAPES))
    with tqdm(total=len(CASES) * len(laws) * HITS, unit="hit", leave=False) as progress:
        for gas_speed, acceleration in CASES:
            tqdm.write(f"gas of {gas_speed:g} m/s, acceleration of {acceleration:g} m/s2")
            for name, law in laws.items():
                rests = come_to_rest(law, grains, half_size, gas_speed, acceleration, progress)
                tqdm.write(f"  {name:22}" + "".join(_percent(rests[rows]) for rows in shapes))


def _percent(rests):
    """Write a share of grains in %, with its standard error."""
    if not rests.size:
        return f"{'none':>18}"
    share = rests.mean()
    error = np.sqrt(max(share * (1.0 - share), 1.0 / rests.size) / rests.size)
    return f"{100.0 * share:>11.2f} ± {100.0 * error:.2f}"


if __name__ == "__main__":
    main()
