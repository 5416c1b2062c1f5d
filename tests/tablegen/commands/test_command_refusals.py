"""Whatever the command line cannot use: one line, status 2, and nothing left behind."""

import h5py
import numpy as np
import pytest
from command_line import SIMULATE, config_file, flags
from tiny_tables import GENERATE, PLAN, ROUGH

pytestmark = pytest.mark.usefixtures("quick_classifier")


class TestWords:
    @pytest.mark.parametrize(
        "arguments", [["simulat"], ["--fast"], ["inspect"], ["inspect", "a", "b"]]
    )
    def test_commands_and_flags_that_do_not_exist(self, refused, arguments):
        refused(*arguments)


class TestSimulate:
    @pytest.mark.parametrize(
        ("flag", "value", "given"),
        [
            ("--pair", "corundum-cheese", "corundum-cheese"),
            ("--pair", "none/there.toml", "none/there.toml"),
            ("--shape", "cube", "cube"),
            ("--alpha", "0", "got '0'"),
            ("--alpha", "-10", "-10"),
            ("--alpha", "91", "91"),
            ("--alpha", "nan", "nan"),
            ("--alpha", "steep", "steep"),
            ("--speed", "-200", "-200"),
            ("--speed", "0", "got '0'"),
            ("--speed", "nan", "nan"),
            ("--speed", "inf", "inf"),
            ("--count", "0", "got '0'"),
            ("--count", "-5", "-5"),
            ("--count", "2.5", "2.5"),
            ("--seed", "-1", "-1"),
            ("--seed", str(2**64), str(2**64)),
            ("--aspect", ("0", "0.5"), "got '0'"),
            ("--aspect", ("0.5", "1.1"), "got '1.1'"),
            ("--aspect", ("nan", "0.5"), "got 'nan'"),
            ("--spin", ("0", "inf", "0"), "got 'inf'"),
            ("--threads", "0", "got '0'"),
        ],
    )
    def test_flag_and_value_are_named(self, refused, tmp_path, flag, value, given):
        output = tmp_path / "rebounds.npz"
        line = refused("simulate", *flags(SIMULATE, {flag: value, "--output": output}))
        assert flag in line
        assert given in line

    def test_sphere_has_no_aspect(self, refused, tmp_path):
        changes = {"--shape": "sphere", "--aspect": (0.8, 0.5), "--output": tmp_path / "r.npz"}
        assert "aspect: got [0.8, 0.5], allowed" in refused("simulate", *flags(SIMULATE, changes))

    @pytest.mark.parametrize("flag", [*SIMULATE, "--output"])
    def test_what_is_left_out_is_named(self, refused, tmp_path, flag):
        options = SIMULATE | {"--output": tmp_path / "r.npz"}
        assert f"'{flag}'" in refused("simulate", *flags(options, {flag: None}))

    def test_output_that_cannot_be_is_refused_before_any_work(self, refused, tmp_path, monkeypatch):
        monkeypatch.setattr("tablegen.commands.simulate_command.simulate_condition", None)
        for output, reason in (
            (tmp_path / "none" / "r.npz", "a folder that exists"),
            (tmp_path, "a file name"),
        ):
            line = refused("simulate", *flags(SIMULATE, {"--output": output}))
            assert "--output" in line
            assert reason in line

    def test_not_enough_memory_is_one_line(self, refused, tmp_path, monkeypatch):
        def unable(*_, **__):
            raise MemoryError

        monkeypatch.setattr("tablegen.commands.simulate_command.simulate_condition", unable)
        words = flags(SIMULATE, {"--output": tmp_path / "r.npz"})
        assert "not enough memory, allowed: a smaller count" in refused("simulate", *words)


class TestGenerate:
    @pytest.fixture
    def config_refused(self, refused, tmp_path, monkeypatch):
        """Refuse a configuration of the given text; nothing may be fitted or left."""
        monkeypatch.setattr(PLAN, "fit_node", None)

        def runner(text):
            path = tmp_path / "my.toml"
            path.write_bytes(text if isinstance(text, bytes) else text.encode())
            return refused("generate", path, "--output", tmp_path / "t.h5")

        return runner

    @pytest.mark.parametrize(
        ("old", "new", "words"),
        [
            ("seed = 5", "sead = 5", ["table.sead: unknown field", "seed"]),
            ("seed = 5", "seed = -5", ["table.seed: got -5", "0"]),
            ("seed = 5", 'seed = "five"', ["table.seed: got 'five'", "integer"]),
            ("60.0,", "-60.0,", ["domain.speed[0]: got -60", "0"]),
            ("60.0,", "nan,", ["domain.speed[0]: got nan", "finite"]),
            (
                "60.0,",
                "49.0,",
                ["domain.speed: got [49, 300]", "[50, 300] m/s", "extrapolate = true"],
            ),
            ("35.0,", "0.0,", ["domain.alpha_deg[0]: got 0", "greater than 0"]),
            ("45.0,", "91.0,", ["domain.alpha_deg[1]: got 91", "90"]),
            (
                "coefficient = 0.1",
                "coefficient = nan",
                ["coefficient: got nan", "finite number"],
            ),
            (
                'law = "exponential"',
                'law = "sticky"',
                ["restitution.law: got 'sticky'", "'exponential'"],
            ),
            ("prism = 1.0", "prysm = 1.0", ["population.shapes.prysm: unknown field", "prism"]),
            ("[table]", "[table", ["not valid TOML"]),
        ],
    )
    def test_field_value_and_what_is_allowed(self, config_refused, old, new, words):
        assert old in ROUGH.text
        line = config_refused(ROUGH.text.replace(old, new))
        assert line.startswith("my.toml: ")
        for word in words:
            assert word in line

    def test_not_a_text(self, config_refused):
        assert "allowed: UTF-8 text" in config_refused(b"name = \xff\xfe")

    def test_unknown_name_and_folder(self, refused, tmp_path):
        output = tmp_path / "t.h5"
        line = refused("generate", "corundum-cheese", "--output", output)
        assert "configuration: got 'corundum-cheese', allowed: a name (corundum-steel" in line
        line = refused("generate", tmp_path, "--output", output)
        assert "a folder, allowed: a .toml file" in line
        assert "file that exists" in refused("generate", "none/there.toml", "--output", output)

    def test_output_folder_that_does_not_exist(self, refused, tmp_path):
        line = refused("generate", config_file(tmp_path), "--output", tmp_path / "none" / "t.h5")
        assert "--output" in line
        assert "a folder that exists" in line

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
        assert line.startswith(f"resume: got {output}.parts, ")


