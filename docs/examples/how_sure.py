"""How sure are we? The flow of `wall_laws.py` with the restitution varied within what is known.

    python docs/examples/how_sure.py

Restitution of corundum on steel was measured at contacts of 50 to 300 m/s. Below, it is varied: as
extrapolated, constant, by the yield laws of Johnson (Contact Mechanics, 1985, 11.4) and Thornton
(J. Appl. Mech. 64 (1997) 383), matched at 50 m/s at every angle; then by a share, at all speeds.
Direct simulation stands for tables, which cannot be told from it.
"""

import argparse

import numpy as np
from cylinders import follow_each
from wall_laws import direct_law, print_results

import tablegen

MEASURED, SHARE = 50.0, 0.2  # m/s; no source gives the scatter of this pair: declared
ANGLE, SPEED = np.linspace(0.0, 90.0, 46), np.geomspace(0.5, 1000.0, 80)  # knots: degrees, m/s


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
        f"{1.0 - SHARE:g} of it": (1.0 - SHARE) * measured(SPEED),
        f"{1.0 + SHARE:g} of it": (1.0 + SHARE) * measured(SPEED),
    }


def main(arguments=None):
    """Follow the grains under each law of restitution; print where they go."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--grains", type=int, default=50_000, help="under each law")
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args(arguments)
    config = tablegen.load_config("corundum-steel")
    model, sizes = tablegen.DirectModel(config), (30e-6, 100e-6)
    laws = {"as extrapolated": direct_law(model)}
    for name, values in restitutions(config.pair.restitution).items():
        table = {"law": "tabulated", "angle_deg": ANGLE.tolist(), "speed": SPEED.tolist()}
        table |= {"value": np.minimum(values, 1.0).tolist(), "source": name}
        varied = config.with_changes({"pair": {"restitution": table}})
        laws[name] = direct_law(tablegen.DirectModel(varied))
    results = follow_each(laws, model.grains, args.grains, sizes, args.seed)
    print_results(results, *sizes)
    slow = (results["as extrapolated"].speed < MEASURED).mean()
    print(f"\nas extrapolated, {slow:.1%} of the hits are slower than {MEASURED:g} m/s")


if __name__ == "__main__":
    main()
