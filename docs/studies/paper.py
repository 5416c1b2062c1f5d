"""Figures 3 to 10, 12 and 13 of Panfilov & Tsirkunov (2022), and our numbers beside the paper's.

    python docs/studies/paper.py --output figures

simulates each shape and the mixture at angles from 5 to 90 degrees. The speed is 200 m/s, or the
nearest speed at which the pair of the table was measured. The mixture is also drawn from the table.
The folder gets figure-03.svg to figure-13.svg. Simulated spins are those at the departure, as in
the paper; the table holds means over the tumbling after it, which are a little smaller.

The figures are drawn for any table but one of spheres; the numbers are put beside the paper's for
its pair only. Its table of collisions agrees better with twice the sliding resistance than with its
printed equations (5) to (7), so every number is given under both.
"""

import argparse
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from paper_figures import paper_pictures
from paper_statistics import (
    ANGLES,
    SCATTERING_BINS,
    SHAPES,
    TABLE,
    Curves,
    FigureStatistics,
    SampleStatistics,
    make_statistics,
    samples_of_figures,
)
from scipy.ndimage import gaussian_filter1d
from scipy.signal import find_peaks

import sampler
from tablegen.config.config import stored_config
from tablegen.config.defaults import MIXTURE
from tablegen.evidence.error_against_time import load_whole
from tablegen.model.float_array import FloatArray
from tablegen.presentation import TextTable
from tablegen.progress import bar

#: Shares of particles with 1, 2, 3, 4, 5 and more collisions at normal impact [%].
COLLISIONS = {
    "ellipsoid": (42.2, 31.2, 8.9, 4.3, 2.6, 10.8),
    "prism": (13.3, 40.1, 19.5, 14.6, 5.4, 7.1),
    "truncated-prism": (25.9, 37.7, 17.8, 9.7, 4.8, 4.1),
    "tetrahedron": (5.2, 12.8, 9.3, 7.9, 8.3, 56.5),
}

#: Names of both laws in tables.
PRINTED, TWICE = "as printed", "doubled"

#: Angles and quantities of the table of what a user notices.
_NOTICED = (
    (15.0, 30.0, 45.0, 60.0, 75.0, 90.0),
    ("u", "v", "omega_z", "translational", "rotational"),
)

#: Samples of one shape, or of the table, by rising angle.
_Curve = list[SampleStatistics]


class Statement(NamedTuple):
    """A statement of the paper that can be checked."""

    words: str
    #: What the paper says, and names of shapes of which it does.
    paper: str
    shapes: tuple[str, ...]
    #: From a curve to our numbers, and whether they agree; None where a table cannot tell.
    check: Callable[[str, _Curve], tuple[str, bool] | None]


def _rotational(_: str, curve: _Curve) -> tuple[str, bool] | None:
    if "rotational" not in curve[0].mean:
        return None
    top = max(curve, key=lambda sample: sample.mean["rotational"])
    return f"{top.mean['rotational']:.3f} at {top.alpha_deg:g}°", 15.0 <= top.alpha_deg <= 20.0


def _translational(_: str, curve: _Curve) -> tuple[str, bool]:
    means = [sample.mean["translational"] for sample in curve]
    step = np.diff(means).max(initial=-1.0)
    return f"{means[0]:.3f} to {means[-1]:.3f}, {step:+.4f}", bool(step < 1e-3)


def _largest_spin(_: str, curve: _Curve) -> tuple[str, bool]:
    largest = [max(getattr(s, which)["omega_z"] for s in curve) for which in ("mean", "mode")]
    return ", ".join(f"{value:+.4f}" for value in largest), max(largest) < 0.02


def _positive_spin(_: str, curve: _Curve) -> tuple[str, bool]:
    shares = [sample.positive_spin for sample in curve]
    step = np.diff(shares).min(initial=1.0)
    return f"{shares[0]:.3f} to {shares[-1]:.3f}, {step:+.4f}", bool(step > -2e-3)


