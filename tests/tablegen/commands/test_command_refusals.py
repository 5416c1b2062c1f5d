"""Whatever the command line cannot use: one line, status 2, and nothing left behind."""

import importlib

import h5py
import numpy as np
import pytest
from command_line import SIMULATE, config_file, flags
from tiny_tables import GENERATE, REFINE, ROUGH

pytestmark = pytest.mark.usefixtures("quick_classifier")

#: The modules; in the package their names stand for the functions.
SIMULATION = importlib.import_module("tablegen.simulation.simulate")
VALIDATION = importlib.import_module("tablegen.accuracy.validate")


@pytest.mark.parametrize("words", [["simulat"], ["--fast"], ["inspect"], ["inspect", "a", "b"]])
def test_commands_and_flags_that_do_not_exist(refused, words):
    refused(*words)


@pytest.mark.parametrize(
    ("flag", "values"),
    {
        "--pair": ["corundum-cheese", "none/there.toml"],
        "--shape": ["cube"],
        "--alpha": ["0", "-10", "91", "nan", "steep"],
        "--speed": ["-200", "0", "nan", "inf"],
        "--count": ["0", "-5", "2.5"],
        "--seed": ["-1", str(2**64)],
        "--aspect": [("0", "0.5"), ("1.1", "0.5"), ("nan", "0.5")],
        "--spin": [("inf", "0", "0")],
        "--threads": ["0"],
    }.items(),
)
def test_simulate_names_flag_and_value(refused, tmp_path, flag, values):
    for value in values:
        changes = {flag: value, "--output": tmp_path / "r.npz"}
        line = refused("simulate", *flags(SIMULATE, changes))
        assert flag in line
        assert (value if isinstance(value, str) else value[0]) in line


@pytest.mark.parametrize("flag", [*SIMULATE, "--output"])
def test_what_is_left_out_is_named(refused, tmp_path, flag):
    options = SIMULATE | {"--output": tmp_path / "r.npz"}
    assert f"'{flag}'" in refused("simulate", *flags(options, {flag: None}))


def test_sphere_has_no_aspect(refused, tmp_path):
    changes = {"--shape": "sphere", "--aspect": (0.8, 0.5), "--output": tmp_path / "r.npz"}
    assert "aspect: got [0.8, 0.5], allowed" in refused("simulate", *flags(SIMULATE, changes))


def test_not_enough_memory_is_one_line(refused, tmp_path, monkeypatch):
    def unable(*_, **__):
        raise MemoryError

    monkeypatch.setattr(SIMULATION, "simulate_condition", unable)
    words = flags(SIMULATE, {"--output": tmp_path / "r.npz"})
    assert "not enough memory, allowed: a smaller count" in refused("simulate", *words)


@pytest.mark.parametrize(
    ("words", "flag"),
    [
        (("simulate", *flags(SIMULATE, {})), "--output"),
        (("generate", "corundum-steel"), "--output"),
        (("demo",), "--output"),
        (("validate", "corundum-steel"), "--json"),
        (("validate", "corundum-steel"), "--html"),
    ],
)
def test_outputs_are_checked_before_any_work(refused, tmp_path, monkeypatch, words, flag):
    for module, work in ((SIMULATION, "simulate_condition"), (VALIDATION, "validate")):
        monkeypatch.setattr(module, work, None)
    monkeypatch.setattr(REFINE, "fit_node", None)
    for path, reason in (
        (tmp_path / "none" / "f", "a folder that exists"),
        (tmp_path, "a regular file"),
    ):
        line = refused(*words, flag, path)
        assert flag in line
        assert reason in line


