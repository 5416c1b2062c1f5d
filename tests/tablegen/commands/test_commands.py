"""The command line: what it writes and how it ends; what it refuses is in test_command_refusals."""

import html
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from command_line import DONE, MISSED, SIMULATE, config_file, flags
from corrupt_tables import declaring, lopsided
from tiny_tables import GENERATE

import sampler
from sampler.formats.channels import STATE
from sampler.formats.hdf5 import write_table
from tablegen.config.config import load_config
from tablegen.simulation.simulate import make_condition, simulate_condition
from tablegen.tables.refine import refine_grid

pytestmark = pytest.mark.usefixtures("quick_classifier")


class TestSimulate:
    @pytest.fixture
    def simulated(self, run, tmp_path):
        def runner(**changes):
            output = tmp_path / "rebounds.npz"
            words = flags(SIMULATE, {f"--{name}": value for name, value in changes.items()})
            ended = run("simulate", *words, "--output", output, "--overwrite", "--quiet")
            assert (ended.status, ended.out) == (DONE, "")
            with np.load(output) as file:
                return SimpleNamespace(err=ended.err, files=file.files, **dict(file.items()))

        return runner

    def test_fields(self, simulated):
        result = simulated()
        fields = ["state", "collisions", "shape", "mesh", "aspect", "energy", "work", "columns"]
        assert result.files == fields
        assert tuple(result.columns) == STATE
        for name, shape, kind in (
            ("state", (300, 6), "f8"),
            ("collisions", (300,), "i8"),
            ("shape", (300,), "i8"),
            ("aspect", (300, 2), "f8"),
            ("energy", (300, 2), "f8"),
            ("work", (300, 2), "f8"),
        ):
            values = getattr(result, name)
            assert (values.shape, values.dtype) == (shape, np.dtype(kind))
        assert set(result.mesh) == {-1}
        speed2 = (result.state[:, :3] ** 2).sum(axis=1)
        np.testing.assert_allclose(result.energy[:, 0], speed2, rtol=1e-12)
        np.testing.assert_allclose(
            result.energy.sum(axis=1) + result.work.sum(axis=1), 1.0, rtol=0.0, atol=1e-11
        )

    @pytest.mark.parametrize("spin", [(0.0, 0.0, 0.0), (0.5, -0.25, 1.0)])
    def test_is_the_simulation(self, simulated, spin):
        config = load_config("corundum-steel")
        condition = make_condition(np.radians(45.0), 200.0, spin)
        expected = simulate_condition(config.pair, config.population, condition, 300, seed=1)
        result = simulated(spin=spin)
        for name in ("state", "collisions", "shape", "aspect", "energy", "work"):
            np.testing.assert_array_equal(getattr(result, name), getattr(expected, name))

    def test_angular_velocities_are_those_of_the_pair_or_as_asked(self, simulated, tmp_path):
        departing = config_file(tmp_path, domain={"omega": "departure"})
        mean, departure = simulated().state, simulated(omega="departure").state
        assert (np.abs(mean - departure).max(axis=0) > [-1, -1, -1, 0.1, 0.1, 0.1]).all()
        np.testing.assert_array_equal(mean[:, :3], departure[:, :3])
        np.testing.assert_array_equal(simulated(pair=departing).state, departure)
        np.testing.assert_array_equal(simulated(pair=departing, omega="mean").state, mean)

    def test_speed_outside_the_law_is_simulated_with_a_note(self, simulated):
        assert simulated(speed=300).err == ""
        assert "301 m/s" in simulated(speed=301).err


@pytest.mark.usefixtures("quick_measurement")
class TestGenerate:
    def test_makes_a_table(self, run, tmp_path):
        output = tmp_path / "t.h5"
        ended = run(
            "generate", config_file(tmp_path), "--output", output, "--conditions", 1, "--quiet"
        )
        assert ended.status == DONE
        assert ended.out.startswith(f"{output}: ")
        assert sampler.load(output).accuracy["auc"].shape == (1,)
        assert sorted(path.name for path in tmp_path.iterdir()) == ["my.toml", "t.h5"]

    def test_missed_accuracy_is_status_1_and_leaves_the_table(self, run, tmp_path):
        output = tmp_path / "t.h5"
        config = config_file(tmp_path, accuracy={"auc": 0.5})
        ended = run("generate", config, "--output", output, "--conditions", 1, "--quiet")
        assert ended.status == MISSED
        assert "\nto hold: declare auc = 0." in ended.out
        assert sampler.load(output).accuracy["auc"].max() > 0.5

    def test_what_the_refinement_could_not_reach_is_a_note(self, run, tmp_path, monkeypatch):
        def short(plan, cache):
            return refine_grid(plan, cache)._replace(missed=["ks 0.2 at 40 degrees"])

        monkeypatch.setattr(GENERATE, "refine_grid", short)
        words = ("--output", tmp_path / "t.h5", "--conditions", 1, "--quiet")
        ended = run("generate", config_file(tmp_path), *words)
        assert ended.status == DONE
        assert ended.err.endswith("tablegen: note: ks 0.2 at 40 degrees\n")


