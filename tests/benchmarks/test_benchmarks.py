"""The benchmarks measure what they say: the baseline is the same model, the harness reports it."""

import json
from pathlib import Path

import baseline
import bench_error
import bench_model
import numpy as np
import pytest
from tolerances import RESOLUTIONS, TOLERANCES

from tablegen.config.config import load_config
from tablegen.simulation.simulate import make_condition, simulate_condition

POINTS = json.loads(
    (Path(__file__).parents[1] / "data" / "direct.json").read_text(encoding="utf-8")
)["points"]

#: Standard errors allowed: 105 comparisons are made below, so a right baseline fails one of them
#: with probability 105 * 2 * (1 - Phi(4.8)) = 2e-4.
ERRORS = 4.8

COUNT = 10_000

needs_compiler = pytest.mark.skipif(
    baseline.find_compiler() is None, reason="no C++ compiler, neither CXX nor g++"
)


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    compiler = baseline.find_compiler()
    return baseline.build(compiler, tmp_path_factory.mktemp("baseline"), ["-Wall", "-Werror"])


def run_baseline(program, point, **changes):
    """Baseline at a condition of direct.json, perhaps changed."""
    condition = {name: point[name] for name in ("shape", "alpha_deg", "speed")} | changes
    return baseline.run(program, **condition, count=COUNT, seed=71 + POINTS.index(point))


def largest_deviation(made, point):
    """Largest deviation of the mean of a component from direct.json, in standard errors."""
    both = np.sqrt(1.0 / COUNT + 1.0 / point["count"])
    # the file rounds to five digits
    return max(
        (abs(made["mean"][name] - mean) - 1e-5) / (point["std"][name] * both)
        for name, mean in point["mean"].items()
    )


@needs_compiler
@pytest.mark.parametrize(
    "point", POINTS, ids=lambda p: f"{p['shape']}-{p['alpha_deg']}-{p['speed']}"
)
def test_baseline_is_the_same_model(program, point):
    made = run_baseline(program, point)
    assert largest_deviation(made, point) < ERRORS
    # and does the same work
    config = load_config("corundum-steel")
    population = config.population.restricted_to(point["shape"])
    condition = make_condition(np.radians(point["alpha_deg"]), point["speed"])
    collisions = simulate_condition(
        config.pair, population, condition, 2 * COUNT, seed=70
    ).collisions
    error = collisions.std() * np.sqrt(1.5 / COUNT)
    assert abs(made["collisions"] - collisions.mean()) < ERRORS * error


@needs_compiler
@pytest.mark.parametrize(
    "change", [{"alpha_deg": 86.0}, {"speed": 150.0}, {"shape": "prism"}], ids=str
)
def test_comparison_sees_another_condition(program, change):
    point = next(p for p in POINTS if p["shape"] == "ellipsoid" and p["alpha_deg"] == 90)
    assert largest_deviation(run_baseline(program, point, **change), point) > 2.0 * ERRORS


@needs_compiler
def test_baseline_repeats_itself_and_reports_its_time(program):
    first, second = (baseline.run(program, "prism", 45.0, 200.0, 2000, 5) for _ in range(2))
    assert first["mean"] == second["mean"]
    assert first["collisions"] == second["collisions"]
    assert first["microseconds"] > 0.0
    assert baseline.run(program, "prism", 45.0, 200.0, 2000, 6)["mean"] != first["mean"]


@needs_compiler
@pytest.mark.parametrize(
    "arguments", [("cube", 45, 200, 10), ("prism", 91, 200, 10), ("prism", 45, -1, 10)]
)
def test_baseline_refuses_bad_arguments(program, arguments):
    with pytest.raises(baseline.subprocess.CalledProcessError) as caught:
        baseline.run(program, *arguments, seed=1)
    assert caught.value.returncode == 2
    assert caught.value.stderr.startswith("usage:")


def test_source_that_does_not_compile_is_reported(tmp_path, monkeypatch):
    compiler = baseline.find_compiler()
    if compiler is None:
        pytest.skip("no C++ compiler, neither CXX nor g++")
    broken = tmp_path / "broken.cpp"
    broken.write_text("int main( { }", encoding="utf-8")
    monkeypatch.setattr(baseline, "SOURCE", broken)
    with pytest.raises(RuntimeError, match=r"failed:\n.*error"):
        baseline.build(compiler, tmp_path)


