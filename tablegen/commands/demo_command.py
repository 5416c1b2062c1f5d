"""Work of ``tablegen demo``."""

from pathlib import Path

import click

from tablegen.accuracy.verdict import DONE, MISSED
from tablegen.studies.demo_run import run_demo


def run(output: Path, progress: bool) -> int:
    """Run ``tablegen demo``; parameters are the options of `tablegen.commands.demo`."""
    return MISSED if run_demo(output, click.echo, progress).missed else DONE
