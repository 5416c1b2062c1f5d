"""How sure are we? Two flows with the contact laws varied within what is known.

    python docs/studies/how_sure.py
    python docs/studies/how_sure.py --flow cyclone --grains 10000
    python docs/studies/how_sure.py --pairs corundum-steel forder-1998

The first follows grains past the cylinders of `wall_laws.py`, the second in `cyclone.py`, and the
third compares pairs, each with its own grains.

Restitution of corundum on steel was measured at contacts of 50 to 300 m/s. The script varies it:
below 50 m/s as extrapolated, constant, and by the yield laws of Johnson (Contact Mechanics, 1985,
11.4) and Thornton (J. Appl. Mech. 64 (1997) 383), which match the measured law at 50 m/s at every
angle; then by a share, at all speeds. The last law has twice the sliding resistance, with which the
paper's table of collisions agrees better (docs/paper.md). All results are direct simulation,
because a table of each law would take longer to make.
"""

import argparse
import sys
from pathlib import Path

import cylinders
import numpy as np
from tqdm import tqdm
from wall_laws import direct_law, print_results

import sampler
import tablegen

sys.path.append(str(Path(__file__).resolve().parents[1] / "examples"))
import cyclone

MEASURED, SHARE = 50.0, 0.2  # m/s; no source gives the scatter of this pair: declared
ANGLE, SPEED = np.linspace(0.0, 90.0, 46), np.geomspace(0.5, 1000.0, 80)  # knots: degrees, m/s
SIZES = 30e-6, 100e-6  # diameters past the cylinders, m
#: Groups of grains in the cyclone of which columns are printed.
GROUPS = "all shapes, 5 to 100 µm", "ellipsoid, 37 to 100 µm"


def thornton(ratio):
    """Restitution of an elastic, perfectly plastic contact at a ratio of yield to impact speed."""
    plastic = ratio / (ratio + 2.0 * np.sqrt(1.2 - 0.2 * ratio**2))
    return np.sqrt(1.2 * 3.0**0.5 * (1.0 - ratio**2 / 6.0)) * plastic**0.25


def restitutions(law):
    """Tabulate an exponential law and its variants at the knots, by name."""

    def measured(speed):
        fall = np.exp(-law.coefficient * speed**law.exponent)
        return 1.0 - (1.0 - fall) * np.sin(np.radians(ANGLE))[:, None]

    slower, known = MEASURED / np.minimum(SPEED, MEASURED), measured(np.maximum(SPEED, MEASURED))
    ratios = np.linspace(0.0, 1.0, 10_001) ** 4  # of yield to impact speed
    matched = np.interp(measured(np.array([MEASURED])), thornton(ratios), ratios)
    yielding = thornton(np.minimum(matched * slower, 1.0))
    return {
        "tabulated": measured(SPEED),
        "constant below 50 m/s": known,
        "Johnson below 50 m/s": known * slower**0.25,
        "Thornton below 50 m/s": np.where(SPEED < MEASURED, yielding, known),
        f"{1.0 - SHARE:g} of the restitution": (1.0 - SHARE) * measured(SPEED),
        f"{1.0 + SHARE:g} of the restitution": (1.0 + SHARE) * measured(SPEED),
    }


def varied_configurations(config):
    """Return configurations with the laws that are compared, by name; the first is the given."""
    configurations = {"as extrapolated": config}
    for name, values in restitutions(config.pair.restitution).items():
        law = {"law": "tabulated", "angle_deg": ANGLE.tolist(), "speed": SPEED.tolist()}
        law |= {"value": np.minimum(values, 1.0).tolist(), "source": name}
        configurations[name] = config.with_changes({"pair": {"restitution": law}})
    factor = 2.0 * config.pair.resistance.factor
    doubled = config.with_changes({"pair": {"resistance": {"factor": factor}}})
    return configurations | {"twice the resistance": doubled}


def follow_cylinders(model, count, seed, progress):
    """Follow grains past the cylinders."""
    return cylinders.follow(direct_law(model), model, count, SIZES, seed, progress)


def follow_cyclone(model, count, seed, progress):
    """Follow grains in the cyclone."""
    return cyclone.follow(model.rebound, model, count, seed, progress)


def print_cylinders(results):
    """Print the columns of the cylinders, and how many hits are slower than the measured ones."""
    print_results(results, *SIZES)
    name, first = next(iter(results.items()))
    slow = (first.speed < MEASURED).mean()
    print(f"\n{name}: {slow:.1%} of the hits are slower than {MEASURED:g} m/s")


def print_cyclone(results):
    """Print how grains end in the cyclone, and columns of all and of those that roll best."""
    cyclone.print_fates(results)
    tables = cyclone.tables_of(results)
    cyclone.print_tables({group: tables[group] for group in GROUPS if group in tables})


FLOWS = {
    "cylinders": (follow_cylinders, print_cylinders),
    "cyclone": (follow_cyclone, print_cyclone),
}


def main(arguments=None):
    """Follow the grains under each law; print where they go."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument(
        "--flow", choices=tuple(FLOWS), default="cylinders", help="flow that the grains follow"
    )
    parser.add_argument(
        "--pairs", nargs="+", default=[], metavar="PAIR", help="compare pairs, not laws"
    )
    parser.add_argument("--grains", type=int, default=50_000, help="grains under each law")
    parser.add_argument("--seed", type=int, default=1, help="seed of the random numbers")
    args = parser.parse_args(arguments)
    if args.grains < 1 or args.seed < 0:
        parser.error("give --grains 1 or more, and --seed 0 or more")
    try:
        configurations = {pair: tablegen.load_config(pair) for pair in args.pairs}
    except sampler.InputError as error:
        parser.error(str(error))
    if not args.pairs:
        configurations = varied_configurations(tablegen.load_config("corundum-steel"))
    follow, print_flow = FLOWS[args.flow]
    results = {}
    with tqdm(total=args.grains * len(configurations), unit="grain") as progress:
        for number, (name, config) in enumerate(configurations.items()):
            # independent grains under each law, so that standard errors of differences are right
            keys = 100 * args.seed + number
            model = tablegen.DirectModel(config)
            results[name] = follow(model, args.grains, keys, progress)
    print_flow(results)


if __name__ == "__main__":
    main()