def run_harness(tmp_path, capsys):
    """Harness at its smallest; the JSON and the lines that it printed."""
    file = tmp_path / "times.json"
    arguments = ["--shapes", "prism", "--angles", "45", "--count", "200", "--repeat", "3"]
    assert bench_model.main([*arguments, "--json", str(file)]) == 0
    return json.loads(file.read_text(encoding="utf-8")), capsys.readouterr().out.splitlines()


@needs_compiler
def test_harness_times_each_model_in_each_repetition(tmp_path, capsys):
    written, lines = run_harness(tmp_path, capsys)
    times = written["results"][0]["nanoseconds"]
    assert list(times) == list(bench_model.MODELS)
    assert all(len(values) == 3 and min(values) > 0.0 for values in times.values())
    assert lines[-1].split()[:3] == ["prism", "45", f"{min(times['tablegen']):.0f}"]
    assert len(lines[-1]) == len(lines[-2])


def test_harness_does_without_a_compiler(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("CXX", "no-such-compiler")
    written, lines = run_harness(tmp_path, capsys)
    assert list(written["results"][0]["nanoseconds"]) == ["tablegen", "reference"]
    assert written["machine"]["compiler"] is None
    assert lines[-1].split()[-1] == "-"


def test_models_take_turns():
    calls = []

    def timer(name, nanoseconds):
        def timed(shape, alpha_deg):
            calls.append(name)
            return nanoseconds

        return timed

    timers = {"tablegen": timer("t", 2.0), "reference": timer("r", 6.0), "C++": timer("c", 5.0)}
    times = bench_model.measure(timers, "prism", 45.0, 4)
    assert "".join(calls) == "trc" + "rct" + "ctr" + "trc"
    assert times == {"tablegen": [2.0] * 4, "reference": [6.0] * 4, "C++": [5.0] * 4}
    assert bench_model.ratio(times, "reference") == 3.0


@pytest.mark.parametrize(
    ("arguments", "allowed"),
    [
        (["--angles", "91"], "above 0 and up to 90"),
        (["--angles", "nan"], "0 or more"),
        (["--count", "0"], "1 or more"),
        (["--repeat", "x"], "1 or more"),
        (["--speed", "-1"], "0.001 or more"),
        (["--json", "no-such-folder/times.json"], "a file in a folder that exists"),
    ],
)
def test_harness_refuses_bad_input(arguments, allowed, capsys):
    with pytest.raises(SystemExit) as caught:
        bench_model.main(arguments)
    assert caught.value.code == 2
    assert f"allowed: {allowed}" in capsys.readouterr().err.splitlines()[-1]


def errors_of(*arguments):
    """Points that the error benchmark measures."""
    return bench_error.benchmark(bench_error.parse([*arguments, "--seed", "3"]))


def test_error_benchmark_sees_a_coarse_setting(tmp_path, capsys):
    file = tmp_path / "error.json"
    arguments = ["--shapes", "ellipsoid", "--angles", "90", "--count", "3000"]
    assert bench_error.main([*arguments, "--json", str(file)]) == 0
    points = json.loads(file.read_text(encoding="utf-8"))["points"]
    assert len(points) == len(RESOLUTIONS) + len(TOLERANCES)
    by_resolution = {p["resolution"]: p["error"] for p in points if p["varied"] == "resolution"}
    assert by_resolution[0.1] > 20.0 * by_resolution[1e-4] > 0.0
    assert "default" in capsys.readouterr().out


def test_error_benchmark_refuses_a_wrong_angle(capsys):
    with pytest.raises(SystemExit) as caught:
        bench_error.main(["--angles", "91"])
    assert caught.value.code == 2
    assert "got '91', allowed: above 0 and up to 90" in capsys.readouterr().err


@pytest.mark.study
def test_default_settings_leave_less_than_a_ten_thousandth():
    # the mixture; the same particles in every setting, so nothing here is left to chance
    points = errors_of("--shapes", "mixture", "--count", "400000")
    default = [p for p in points if p.is_default]
    assert max(p.error for p in default) < 1e-4
    # and a resolution three times as coarse would not do
    assert max(p.error for p in points if p.resolution == 3e-3) > 1e-4
