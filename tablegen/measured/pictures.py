"""Pictures of measured and simulated rebounds against the impact angle."""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from tablegen.config.config import Config
from tablegen.config.law_text import law_at
from tablegen.measured.compare import MeasuredComparison
from tablegen.measured.measurements import ANY_SPEED, QUANTITIES, SPREAD, distinct_speeds
from tablegen.measured.result import Calibration, ComparedNumber
from tablegen.model.float_array import FloatArray
from tablegen.presentation import (
    ANGLE_LABEL,
    COLOURS,
    figure_style,
    legend_below,
    make_picture,
    new_figure,
)

#: Colours of speeds. There are no more speeds than colours, because near ones are drawn as one.
_COLOURS = tuple(COLOURS[name] for name in ("ellipsoid", "prism", "truncated-prism", "tetrahedron"))

#: Colour of a law that holds at every speed.
_ANY_SPEED = COLOURS["mixture"]

#: Laws of a pair, with the labels of their ordinates.
_LAWS = {"restitution": "law of restitution, $a_{nc}$", "resistance": "law of resistance, $C_f$"}

#: Angles at which a law without knots is drawn [degrees].
_FINE = tuple(np.linspace(1.0, 90.0, 90).tolist())

#: Width and height of a panel, and height of title and legend [inches].
_WIDTH, _HEIGHT, _MARGIN = 3.6, 2.8, 1.4


class _Look(NamedTuple):
    """Look of the rows of one speed, in all panels."""

    #: m/s; None if no row states one.
    speed: float | None
    colour: str
    #: What a legend says of the speed; empty if there is one only.
    words: str


class _LawCurve(NamedTuple):
    """A curve of a contact law."""

    angle_deg: Sequence[float]
    value: FloatArray
    #: m/s; None if the law does not depend on it.
    speed: float | None
    #: What a legend says of the curve; empty if the label of the ordinate says all.
    words: str = ""
    style: str = "-"


def comparison_picture(comparison: MeasuredComparison, name: str) -> bytes:
    """Draw measured means and spreads beside simulated ones, a panel for each.

    The ending of the name of the file selects the format.
    """
    title = f"{comparison.pair}, simulated, beside {comparison.measured.name}, measured"
    return _picture(list(comparison.numbers()), None, title, name)


def fit_picture(calibration: Calibration, name: str) -> bytes:
    """Draw means and spreads beside those of the chosen fit, and the fitted laws.

    The ending of the name of the file selects the format.
    """
    fit = calibration.chosen
    title = f"{fit.config.name}: fitted to measured rebounds, {fit.grains} grains"
    return _picture(fit.numbers, fit.config, title, name)


def _picture(
    numbers: Sequence[ComparedNumber], config: Config | None, title: str, name: str
) -> bytes:
    """Draw a panel for each column of numbers, and one for each law of a configuration, if any.

    A spread stands below its mean, and the resistance below the restitution.
    """
    columns = _columns(numbers, laws=config is not None)
    height = max(len(column) for column in columns)
    looks = _looks(numbers)
    with figure_style():
        figure = new_figure(0.4 + _WIDTH * len(columns), _MARGIN + _HEIGHT * height)
        panels = figure.subplots(height, len(columns), squeeze=False)
        for column, stack in zip(columns, panels.T, strict=True):
            spread_alone = len(column) == 1 and column[0].endswith(SPREAD)
            stack = stack[::-1] if spread_alone else stack
            for content, axes in zip(column, stack, strict=False):
                axes.set(xlim=(0, 92), xticks=range(0, 91, 15), ylabel=_label(content, config))
                if content in _LAWS:
                    assert config is not None  # only then there are laws
                    _draw_law(axes, config, content, looks)
                else:
                    part = [number for number in numbers if number.column == content]
                    _draw_numbers(axes, part, looks)
            for axes in stack[len(column) :]:
                axes.remove()
        legend_below(figure, columns=2)
        figure.suptitle(title + _words_of_bars(numbers), fontsize=11)
        return make_picture(figure, name)


def _columns(numbers: Sequence[ComparedNumber], laws: bool) -> list[list[str]]:
    """Arrange the names of panels in columns of one or two.

    By symmetry the mean angle out of the plane is 0, so if only its spread was measured, there is
    no panel of the mean.
    """
    measured = {number.column for number in numbers if number.measured or number.tolerance}
    pairs = [
        [column for column in (quantity, quantity + SPREAD) if column in measured]
        for quantity in QUANTITIES
    ]
    single = [pair[0] for pair in pairs if len(pair) == 1]
    columns = [pair for pair in pairs if len(pair) == 2]
    step = 2 if columns or laws else 1
    columns += [single[k : k + step] for k in range(0, len(single), step)]
    return columns + [list(_LAWS)] * laws


