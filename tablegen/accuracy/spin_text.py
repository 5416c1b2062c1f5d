"""What was measured of a spin law, as rows of tables and sentences."""

from tablegen.accuracy.accuracy_text import accuracy_text
from tablegen.accuracy.decision import limits
from tablegen.accuracy.joint_law import JointComparison
from tablegen.accuracy.spin_measure import SpinAccuracy
from tablegen.accuracy.spin_validation import SpinValidation
from tablegen.config.metric_table import JOINT_METRICS, METRICS, spin_errors_text
from tablegen.config.spin_targets import JointTargets, SpinTargets
from tablegen.presentation import table_lines

#: Heads of the columns of `joint_rows`.
JOINT_HEAD = ["over the impacts of chains", "impacts", *(METRICS[n].head for n in JOINT_METRICS)]


def joint_rows(
    joint: JointComparison,
    declared: JointTargets,
    asked: JointTargets | None = None,
    together: int = 1,
) -> list[list[str]]:
    """Cells of what was measured over the impacts of chains, its limits, and what is allowed.

    Parameters
    ----------
    joint : JointComparison
    declared, asked : JointTargets
        The second is left out if it is None or the same.
    together : int
        How many comparisons are judged together.
    """
    of = joint.estimates

    def row(title: str, count: str, values: dict[str, float]) -> list[str]:
        return [title, count, *(METRICS[n].text(values[n]) for n in JOINT_METRICS)]

    bounds = {name: limits(name, of[name], together) for name in JOINT_METRICS}
    rows = [
        row("measured", f"{joint.states:,}", {n: of[n].value for n in JOINT_METRICS}),
        row("noise", "", {n: of[n].noise for n in JOINT_METRICS}),
        row("error at least", "", {n: bounds[n][0] for n in JOINT_METRICS}),
        row("error at most", "", {n: bounds[n][1] for n in JOINT_METRICS}),
        row("declared", "", vars(declared)),
    ]
    if asked is not None and asked != declared:
        rows.append(row("asked for", "", vars(asked)))
    return rows


def spin_report(
    measured: SpinAccuracy, declared: SpinTargets, asked: SpinTargets | None, together: int
) -> list[str]:
    """Lines for a terminal: every comparison of a spin law, and what is allowed.

    Parameters
    ----------
    measured : SpinAccuracy
    declared, asked, together
        As for `joint_rows`.
    """
    lines = []
    if measured.comparisons:
        lines.append("the spin law, at spinning conditions")
        lines.append(accuracy_text(measured.comparisons, declared, asked, together))
    if measured.joint is not None:
        limits_of_joint = declared.joint, asked.joint if asked else None, together
        lines += table_lines(JOINT_HEAD, joint_rows(measured.joint, *limits_of_joint))
    return lines


def joint_line(joint: JointComparison) -> str:
    """Say which impacts those are, and what the classifier was told."""

    def range_of(values: tuple[float, ...], digits: int) -> str:
        low, middle, high = (f"{value:.{digits}f}" for value in values)
        return f"{middle} ({low} to {high})"

    auc = METRICS["auc"]
    return (
        "Impacts 2 to 6 of chains on the same wall and between opposite ones, grains kept: angle "
        f"{range_of(joint.alpha_deg, 1)} degrees, speed {range_of(joint.speed, 1)} m/s, spin "
        f"{range_of(joint.spin, 2)} V/a: median, and 1 to 99 %. The classifier is told condition, "
        f"grain and outcome; told no grain, its AUC is {auc.text(joint.auc_without_grain.value)}."
    )


def spin_lines(spin: SpinValidation, chosen: bool, together: int) -> list[str]:
    """Say what was looked at of a spin law, and what the file says of itself.

    Parameters
    ----------
    spin : SpinValidation
    chosen : bool
        Whether the user chose the conditions.
    together : int
        How many comparisons are judged together.
    """
    count = len(spin.measured.comparisons)
    whose = "that you chose" if chosen else "spread evenly"
    lines = [f"Looked at the spin law at {count} spinning condition{'s' * (count > 1)} {whose}."]
    if spin.measured.joint is not None:
        lines.append(joint_line(spin.measured.joint))
    elif not chosen:
        lines.append("Nothing was measured over chains of impacts, which leave the table's range.")
    if spin.stored is None:
        return [*lines, "The file stores no accuracy of its spin law."]
    lines.append(
        f"The file says of its spin law, at worst: {spin_errors_text(spin.stored)}. Measured here: "
        f"{spin_errors_text(spin.worst)}."
    )
    if surpassed := spin.surpassed(together):
        lines.append(
            "Note: the error of the spin law is larger than the file says, at least "
            f"{spin_errors_text(surpassed)}."
        )
    return lines
