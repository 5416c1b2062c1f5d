import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import saturne_run

import sampler


@pytest.fixture(scope="session")
def work(tmp_path_factory):
    """Working folder with solver, mesh and table; skips where code_saturne is missing."""
    solver = shutil.which("code_saturne")
    if solver is None:
        pytest.skip("code_saturne is not installed; run: sampler/code_saturne/install.sh")
    folder = tmp_path_factory.mktemp("code_saturne")
    export = [sys.executable, "-m", "sampler", "export", "corundum-steel"]
    root = Path(__file__).resolve().parents[2]
    subprocess.run([*export, "--output", folder / saturne_run.TABLE], check=True, cwd=root)
    saturne_run.build(folder)
    return folder


@pytest.fixture(scope="session")
def table():
    return sampler.load("corundum-steel")
