"""Bad input on the command line: one line, status 2, and nothing left behind."""

import importlib

import h5py
import pytest
from command_line import SIMULATE, flags
from tiny_tables import REFINE, ROUGH

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
        "--alpha": ["0", "1e-100", "91", "nan", "steep"],
        "--speed": ["-200", "inf"],
        "--count": ["0", "2.5"],
        "--seed": ["-1", str(2**64)],
        "--aspect": [("1e-05", "0.5"), ("1.1", "0.5")],
        "--spin": [("1e+100", "0", "0")],
        "--threads": ["0"],
    }.items(),
)
def test_simulate_names_flag_and_value(refused, tmp_path, flag, values):
    for value in values:
        changes = {flag: value, "--output": tmp_path / "r.npz"}
        line = refused("simulate", *flags(SIMULATE, changes))
        assert flag in line
        assert (value if isinstance(value, str) else value[0]) in line


def test_missing_flags_are_named(refused):
    assert "'--pair'" in refused("simulate", *flags(SIMULATE, {"--pair": None}))
    assert "'--output'" in refused("simulate", *flags(SIMULATE, {}))


def test_sphere_has_no_aspect(refused, tmp_path):
    changes = {"--shape": "sphere", "--aspect": (0.8, 0.5), "--output": tmp_path / "r.npz"}
    assert "aspect: got [0.8, 0.5], allowed" in refused("simulate", *flags(SIMULATE, changes))


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
            ('law = "exponential"', 'law = "sticky"', "restitution.law: got 'sticky'"),
            ("[table]", "[table", "not valid TOML"),
        ],
    )
    def test_field_and_value(self, refused, tmp_path, monkeypatch, old, new, named):
        monkeypatch.setattr(REFINE, "fit_node", None)
        assert old in ROUGH.text
        path = tmp_path / "my.toml"
        path.write_text(ROUGH.text.replace(old, new))
        line = refused("generate", path, "--output", tmp_path / "t.h5")
        assert line.startswith("my.toml: ")
        assert named in line

    def test_unknown_name_and_folder(self, refused, tmp_path):
        output = tmp_path / "t.h5"
        line = refused("generate", "corundum-cheese", "--output", output)
        assert "configuration: got 'corundum-cheese', allowed: a name (corundum-steel" in line
        line = refused("generate", tmp_path, "--output", output)
        assert "a folder, allowed: a .toml file" in line


class TestValidate:
    @pytest.mark.parametrize(
        ("words", "named"),
        [
            (("--conditions", "0"), "'--conditions': got '0'"),
            (("--samples", "999"), "'--samples': got '999'"),
            (("--alpha", "40"), "--alpha and --speed: got 1 and 0, "),
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


def _altered(path, whole):
    path.write_bytes(whole)
    with h5py.File(path, "r+") as file:
        file["axes/speed"][0] = 61.0


def _newer(path, whole):
    path.write_bytes(whole)
    with h5py.File(path, "r+") as file:
        file.attrs["format_version"] = [2, 0]


@pytest.mark.parametrize(
    ("command", "spoil", "words"),
    [
        ("validate", lambda path, whole: path.write_bytes(whole[:9000]), "truncated or damaged"),
        ("inspect", lambda path, _: path.write_text("alpha,speed\n"), "cannot be read as HDF5"),
        ("validate", _altered, "checksum"),
        ("inspect", _newer, "needs a newer"),
        ("validate", lambda path, _: path.mkdir(), "a folder, allowed: a .h5 file"),
        ("inspect", lambda *_: None, "a file that exists"),
    ],
)
def test_tables_that_cannot_be_read(refused, tiny, tmp_path, command, spoil, words):
    path = tmp_path / "bad.h5"
    spoil(path, tiny.path.read_bytes())
    outputs = ("--json", tmp_path / "v.json", "--html", tmp_path / "v.html")
    line = refused(command, path, *(outputs if command == "validate" else ()))
    assert str(path) in line
    assert words in line


def test_table_name_that_does_not_exist(refused):
    assert "table: got 'no-such', allowed: a name (" in refused("validate", "no-such")