def _offset(_: str, curve: _Curve) -> tuple[str, bool]:
    """Give the largest mean of what is symmetric about zero, in standard errors."""
    normal = "w", "omega_x", "omega_y", "u", "omega_z"
    offsets = (
        abs(sample.mean[name]) / max(sample.error[name], 1e-12)  # spheres do not scatter
        for sample in curve
        for name in (normal if sample.alpha_deg == 90.0 else normal[:3])
    )
    largest = max(offsets)
    return f"{largest:.1f}", largest < 4.5


def _mode_at_normal(shape: str, curve: _Curve) -> tuple[str, bool] | None:
    # of two equal maxima either may be the mode
    modes = [abs(s.mode["u"]) for s in curve if s.alpha_deg == 90.0]
    return (f"{modes[0]:.2f}", (modes[0] > 0.05) == (shape == "prism")) if modes else None


def indicatrix_maxima(scattering: FloatArray) -> list[float]:
    """Find the angles alpha2 [degrees] of maxima that stand out by a fortieth of the highest."""
    density = gaussian_filter1d(scattering, 5.0)
    # at grazing impact the highest bin may be the first
    peaks, _ = find_peaks(np.pad(density, 1), prominence=0.025 * density.max())
    return [float((k - 0.5) * 180.0 / SCATTERING_BINS) for k in peaks]


def _two_maxima(_: str, curve: _Curve) -> tuple[str, bool]:
    two = [s.alpha_deg for s in curve if len(indicatrix_maxima(s.scattering)) == 2]
    words = " ".join(f"{alpha_deg:g}" for alpha_deg in two) or "none"
    return words, two == [s.alpha_deg for s in curve if s.alpha_deg >= 70.0]


def _spread(_: str, curve: _Curve) -> tuple[str, bool]:
    """Give the largest standard deviation of alpha2, and where it is."""
    degrees = (np.arange(SCATTERING_BINS) + 0.5) * 180.0 / SCATTERING_BINS
    spreads = []
    for sample in curve:
        weights = sample.scattering / sample.scattering.sum()
        spreads.append(float(np.sqrt(weights @ degrees**2 - (weights @ degrees) ** 2)))
    top = int(np.argmax(spreads))
    return f"{spreads[top]:.1f}° at {curve[top].alpha_deg:g}°", curve[top] is curve[-1]


def _several(_: str, curve: _Curve) -> tuple[str, bool] | None:
    """Give the least share with more than one collision below normal impact."""
    known = [(s.alpha_deg, s.collisions) for s in curve if s.collisions is not None]
    shares = [(1.0 - float(shares[0]), angle) for angle, shares in known if angle < 90.0]
    if not shares:
        return None
    least, angle = min(shares)
    return f"{100.0 * least:.0f} at {angle:g}°", 0.245 < least < 0.705


STATEMENTS = (
    Statement("largest mean rotational energy", "at 15 to 20°", SHAPES, _rotational),
    Statement(
        "mean translational energy at the least and the largest angle, largest step",
        "falls monotonically",
        SHAPES,
        _translational,
    ),
    Statement("largest mean, largest most probable Ωz [V/a]", "not above 0", SHAPES, _largest_spin),
    Statement("share with Ωz > 0, least step", "grows with the angle", SHAPES, _positive_spin),
    Statement(
        "largest mean of w, Ωx, Ωy, at 90° also of u, Ωz [standard errors]",
        "symmetric about 0",
        SHAPES,
        _offset,
    ),
    Statement("most probable |u| at 90° [V]", "0, except of prisms", SHAPES[:4], _mode_at_normal),
    Statement(
        "α₁ where α₂ has two maxima, which stand out by 2.5 % of the highest [°]",
        "70 to 90",
        (MIXTURE,),
        _two_maxima,
    ),
    Statement("largest spread of α₂", "at 90°", (MIXTURE,), _spread),
    Statement("least share with several collisions [%]", "25 to 70", SHAPES[:4], _several),
)


def _percent(shares: Iterable[float]) -> list[str]:
    return [f"{share:.1f}" for share in shares]


