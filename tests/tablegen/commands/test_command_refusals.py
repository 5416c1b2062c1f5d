"""A mistake on the command line gives one line, status 2, and no file."""

import pytest
from command_line import SIMULATE, flags

from tablegen.simulation.direct_law import DirectParts

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


def test_files_are_named_as_they_were_typed(refused, tmp_path):
    none, output = tmp_path / "none.stl", {"--output": tmp_path / "r.npz"}
    line = refused("simulate", *flags(SIMULATE, output | {"--shape": None, "--particle": none}))
    assert line == f"--particle: there is no file {none}"
    line = refused("simulate", *flags(SIMULATE, output | {"--pair": "none"}))
    assert line.startswith("--pair: there is no .toml file 'none'; the installed names are ")
    scene = tmp_path / "scene.toml"
    scene.write_text('name = "m"\npair = "demo"\n[[population.meshes]]\nfile = "none.stl"\n')
    line = refused("generate", scene, "--output", tmp_path / "t.h5")
    assert line == f"scene.toml: population.meshes[0].file: there is no file {none}"


def test_a_machine_is_refused_before_anything_is_compiled(refused, tmp_path, monkeypatch):
    monkeypatch.setattr(DirectParts, "from_config", None)
    words = "export-direct", "demo", "--target", "nosuch", "--output", tmp_path / "direct"
    assert refused(*words).startswith("--target: got 'nosuch', allowed: a triple such as ")


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
        (("stability",), "--json", "s.json"),
    ],
)
def test_outputs_are_checked_before_any_work(refused, tmp_path, monkeypatch, words, flag, name):
    monkeypatch.setattr("sampler.files.find_file", None)  # no input is looked for either
    kept = tmp_path / name
    kept.write_text("mine")
    folder = tmp_path / "none"
    for path, message in (
        (folder / name, f"cannot write {folder / name}: there is no folder {folder}"),
        (tmp_path, f"{tmp_path} is a folder; give a file name"),
        (kept, f"{kept} exists; give a new name, or --overwrite"),
    ):
        assert refused(*words, flag, path) == f"{flag}: {message}"
    line = refused(*words, flag, tmp_path / f"{'x' * 300}{kept.suffix}")
    assert line.endswith("File name too long")


def test_files_beside_an_output_are_kept(refused, tmp_path):
    picture = tmp_path / "demo.png"
    picture.write_text("mine")
    assert f"--output: {picture} exists" in refused("demo", "--output", tmp_path / "demo.h5")


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (("--conditions", "0"), "--conditions: got '0'"),
        (("--samples", "999"), "--samples: got '999'"),
        (
            ("--alpha", "40", "--alpha", "41"),
            "--speed: there are 2 angles and 0 speeds",
        ),
        (("--alpha", "50", "--speed", "99"), "alpha: got 50 degrees"),
        (("--accuracy", "good"), "--accuracy: got 'good'"),
        (
            ("--store", "--alpha", "40", "--speed", "99"),
            "--store: is given with chosen conditions; leave --alpha",
        ),
    ],
)
def test_validate_names_flags_and_what_does_not_go_together(refused, tiny, words, named):
    assert named in refused("validate", tiny.path, *words)


def test_validate_does_not_store_into_names(refused):
    assert refused("validate", "corundum-steel", "--store").startswith("--store: got the name")


@pytest.mark.parametrize("command", ["validate", "inspect"])
def test_tables_that_cannot_be_read_are_named(refused, tiny, tmp_path, command):
    path = tmp_path / "bad.h5"
    assert refused(command, path) == f"table: there is no file {path}"
    path.write_bytes(tiny.path.read_bytes()[:9000])
    assert str(path) in refused(command, path)
