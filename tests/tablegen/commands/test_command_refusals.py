"""Bad input on the command line: one line, status 2, and nothing left behind."""

import pytest
from command_line import SIMULATE, flags
from tiny_tables import ROUGH

pytestmark = pytest.mark.usefixtures("quick_classifier")


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


def test_missing_and_unknown_words_are_named(refused):
    for words in (["simulat"], ["--fast"], ["inspect"], ["inspect", "a", "b"]):
        refused(*words)
    assert "'--pair'" in refused("simulate", *flags(SIMULATE, {"--pair": None}))
    assert "'--output'" in refused("simulate", *flags(SIMULATE, {}))


@pytest.mark.parametrize(
    ("words", "flag", "name"),
    [
        (("simulate", *flags(SIMULATE, {})), "--output", "r.npz"),
        (("demo",), "--output", "demo.h5"),
        (("generate", "demo"), "--output", "t.h5"),
        (("prune", "corundum-steel", "--scene", "plane-flow"), "--output", "t.h5"),
        (("calibrate", "grant-tabakoff-1975"), "--output", "t.toml"),
        (("compare", "demo", "--measured", "grant-tabakoff-1975"), "--json", "c.json"),
        (("validate", "corundum-steel"), "--html", "v.html"),
        (("report",), "--json", "r.json"),
        (("stability",), "--html", "s.html"),
    ],
)
def test_outputs_are_checked_before_any_work(refused, tmp_path, monkeypatch, words, flag, name):
    monkeypatch.setattr("sampler.files.find_file", None)  # no input is looked for either
    kept = tmp_path / name
    kept.write_text("mine")
    for path, allowed in (
        (tmp_path / "none" / name, "a file in a folder that exists"),
        (tmp_path, "a file name"),
        (kept, "a new name, or --overwrite"),
    ):
        line = refused(*words, flag, path)
        assert f"'{flag}': got {path}" in line
        assert line.endswith(f"allowed: {allowed}")


def test_configurations_that_cannot_be_used(refused, tmp_path):
    path, output = tmp_path / "my.toml", tmp_path / "t.h5"
    path.write_text(ROUGH.text.replace("seed = 5", "sead = 5"))
    line = refused("generate", path, "--output", output)
    assert line.startswith("my.toml: table.sead: unknown field")
    line = refused("generate", "corundum-cheese", "--output", output)
    assert "configuration: got 'corundum-cheese', allowed: a name (corundum-steel" in line
    line = refused("generate", tmp_path, "--output", output)
    assert "a folder or device, allowed: a regular file" in line


class TestValidate:
    @pytest.mark.parametrize(
        ("words", "named"),
        [
            (("--conditions", "0"), "'--conditions': got '0'"),
            (("--samples", "999"), "'--samples': got '999'"),
            (("--alpha", "40", "--alpha", "41"), "--alpha and --speed: got 2 and 0, allowed: as m"),
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


@pytest.mark.parametrize(
    ("command", "spoil", "words"),
    [
        ("validate", lambda path, whole: path.write_bytes(whole[:9000]), "no HDF5 file"),
        ("inspect", lambda path, _: path.write_text("alpha,speed\n"), "no HDF5 file"),
        ("validate", lambda path, _: path.mkdir(), "a folder or device, allowed: a regular file"),
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