def collision_table(laws: dict[str, Curves]) -> TextTable:
    """Put shares of particles by number of collisions at normal impact beside the paper's."""
    rows = []
    for shape, paper in COLLISIONS.items():
        rows.append([f"{shape}, paper", *_percent(paper), ""])
        for law, curves in laws.items():
            shares = curves[shape][ANGLES[-1]].collisions
            assert shares is not None  # of direct simulation they are known
            off = np.abs(100.0 * shares - paper).max()
            rows.append([f"{shape}, {law}", *_percent(100.0 * shares), f"{off:.1f}"])
    head = ("collisions at 90° [%]", "1", "2", "3", "4", "5", "more", "largest difference")
    return TextTable("Particles by number of collisions at normal impact", head, rows)


def statement_table(laws: dict[str, Curves]) -> TextTable:
    """Put our numbers beside each statement of the paper, under each law, and of the table."""
    rows = []
    for statement, (law, curves) in ((s, entry) for s in STATEMENTS for entry in laws.items()):
        cells = []
        for shape in (*SHAPES, TABLE):
            curve = list(curves.get(shape, {}).values())
            checked = statement.check(shape, curve) if curve else None
            if checked is None:
                cells.append("")
                continue
            words, agrees = checked
            stated = (MIXTURE if shape == TABLE else shape) in statement.shapes
            cells.append(f"{words} ✗" if stated and not agrees else words)
        rows.append([statement.words, statement.paper, law, *cells])
    head = ("number", "paper", "resistance", *SHAPES, TABLE)
    return TextTable("Statements of the paper; ✗: our number disagrees", head, rows)


def noticed_table(laws: dict[str, Curves]) -> TextTable:
    """Put means of the mixture under each law beside each other."""
    angles, quantities = _NOTICED
    rows = []
    for alpha_deg in (alpha_deg for alpha_deg in ANGLES if alpha_deg in angles):
        for law, curves in laws.items():
            mean = curves[MIXTURE][alpha_deg].mean
            rows.append([f"{alpha_deg:g}°, {law}", *(f"{mean[name]:.3f}" for name in quantities)])
    words = ("u/V", "v/V", "Ωz a/V", "translational energy", "rotational energy")
    return TextTable(
        "Means of the mixture over V, V/a and the energy before", ("angle", *words), rows
    )


def paper_text(statistics: FigureStatistics) -> str:
    """Write the tables of the paper's pair, each with a sentence on what to see."""
    laws = {PRINTED: statistics.curves}
    if statistics.doubled:
        laws[TWICE] = statistics.doubled
    return "\n\n".join(
        (
            "The paper's equations (5) to (7) are simulated twice: as they are printed, which is "
            "the default, and with twice the tangential impulse of (5), factor = 2 in "
            "[pair.resistance].",
            str(collision_table(laws)),
            "The paper makes other statements that can be checked. A cross marks a number that "
            "disagrees with the paper. The two laws miss different statements.",
            str(statement_table(laws)),
            str(noticed_table(laws)),
        )
    )


def whole_number(text: str) -> int:
    """Parse a number of particles, 1,000 or more."""
    if not text.isdecimal() or int(text) < 1000:
        raise argparse.ArgumentTypeError(f"got {text}, allowed: whole numbers from 1000")
    return int(text)


def main(arguments: Sequence[str] | None = None) -> None:
    """Simulate and draw, write the figures, and print the tables if the pair is the paper's."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("table", nargs="?", default="corundum-steel", help="name or T.h5")
    parser.add_argument("--output", type=Path, help="folder for the figures")
    parser.add_argument("--count", type=whole_number, default=200_000, help="of each shape, angle")
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args(arguments)
    try:
        table = load_whole(args.table)
        config = stored_config(table.config, args.table)
    except (sampler.InputError, OSError) as error:
        parser.error(str(error))
    if config.population.only_spheres:
        parser.error(f"{args.table}: spheres all leave alike: there is no distribution to draw")
    total = samples_of_figures(config)
    with bar(True, total=total, desc="samples of the figures") as counted:
        statistics = make_statistics(table, config, args.count, args.seed, counted.update)
    if args.output:
        args.output.mkdir(exist_ok=True)
        for name, data in paper_pictures(statistics).items():
            (args.output / name).write_bytes(data)
    if statistics.of_paper:
        print(paper_text(statistics))


if __name__ == "__main__":
    main()
