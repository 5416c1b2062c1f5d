"""Running OpenFOAM's programs on a copy of a case."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

PLUGIN = Path(__file__).resolve().parents[2] / "sampler" / "openfoam"
TABLE = "corundum-steel.rbt"


class FoamError(RuntimeError):
    """A program of OpenFOAM failed; the message is the end of its output."""


def script(name, *arguments):
    command = ["bash", str(PLUGIN / name), *map(str, arguments)]
    environment = os.environ | {"PYTHON": sys.executable}  # its environment need not be active
    return subprocess.run(command, capture_output=True, text=True, check=False, env=environment)


def copy_case(name, folder, work):
    case = Path(folder)
    shutil.rmtree(case, ignore_errors=True)
    shutil.copytree(PLUGIN / "cases" / name, case)
    shutil.copyfile(Path(work) / TABLE, case / TABLE)
    return case


def edit(case, file, old, new):
    """Replace a text that a file of a case contains."""
    path = Path(case) / file
    text = path.read_text(encoding="ascii")
    if old not in text:
        raise ValueError(f"{file}: got no {old!r}")
    path.write_text(text.replace(old, new), encoding="ascii")


def _environment(work):
    """Variables that environment.sh sets, for a working folder."""
    command = 'FOLDER="$1"; source "$2"; env -0'
    out = subprocess.run(
        ["bash", "-c", command, "bash", str(work), str(PLUGIN / "environment.sh")],
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    return dict(item.split("=", 1) for item in out.split("\0") if "=" in item)


def run(work, case, *command, processors=1):
    """Run a program in a case, in parallel with mpirun; return its output, kept as log.PROGRAM."""
    log = Path(case) / f"log.{command[0]}"
    if processors > 1:
        command = ("mpirun", "-np", str(processors), *command, "-parallel")
    environment = {**os.environ, **_environment(work), "PWD": str(case)}
    done = subprocess.run(
        command,
        cwd=case,
        env=environment,
        text=True,
        check=False,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    log.write_text(done.stdout, encoding="utf-8")
    if done.returncode != 0:
        raise FoamError(f"{' '.join(command)} in {case}:\n{done.stdout[-3000:]}")
    return done.stdout
