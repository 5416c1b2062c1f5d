"""The page "From your measurements to a table": its commands run as they stand, on a small case."""

import tomllib

import numpy as np
import pytest
from command_lines import calls
from documents import ROOT, blocks
from synthetic_measurements import small_pair
from tiny_tables import ROUGH

from sampler.commands.main import main as sampler
from tablegen.commands.main import main as tablegen

BLOCKS = {
    block.language: block.text
    for block in reversed(blocks((ROOT / "docs" / "calibration.md").read_text(encoding="utf-8")))
}
PROGRAMS = {"sampler": sampler, "tablegen": tablegen}
DONE, MISSED = 0, 1


@pytest.mark.usefixtures("quick", "quick_measurement")
def test_the_screen_of_commands(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("tablegen.accuracy.metrics.TREES", 20)
    (tmp_path / "rebounds.csv").write_text(BLOCKS["csv"], encoding="utf-8")
    tree = tomllib.loads(ROUGH.text)
    start = small_pair(
        domain={**tree["domain"], "extrapolate": True},
        table=tree["table"],
        accuracy=tree["accuracy"],
        population={"aspect": {"mean": 0.8}},
    )
    (tmp_path / "start.toml").write_text(start.text, encoding="utf-8")
    for program, *words in calls(BLOCKS["sh"]):
        if words[0] in ("compare", "calibrate"):
            words += ["--count", "200"]
        if words[0] in ("generate", "validate"):  # so small a table may miss its accuracy
            words += ["--conditions", "1", "--samples", "1000"]
        assert PROGRAMS[program](words) in (DONE, MISSED), capsys.readouterr().err
    with np.load("draws.npz") as draws:
        assert draws["state"].shape == (10_000, 6)
    for name in ("before.png", "after.png", "fit.png", "fit.json", "my-sand.h5"):
        assert (tmp_path / name).stat().st_size > 0
    assert "Rows held out, predicted" in (tmp_path / "my-sand.toml").read_text(encoding="utf-8")