class TestValidate:
    @pytest.mark.parametrize(
        ("flag", "value"),
        [
            ("--conditions", "0"),
            ("--samples", "999"),
            ("--seed", "-1"),
            ("--seed", "x"),
            ("--alpha", "91"),
            ("--speed", "0"),
        ],
    )
    def test_flags(self, refused, tiny, flag, value):
        assert f"'{flag}': got '{value}'" in refused("validate", tiny.path, flag, value)

    @pytest.mark.parametrize(
        ("words", "line"),
        [
            (("--alpha", "40"), "--alpha and --speed: got 1 and 0, allowed: as many of both"),
            (
                ("--alpha", "40", "--alpha", "41", *("--speed", "99") * 3),
                "--alpha and --speed: got 2 and 3, allowed: as many of both, or one of either",
            ),
            (("--alpha", "50", "--speed", "99"), "alpha: got 50 degrees, allowed: 35 to 45"),
            (("--accuracy", "good"), "accuracy: got 'good', allowed: compact, standard, fine"),
            (
                ("--store", "--alpha", "40", "--speed", "99"),
                "--store: got it with --alpha and --speed, allowed: without them",
            ),
        ],
    )
    def test_what_does_not_go_together(self, refused, tiny, words, line):
        assert refused("validate", tiny.path, *words).startswith(line)

    def test_names_are_not_stored_into(self, refused):
        line = refused("validate", "corundum-steel", "--store")
        assert line.startswith("--store: got the name 'corundum-steel', allowed: the path")

    @pytest.mark.parametrize("flag", ["--json", "--html"])
    def test_output_folder_is_checked_before_any_work(
        self, refused, tiny, tmp_path, monkeypatch, flag
    ):
        monkeypatch.setattr("tablegen.commands.validate_command.validate", None)
        line = refused("validate", tiny.path, flag, tmp_path / "none" / "f")
        assert flag in line


def _truncated(path, whole):
    path.write_bytes(whole[: len(whole) // 2])


def _cut_head(path, whole):
    path.write_bytes(whole[:100])


def _empty(path, _):
    path.write_bytes(b"")


def _text(path, _):
    path.write_text("alpha,speed\n45,200\n")


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


def _folder(path, _):
    path.mkdir()


class TestTablesThatCannotBeRead:
    @pytest.mark.parametrize(
        ("spoil", "words"),
        [
            (_truncated, "truncated or damaged"),
            (_cut_head, "truncated or damaged"),
            (_empty, "truncated or damaged"),
            (_text, "cannot be read as HDF5"),
            (_foreign_hdf5, "some other HDF5 file"),
            (_foreign_npz, "cannot be read as HDF5"),
            (_altered, "checksum"),
            (_newer, "needs a newer"),
            (_folder, "a folder, allowed: a .h5 file"),
            (None, "a file that exists"),
        ],
    )
    @pytest.mark.parametrize("command", ["validate", "inspect"])
    def test_file(self, refused, tiny, tmp_path, command, spoil, words):
        path = tmp_path / "bad.h5"
        if spoil:
            spoil(path, tiny.path.read_bytes())
        outputs = ("--json", tmp_path / "v.json", "--html", tmp_path / "v.html")
        line = refused(command, path, *(outputs if command == "validate" else ()))
        assert str(path) in line
        assert words in line

    @pytest.mark.parametrize("command", ["validate", "inspect"])
    def test_name(self, refused, command):
        assert "table: got 'no-such', allowed: a name (" in refused(command, "no-such")


class TestDemo:
    def test_output_folder_that_does_not_exist(self, refused, tmp_path):
        assert "--output" in refused("demo", "--output", tmp_path / "none" / "d.h5")