class TestGenerate:
    @pytest.mark.parametrize(
        ("old", "new", "named"),
        [
            ("seed = 5", "sead = 5", "table.sead: unknown field"),
            ("60.0,", "nan,", "domain.speed[0]: got nan"),
            ('law = "exponential"', 'law = "sticky"', "restitution.law: got 'sticky'"),
            ("[table]", "[table", "not valid TOML"),
            ("[table]", "\udcff", "allowed: UTF-8 text"),
        ],
    )
    def test_field_and_value(self, refused, tmp_path, monkeypatch, old, new, named):
        monkeypatch.setattr(REFINE, "fit_node", None)
        assert old in ROUGH.text
        path = tmp_path / "my.toml"
        path.write_text(ROUGH.text.replace(old, new), errors="surrogateescape")
        line = refused("generate", path, "--output", tmp_path / "t.h5")
        assert line.startswith("my.toml: ")
        assert named in line

    def test_unknown_name_and_folder(self, refused, tmp_path):
        output = tmp_path / "t.h5"
        line = refused("generate", "corundum-cheese", "--output", output)
        assert "configuration: got 'corundum-cheese', allowed: a name (corundum-steel" in line
        line = refused("generate", tmp_path, "--output", output)
        assert "a folder, allowed: a .toml file" in line
        assert "file that exists" in refused("generate", "none/there.toml", "--output", output)

    def test_output_whose_parts_have_no_place(self, refused, tmp_path):
        (tmp_path / "t.h5.parts").write_text("a file of the user's")
        line = refused("generate", config_file(tmp_path), "--output", tmp_path / "t.h5")
        assert line.startswith("output: cannot make ")

    @pytest.mark.parametrize("value", ["0", "many"])
    def test_conditions(self, refused, tmp_path, value):
        words = (config_file(tmp_path), "--output", tmp_path / "t.h5", "--conditions", value)
        assert f"'--conditions': got '{value}'" in refused("generate", *words)

    @pytest.mark.usefixtures("quick_measurement")
    def test_parts_of_another_configuration_are_refused(self, run, refused, tmp_path, monkeypatch):
        output = tmp_path / "t.h5"

        def interrupted(*_, **__):
            raise KeyboardInterrupt

        monkeypatch.setattr(GENERATE, "measure", interrupted)
        run("generate", config_file(tmp_path), "--output", output, "--quiet")
        changed = config_file(tmp_path, table={"seed": 99})
        line = refused("generate", changed, "--output", output, "--resume")
        assert line.startswith(
            f"output: got {output}.parts with 4 pieces of an unfinished run, made "
        )
        line = refused("generate", config_file(tmp_path), "--output", output)
        assert line.endswith("allowed: --resume, which uses them, or --discard, which removes them")


class TestValidate:
    @pytest.mark.parametrize(
        ("words", "named"),
        [
            (("--conditions", "0"), "'--conditions': got '0'"),
            (("--samples", "999"), "'--samples': got '999'"),
            (("--seed", "x"), "'--seed': got 'x'"),
            (("--alpha", "91"), "'--alpha': got '91'"),
            (("--speed", "0"), "'--speed': got '0'"),
            (("--alpha", "40"), "--alpha and --speed: got 1 and 0, "),
            (
                ("--alpha", "40", "--alpha", "41", *("--speed", "99") * 3),
                "--alpha and --speed: got 2 and 3, ",
            ),
            (("--alpha", "50", "--speed", "99"), "alpha: got 50 degrees, allowed: 35 to 45"),
            (("--accuracy", "good"), "accuracy: got 'good', allowed: compact, standard, fine"),
            (("--store", "--alpha", "40", "--speed", "99"), "--store: got it with --alpha"),
        ],
    )
    def test_flags_and_what_does_not_go_together(self, refused, tiny, words, named):
        assert named in refused("validate", tiny.path, *words)

    def test_names_are_not_stored_into(self, refused):
        line = refused("validate", "corundum-steel", "--store")
        assert line.startswith("--store: got the name 'corundum-steel', allowed: the path")


def _foreign_hdf5(path, _):
    with h5py.File(path, "w") as file:
        file["data"] = np.arange(4.0)


def _foreign_npz(path, _):
    with open(path, "wb") as file:
        np.savez(file, state=np.zeros((3, 6)))


def _altered(path, whole):
    path.write_bytes(whole)
    with h5py.File(path, "r+") as file:
        file["axes/speed"][0] = 61.0


def _newer(path, whole):
    path.write_bytes(whole)
    with h5py.File(path, "r+") as file:
        file.attrs["format_version"] = [2, 0]


@pytest.mark.parametrize("command", ["validate", "inspect"])
class TestTablesThatCannotBeRead:
    @pytest.mark.parametrize(
        ("spoil", "words"),
        [
            (
                lambda path, whole: path.write_bytes(whole[: len(whole) // 2]),
                "truncated or damaged",
            ),
            (lambda path, whole: path.write_bytes(whole[:100]), "truncated or damaged"),
            (lambda path, _: path.write_bytes(b""), "truncated or damaged"),
            (lambda path, _: path.write_text("alpha,speed\n45,200\n"), "cannot be read as HDF5"),
            (_foreign_hdf5, "some other HDF5 file"),
            (_foreign_npz, "cannot be read as HDF5"),
            (_altered, "checksum"),
            (_newer, "needs a newer"),
            (lambda path, _: path.mkdir(), "a folder, allowed: a .h5 file"),
            (lambda *_: None, "a file that exists"),
        ],
    )
    def test_file(self, refused, tiny, tmp_path, command, spoil, words):
        path = tmp_path / "bad.h5"
        spoil(path, tiny.path.read_bytes())
        outputs = ("--json", tmp_path / "v.json", "--html", tmp_path / "v.html")
        line = refused(command, path, *(outputs if command == "validate" else ()))
        assert str(path) in line
        assert words in line

    def test_name(self, refused, command):
        assert "table: got 'no-such', allowed: a name (" in refused(command, "no-such")
