"""Whole tables: the file, its bytes whatever the way to them, and runs that were interrupted."""

import threading
import time
import tomllib
from concurrent.futures import ThreadPoolExecutor

import h5py
import numpy as np
import pytest
from tiny_tables import GENERATE, MEASURED, REFINE, ROUGH, TINY

import sampler
from sampler.errors import InputError
from sampler.formats.hdf5 import read_table
from tablegen.accuracy.validate import validate
from tablegen.checkpoints import TaskRunner
from tablegen.config.config import parse_config
from tablegen.fitting.node import fit_node
from tablegen.fitting.quantile_rounding import rounded_quantiles
from tablegen.tables.axes import first_grid
from tablegen.tables.generate import generate
from tablegen.tables.refine import fit_nodes

pytestmark = pytest.mark.usefixtures("quick_measurement")


def made(path, executor=None, **options):
    """Bytes of the rough table."""
    generate(ROUGH, path, executor=executor, conditions=1, samples=MEASURED, **options)
    return path.read_bytes()


@pytest.fixture(scope="module")
def rough_bytes(tmp_path_factory):
    """The rough table, made by one worker in one go."""
    path = tmp_path_factory.mktemp("rough") / "rough.h5"
    with ThreadPoolExecutor(1) as pool:
        return made(path, pool)


#: Condition of the last node.
LAST = (45.0, 300.0)


class InterruptedRunError(Exception):
    """What stops a run in a test."""


@pytest.fixture
def failing_last_node(monkeypatch, tmp_path):
    """The last of the four nodes fails, once the other three are on disk."""

    def failing(config, alpha_deg, speed, *rest):
        if (alpha_deg, speed) != LAST:
            return fit_node(config, alpha_deg, speed, *rest)
        deadline = time.monotonic() + 60.0
        while len(list(tmp_path.glob("t.h5.parts/piece-*.npz"))) < 3:
            assert time.monotonic() < deadline, "three nodes were never saved"
            time.sleep(0.01)
        raise InterruptedRunError

    monkeypatch.setattr(REFINE, "fit_node", failing)


class TestFile:
    def test_attributes(self, tiny):
        with h5py.File(tiny.path) as file:
            attributes = dict(file.attrs)
        assert attributes["format"] == "rebound-table"
        # 1.1: the file names the speeds at which the law of restitution was measured
        assert attributes["format_version"].tolist() == [1, 1]
        assert attributes["pair"] == "corundum-steel"
        assert attributes["config"] == TINY.text
        assert attributes["seed"] == TINY.table.seed
        assert attributes["software_version"] == sampler.__version__
        assert attributes["components"] == "u v w omega_x omega_y omega_z"
        assert attributes["channels"] == "v u_hat omega_z w_hat omega_x omega_y"
        checksum = attributes["content_sha256"]
        assert len(checksum) == 64
        assert checksum == read_table(tiny.path).content_sha256

    def test_configuration_makes_the_same_table_again(self, tiny, tmp_path):
        path = tmp_path / "again.h5"
        generate(parse_config(sampler.load(tiny.path).config, "t"), path, conditions=2)
        assert path.read_bytes() == tiny.path.read_bytes()

    def test_every_dataset_says_what_it_is(self, tiny):
        described = {}

        def visit(name, node):
            if isinstance(node, h5py.Dataset):
                described[name] = (node.attrs.get("units"), node.attrs.get("long_name"))

        with h5py.File(tiny.path) as file:
            file.visititems(visit)
        assert "accuracy/ks" in described
        assert all(units and long_name for units, long_name in described.values())

    def test_nodes_lie_row_by_row(self, tiny):
        contents = tiny.generated.table.contents
        for i, j in np.ndindex(2, 2):
            node = fit_node(TINY, (35.0, 45.0)[i], (60.0, 300.0)[j])
            stored = rounded_quantiles(node.quantiles)
            np.testing.assert_array_equal(contents["marginals/quantiles"][i, j], stored)
            for name in ("reflection", "mean", "cholesky", "alias_index", "first_of_class"):
                stored = contents[f"dependence/{name}"][i, j]
                np.testing.assert_array_equal(stored, getattr(node, name))

    def test_written_table_is_the_returned_one(self, tiny):
        written, returned = sampler.load(tiny.path), tiny.generated.table
        keys = {"seed": 3, "index": range(100)}
        np.testing.assert_array_equal(
            written.sample(0.7, 120.0, **keys), returned.sample(0.7, 120.0, **keys)
        )


class TestAccuracy:
    def test_is_what_was_measured(self, tiny):
        accuracy = sampler.load(tiny.path).accuracy
        comparisons = tiny.generated.comparisons
        assert len(comparisons) == 2
        where = [{"alpha_deg": c.alpha_deg, "speed": c.speed} for c in comparisons]
        measured = [w | c.distances() for w, c in zip(where, comparisons, strict=True)]
        assert set(accuracy) == set(measured[0])
        for name, values in accuracy.items():
            np.testing.assert_array_equal(values, [row[name] for row in measured])
        assert accuracy["ks"].shape == (2, 6)

    def test_can_be_measured_again(self, tiny):
        """A validation with the generator's own seed meets the same numbers, bit by bit."""
        seed = GENERATE._MEASURE_SEED
        again = validate(tiny.path, conditions=2, seed=seed, samples=MEASURED)
        assert again.comparisons == tiny.generated.comparisons
        other = validate(tiny.path, conditions=2, seed=seed + 1, samples=MEASURED)
        assert other.comparisons != tiny.generated.comparisons


