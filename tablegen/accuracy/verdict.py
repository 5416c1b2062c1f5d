"""How a command that measures an accuracy ends."""

from collections.abc import Sequence

import click

#: Exit statuses.
DONE, MISSED = 0, 1


def verdict_words(missed: Sequence[str], undecided: Sequence[str], accuracy: str) -> str:
    """Say in one sentence whether an accuracy holds; every text and page says it with these words.

    Parameters
    ----------
    missed, undecided : sequence of str
        As in `tablegen.accuracy.decision.Verdict`.
    accuracy : str
        Whose it is: "declared accuracy", or "accuracy asked for".
    """
    if missed:
        return f"The {accuracy} is missed:"
    if undecided:
        return f"The {accuracy} is not missed, but the noise leaves open whether it holds:"
    return f"The {accuracy} holds at every condition."


def verdict(
    missed: Sequence[str], undecided: Sequence[str] = (), accuracy: str = "declared accuracy"
) -> int:
    """Say what was missed and what could not be decided.

    Parameters
    ----------
    missed, undecided, accuracy
        As for `verdict_words`.

    Returns
    -------
    int
        Exit status: `MISSED` if something was missed.
    """
    for line in missed:
        click.echo(f"missed: {line}")
    for line in undecided:
        click.echo(f"undecided: {line}")
    if not missed:
        click.echo(verdict_words(missed, undecided, accuracy).rstrip(":") + "." * bool(undecided))
    return MISSED if missed else DONE
