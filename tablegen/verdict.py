"""How a command that measures an accuracy ends."""

import click

#: Exit statuses.
DONE, MISSED = 0, 1


def verdict(missed: list[str]) -> int:
    """Say what was missed.

    Parameters
    ----------
    missed : list of str
        One line for each declared accuracy that does not hold.

    Returns
    -------
    int
        Exit status.
    """
    for line in missed:
        click.echo(f"missed: {line}")
    if not missed:
        click.echo("The declared accuracy holds at every condition.")
    return MISSED if missed else DONE