@pytest.mark.processor
class TestSameBytes:
    @pytest.mark.parametrize("workers", [1, 2, 3])
    def test_whatever_the_number_of_workers(self, rough_bytes, tmp_path, workers):
        with ThreadPoolExecutor(workers) as pool:
            assert made(tmp_path / "t.h5", pool) == rough_bytes

    def test_by_default_workers_and_over_an_older_file(self, rough_bytes, tmp_path):
        path = tmp_path / "t.h5"
        path.write_text("an older file")
        assert made(path) == rough_bytes

    def test_another_seed_gives_other_bytes(self, rough_bytes, tmp_path):
        path = tmp_path / "t.h5"
        generate(ROUGH.with_changes({"table": {"seed": 6}}), path, conditions=1)
        assert path.read_bytes() != rough_bytes

    @pytest.mark.usefixtures("failing_last_node")
    def test_of_a_resumed_run(self, rough_bytes, tmp_path, monkeypatch):
        path = tmp_path / "t.h5"
        with pytest.raises(InterruptedRunError):
            made(path)
        conditions = []

        def counting(config, alpha_deg, speed, *rest):
            conditions.append((alpha_deg, speed))
            return fit_node(config, alpha_deg, speed, *rest)

        monkeypatch.setattr(REFINE, "fit_node", counting)
        assert made(path, resume=True) == rough_bytes
        assert conditions == [LAST]
        assert [p.name for p in tmp_path.iterdir()] == ["t.h5"]


class TestInterruption:
    @pytest.mark.usefixtures("failing_last_node")
    @pytest.mark.parametrize("older", [[], ["t.h5"]])
    def test_leaves_parts_and_no_output_or_an_older_one(self, tmp_path, older):
        path = tmp_path / "t.h5"
        if older:
            path.write_text("an older file")
        with pytest.raises(InterruptedRunError):
            made(path)
        assert sorted(p.name for p in tmp_path.iterdir()) == [*older, "t.h5.parts"]
        assert len(list(tmp_path.glob("t.h5.parts/piece-*.npz"))) == 3
        assert not older or path.read_text() == "an older file"

    def test_cancels_what_has_not_begun(self, monkeypatch):
        begun, gone = [], threading.Event()

        def failing(config, alpha_deg, speed, *rest):
            begun.append((alpha_deg, speed))
            if len(begun) > 1:
                gone.wait(60.0)
            raise InterruptedRunError

        monkeypatch.setattr(REFINE, "fit_node", failing)
        with ThreadPoolExecutor(1) as pool:
            with pytest.raises(InterruptedRunError):
                fit_nodes(ROUGH, first_grid(ROUGH), TaskRunner(executor=pool))
            gone.set()
        # One worker: the second node may have been on its way when the first one failed.
        assert begun in ([(35.0, 60.0)], [(35.0, 60.0), (35.0, 300.0)])

    def test_finished_run_leaves_the_file_only(self, tmp_path):
        made(tmp_path / "t.h5")
        assert [p.name for p in tmp_path.iterdir()] == ["t.h5"]

    def test_failed_measurement_keeps_the_parts(self, tmp_path, monkeypatch):
        def failing(*_, **__):
            raise InterruptedRunError

        monkeypatch.setattr(GENERATE, "measure", failing)
        with pytest.raises(InterruptedRunError):
            made(tmp_path / "t.h5")
        assert [p.name for p in tmp_path.iterdir()] == ["t.h5.parts"]
        assert len(list((tmp_path / "t.h5.parts").glob("piece-*.npz"))) == 4


class TestRefusals:
    def test_folder_that_does_not_exist(self, tmp_path, monkeypatch):
        monkeypatch.setattr(REFINE, "fit_node", None)
        with pytest.raises(InputError, match="allowed: a file in a folder that exists"):
            made(tmp_path / "none" / "t.h5")
        assert list(tmp_path.iterdir()) == []

    @pytest.mark.usefixtures("failing_last_node")
    def test_parts_of_another_configuration_or_version(self, tmp_path, monkeypatch):
        path = tmp_path / "t.h5"
        with pytest.raises(InterruptedRunError):
            made(path)
        with pytest.raises(InputError, match="another configuration or version"):
            generate(ROUGH.with_changes({"table": {"seed": 6}}), path, resume=True)
        monkeypatch.setattr(sampler, "__version__", "99.0")
        with pytest.raises(InputError, match="another configuration or version"):
            made(path, resume=True)
        assert not path.exists()


@pytest.mark.parametrize("mirror", [True, False])
def test_symmetry_is_exact_where_it_is_asked_for(tmp_path, mirror):
    config = ROUGH.with_changes({"table": {"mirror": mirror}})
    generate(config, tmp_path / "t.h5", conditions=1)
    contents = read_table(tmp_path / "t.h5")
    assert tomllib.loads(contents.config)["table"]["mirror"] is mirror
    halves = contents["dependence/reflection"][contents["dependence/reflection"] > 0] == 2048
    quantiles = contents["marginals/quantiles"][..., 3:, :]
    assert halves.all() == mirror
    assert np.array_equal(quantiles, -quantiles[..., ::-1]) == mirror