class TestValidate:
    WORDS = ("--conditions", 1, "--samples", 4000, "--seed", 1, "--quiet")

    @pytest.fixture
    def wrong(self, tiny, tmp_path):
        """Everything leans to one side: a Kolmogorov-Smirnov distance of 0.2."""
        path = tmp_path / "wrong.h5"
        contents = lopsided(tiny.generated.table.contents, 0.15)
        write_table(path, declaring(contents, ks=1.0, sliced_wasserstein=9.0, auc=1.0))
        return path

    def test_good_table_is_status_0(self, run, tiny, tmp_path):
        page, record = tmp_path / "v.html", tmp_path / "v.json"
        ended = run("validate", tiny.path, *self.WORDS, "--json", record, "--html", page)
        assert (ended.status, ended.err) == (DONE, "")
        data = json.loads(record.read_text())
        assert data["holds"] is True
        (condition,) = data["conditions"]
        assert f"{condition['auc']:.3f}" in ended.out
        assert f"{condition['estimates']['ks']['error']:.4f}" in ended.out
        assert f"{condition['sliced_wasserstein']:.4f}" in page.read_text()
        assert html.escape(str(tiny.path)) in page.read_text()

    def test_declared_accuracy_counts_unless_another_is_asked_for(self, run, wrong, tmp_path):
        assert run("validate", wrong, *self.WORDS).status == DONE
        page, record = tmp_path / "v.html", tmp_path / "v.json"
        files = ("--json", record, "--html", page)
        ended = run("validate", wrong, *self.WORDS, "--accuracy", "ks=0.05", *files)
        assert (ended.status, ended.err) == (MISSED, "")
        assert json.loads(record.read_text())["holds"] is False
        assert "is missed" in page.read_text()
        assert ended.out.splitlines()[1].startswith("to hold: declare ks = ")
        assert re.search(r"^ks .* 0\.05 +MISSED ", ended.out, re.MULTILINE)

    def test_conditions_of_ones_choice(self, run, tiny):
        chosen = ("--alpha", 40, "--speed", 100, "--alpha", 45, "--speed", 300)
        ended = run("validate", tiny.path, *chosen, *self.WORDS[2:], "--details")
        assert ended.status == DONE
        for place in ("40.00°, 100.0 m/s", "45.00°, 300.0 m/s"):
            assert place in ended.out
        one_angle = ("--alpha", 40, "--speed", 100, "--speed", 200, *self.WORDS[2:], "--details")
        shared = run("validate", tiny.path, *one_angle)
        for place in ("40.00°, 100.0 m/s", "40.00°, 200.0 m/s"):
            assert place in shared.out

    def test_seed_is_printed_and_another_each_time(self, run, tiny):
        words = ("validate", tiny.path, "--alpha", 40, "--speed", 100, "--samples", 1000, "--quiet")
        first, other = (re.search(r"^Seed (\d+):", run(*words).out, re.M)[1] for _ in range(2))
        assert first != other
        assert run(*words, "--seed", first).out == run(*words, "--seed", first).out

    def test_accuracy_may_be_stored(self, run, tiny, tmp_path):
        path = shutil.copy(tiny.path, tmp_path / "t.h5")
        ended = run("validate", path, "--store", *self.WORDS)
        assert ended.status == DONE
        table = sampler.load(path)
        assert f"accuracy stored, content SHA-256 {table.contents.content_sha256}" in ended.out
        assert table.accuracy["auc"].shape == (1,)


def test_script(tiny, tmp_path):
    """In a process of its own, away from the source tree."""
    script = shutil.which("tablegen", path=str(Path(sys.executable).parent))
    assert script, "the package is not installed in this environment"
    words = [script, "inspect", str(tiny.path)]
    assert "corundum-steel" in subprocess.check_output(words, cwd=tmp_path, text=True)
