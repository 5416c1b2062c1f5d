import os
import subprocess
import sys
from pathlib import Path

import foam_run
import pytest
import shots

import sampler


@pytest.fixture(scope="session")
def work():
    """Working folder with OpenFOAM, the plugin and the table; the usual one, or OPENFOAM_FOLDER."""
    given = os.environ.get("OPENFOAM_FOLDER")
    installed = foam_run.script("install.sh", *([given] if given else []))
    if installed.returncode == 2:
        pytest.skip(installed.stderr.strip())
    assert installed.returncode == 0, installed.stderr
    folder = Path(installed.stdout.rpartition(": ")[2].strip())
    built = foam_run.script("build.sh", folder)
    assert built.returncode == 0, built.stderr
    table = folder / foam_run.TABLE
    export = [sys.executable, "-m", "tablegen", "export", "corundum-steel", "--output", table]
    subprocess.run(export, check=True, cwd=foam_run.PLUGIN.parents[1])
    return folder


@pytest.fixture(scope="session")
def table():
    return sampler.load("corundum-steel")


@pytest.fixture(scope="session")
def started():
    return shots.make_shots(500)