def _label(content: str, config: Config | None) -> str:
    """Give the label of the ordinate of a panel."""
    if content == "resistance" and config and config.pair.resistance.law == "coulomb":
        return "law of friction"
    if content in _LAWS:
        return _LAWS[content]
    label = QUANTITIES[content.removesuffix(SPREAD)].label
    return f"standard deviation of\n{label}" if content.endswith(SPREAD) else f"mean {label}"


def _looks(numbers: Sequence[ComparedNumber]) -> list[_Look]:
    """Give each speed a colour; speeds that nearly agree are one."""
    stated = np.array(sorted(one.speed for one in numbers if one.speed is not None))
    speeds = distinct_speeds(stated, len(_COLOURS))
    if len(speeds) < 2:
        return [_Look(speeds[0] if speeds else None, _COLOURS[0], "")]
    return [
        _Look(speed, colour, f", {'' if speed in stated else 'about '}{speed:.3g} m/s")
        for speed, colour in zip(speeds, _COLOURS, strict=False)
    ]


def _nearest(looks: Sequence[_Look], speed: float | None) -> _Look:
    """Find the look of a speed."""
    return min(looks, key=lambda look: abs((look.speed or 0.0) - (speed or 0.0)))


def _words_of_bars(numbers: Sequence[ComparedNumber]) -> str:
    """Say what the bars of all panels are; empty if there are none."""
    if any(number.error for number in numbers):
        return "\nbars: standard error"
    return "\nbars: tolerance of the fit" if any(one.tolerance for one in numbers) else ""


def _draw_numbers(axes: Any, numbers: Sequence[ComparedNumber], looks: Sequence[_Look]) -> None:
    """Draw measured points with bars, and a simulated line for each speed."""
    with_errors = any(number.error for number in numbers)
    for look in looks:
        part = [number for number in numbers if _nearest(looks, number.speed) is look]
        part.sort(key=lambda number: number.alpha_deg)
        if not part:
            continue
        angle = [number.alpha_deg for number in part]
        simulated = [number.simulated for number in part]
        lengths = [(one.error if with_errors else one.tolerance) or 0.0 for one in part]
        axes.plot(angle, simulated, color=look.colour, label=f"simulated{look.words}")
        axes.errorbar(
            angle,
            [number.measured for number in part],
            lengths if any(lengths) else None,
            fmt="o",
            markersize=4.5,
            color=look.colour,
            markerfacecolor="white",
            capsize=2.5,
            label=f"measured{look.words}",
        )
    axes.set_xlabel(ANGLE_LABEL)


def _draw_law(axes: Any, config: Config, name: str, looks: Sequence[_Look]) -> None:
    """Draw a law over the angle at the contact, with a curve for each speed if it has several."""
    curves = list(_law_curves(config, name, looks))
    for curve in curves:
        any_speed = curve.speed is None and len(looks) > 1
        axes.plot(
            curve.angle_deg,
            curve.value,
            curve.style,
            color=_ANY_SPEED if any_speed else _nearest(looks, curve.speed).colour,
            marker="s" if 2 < len(curve.angle_deg) < len(_FINE) else "",
            markersize=3.5,
            label=curve.words or None,
        )
    values = np.concatenate([curve.value for curve in curves])
    axes.set_ylim(1.08 * min(values.min(), 0.0), 1.08 * max(values.max(), 0.1))
    axes.set_xlabel("angle at the contact [°]")
    if len(looks) > 1 and all(curve.speed is None for curve in curves):
        axes.set_ylabel(f"{axes.get_ylabel()}, at any speed")


def _law_curves(config: Config, name: str, looks: Sequence[_Look]) -> Iterator[_LawCurve]:
    """List the curves of a law: its knots, or values at many angles of a law without knots."""
    law: Any = getattr(config.pair, name)
    if law.law == "tabulated":
        values = np.array(law.value).reshape(len(law.angle_deg), -1)
        speeds = law.speed if values.shape[1] > 1 else [None]
        for value, speed in zip(values.T, speeds, strict=True):
            yield _LawCurve(law.angle_deg, value, speed)
    elif law.law == "coulomb":
        kinds = {"dynamic": "--"} | ({} if config.population.only_spheres else {"static": ":"})
        for kind, style in kinds.items():
            value = np.full(2, getattr(law, kind))
            yield _LawCurve((0.0, 90.0), value, None, f"{kind} coefficient of friction", style)
        if law.tangential_restitution:
            angles = law.angle_deg or (0.0, 90.0)
            value = np.broadcast_to(law.tangential_restitution, len(angles))
            yield _LawCurve(angles, value, None, "tangential restitution of a sphere")
    else:
        depends = name == "restitution" and law.depends_on_speed
        for look in looks if depends else looks[:1]:
            speed = look.speed or ANY_SPEED
            value = np.array([law_at(config, name, angle, speed) for angle in _FINE])
            yield _LawCurve(_FINE, value, look.speed if depends else None)
