"""OpenFOAM with the plugin: what it writes has the law of the direct model and the bits of Python.

Needs Debian 12; installs OpenFOAM's packages where they are missing, which asks for root.
"""

import json
import subprocess
import sys
from dataclasses import replace

import bounces
import foam_run
import numpy as np
import pytest
import shots
from conftest import script

import sampler
from sampler.formats.image import write_binary_table
from tablegen import load_config
from tablegen.tables.prune import pruned

CLOUD = "constant/kinematicCloudProperties"
#: A run in which parcels meet up to nine walls.
LONG = ("system/controlDict", "endTime         1e-3", "endTime         0.02")
#: Parcels, of thousands, whose draw may differ because a condition differs in its last bits. Twelve
#: digits are written, and a draw jumps only where its condition crosses a random threshold.
FEW = 1e-3


@pytest.mark.parametrize("name", ["install.sh", "build.sh", "run.sh", "bend.sh"])
def test_a_working_folder_in_the_repository_is_refused(name):
    folder = foam_run.PLUGIN / "work"
    done = script(name, folder)
    assert done.returncode == 2
    assert done.stderr == (
        f"{name}: error: FOLDER: got {folder}, allowed: a folder outside the repository\n"
    )
    assert not folder.exists()


def test_building_before_installing_is_refused(tmp_path):
    done = script("build.sh", tmp_path)
    assert done.returncode == 2
    assert done.stderr == (
        f"build.sh: error: FOLDER: got {tmp_path}, allowed: where install.sh was run\n"
    )


@pytest.mark.study
def test_statistics_are_those_of_direct_simulation(work):
    import wall

    assert wall.main(work) == 0
    results = json.loads((work / "wall.json").read_text(encoding="utf-8"))
    assert set(results) == {"kinematic-1", "kinematic-2", "colliding-1", "colliding-2"}
    for name, result in results.items():
        assert min(row["hits"] for row in result["conditions"]) >= 20_000
        # a kinematic cloud forgets the spin
        components = 3 if "kinematic" in name else 6
        assert {len(row["ks"]) for row in result["conditions"]} == {components}


@pytest.mark.study
def test_a_wrong_law_is_rejected(work, tmp_path):
    import wall

    started = shots.make_shots(2_000)
    stock = "standardWallInteraction;\n    standardWallInteractionCoeffs { type rebound; e 0.8; }"
    edits = [(CLOUD, "patchInteractionModel tabulatedRebound;", f"patchInteractionModel {stock}")]
    fields, _ = shots.run_shots(work, tmp_path / "case", started, "kinematic", edits=edits)
    direct = wall.direct_states(20_000)
    rows = wall.compare(started, shots.states(started, fields), direct)
    assert all(max(row["ks"]) > 10 * wall.KS for row in rows)
    # the right law at the speed of the next condition
    neighbour = np.empty((started.condition.size, 6))
    for k in range(len(direct)):
        neighbour[started.condition == k] = direct[k - 1][:4_000]
    assert not any(wall.passes([row]) for row in wall.compare(started, neighbour, direct))


@pytest.mark.study
@pytest.mark.parametrize("processors", [1, 2])
def test_every_wall_that_a_parcel_meets_counts(work, table, started, processors, tmp_path):
    velocity, _, hits = bounces.replay(table, started, 0.02)
    fields, log = shots.run_shots(
        work, tmp_path / "case", started, processors=processors, edits=[LONG], end="0.02"
    )
    assert hits.max() > 5
    assert np.mean(fields["dTarget"] != hits) <= FEW
    assert np.mean(np.abs(fields["U"] - velocity).max(axis=1) > 1e-6) <= FEW
    counts = [line for line in log.splitlines() if "Tabulated rebounds" in line][-1]
    assert int(counts.split("=")[1].split(",")[0]) == fields["dTarget"].sum()
    # the same parcels with other hit numbers: other velocities
    other, _, _ = bounces.replay(table, started, 0.01)
    assert np.mean(np.abs(fields["U"] - other).max(axis=1) > 1e-6) > 0.1


@pytest.mark.study
@pytest.mark.parametrize("cloud", ["kinematic", "colliding"])
def test_a_restart_changes_nothing(work, started, cloud, tmp_path):
    case = tmp_path / "case"
    half = ("system/controlDict", "endTime         1e-3", "endTime         0.01")
    shots.run_shots(work, case, started, cloud, edits=[half], end="0.01")
    foam_run.edit(case, "system/controlDict", "endTime         0.01", "endTime         0.02")
    foam_run.edit(case, "system/controlDict", "writeInterval   $endTime", "writeInterval 0.01")
    foam_run.edit(case, "system/controlDict", "startFrom       startTime", "startFrom latestTime")
    log = foam_run.run(work, case, shots.SOLVERS[cloud])
    restarted = shots.read_fields(case, "0.02", cloud)
    through, whole = shots.run_shots(
        work, tmp_path / "whole", started, cloud, edits=[LONG], end="0.02"
    )
    assert np.mean(restarted["dTarget"] != through["dTarget"]) <= FEW
    assert np.mean(np.abs(restarted["U"] - through["U"]).max(axis=1) > 1e-6) <= FEW
    # spins of ten million rad/s, of which twelve digits are written
    assert np.mean(np.abs(restarted["omega"] - through["omega"]).max(axis=1) > 1.0) <= FEW
    counts = [[x for x in text.splitlines() if "Tabulated" in x][-1] for text in (log, whole)]
    assert counts[0] == counts[1]


@pytest.mark.study
def test_walls_of_a_moving_mesh_rebound_as_those_at_rest(work, table, started, tmp_path):
    """The same shots in a box that moves as a whole."""
    moving = replace(started, velocity=started.velocity + shots.BOX_VELOCITY)
    fields, _ = shots.run_shots(work, tmp_path / "case", moving, "colliding-moving")
    expected, _ = shots.first_rebound(table, started)
    np.testing.assert_array_equal(fields["dTarget"], 1.0)
    off = np.abs(fields["U"] - shots.BOX_VELOCITY - expected).max(axis=1)
    assert np.mean(off > 1e-5) <= FEW
    # shots at walls taken to be at rest would give something else
    still, _ = shots.run_shots(
        work, tmp_path / "still", moving, edits=[("0/U", "30 0 10", "0 0 0")]
    )
    met = still["dTarget"] > 0
    assert np.mean(np.abs(fields["U"] - still["U"])[met].max(axis=1) > 1.0) > 0.9


@pytest.mark.study
def test_a_plane_case_drops_what_leaves_its_plane(work, table, tmp_path):
    started = shots.make_shots(200, plane=True)
    sides = "frontAndBack\n    {\n        type "
    edits = [
        ("system/blockMeshDict", "(16 8 16)", "(16 8 1)"),
        ("system/blockMeshDict", f"{sides}wall", f"{sides}empty"),
    ]
    fields, _ = shots.run_shots(work, tmp_path / "case", started, edits=edits)
    expected, omega = shots.first_rebound(table, started)
    assert np.abs(expected[:, 2]).max() > 10.0
    np.testing.assert_array_equal(fields["U"][:, 2], 0.0)
    np.testing.assert_allclose(fields["U"][:, :2], expected[:, :2], rtol=0, atol=1e-6)
    np.testing.assert_allclose(fields["omega"], omega, rtol=1e-6)


@pytest.mark.study
def test_other_walls_are_left_to_other_models(work, table, started, tmp_path):
    models = """multiInteraction;

    multiInteractionCoeffs
    {
        oneInteractionOnly true;
        first
        {
            patchInteractionModel tabulatedRebound;
            tabulatedReboundCoeffs { tableFile "corundum-steel.rbt"; seed 7; patches (floor); }
        }
        second
        {
            patchInteractionModel standardWallInteraction;
            standardWallInteractionCoeffs { type rebound; }
        }
    }"""
    edits = [(CLOUD, "patchInteractionModel tabulatedRebound;", f"patchInteractionModel {models}")]
    fields, log = shots.run_shots(work, tmp_path / "case", started, edits=edits)
    floor = started.wall == 0
    expected, _ = shots.first_rebound(table, started)
    np.testing.assert_allclose(fields["U"][floor], expected[floor], atol=1e-6)
    np.testing.assert_array_equal(fields["dTarget"], floor)
    mirrored = started.velocity[~floor] * (1.0, -1.0, 1.0)
    np.testing.assert_allclose(fields["U"][~floor], mirrored, atol=1e-6)
    assert "tabulatedRebound: leaves walls" in log


@pytest.mark.study
@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("seed            7", "seed -1"), "seed: got -1, allowed: 0 to 2147483647"),
        (("clamp;", "mirror;"), "outOfRange: got mirror, allowed: clamp, error"),
        (("halfSizeRule    0.5", "halfSizeRule 0"), "halfSizeRule: got 0, allowed: a positive"),
        (("seed            7;", ""), "seed"),
        (("outOfRange      clamp;", "spin maybe;"), "maybe"),
    ],
)
def test_a_wrong_entry_is_refused(work, started, change, message, tmp_path):
    with pytest.raises(foam_run.FoamError) as refusal:
        shots.run_shots(work, tmp_path / "case", started, edits=[(CLOUD, *change)])
    assert "FOAM FATAL IO ERROR" in str(refusal.value)
    assert "subModels.tabulatedReboundCoeffs" in str(refusal.value)
    assert message in str(refusal.value)


@pytest.mark.study
@pytest.mark.parametrize("processors", [1, 2])
@pytest.mark.parametrize(
    ("size", "reason"),
    [
        (None, "file: cannot be opened"),
        (100, "file_bytes: the file is truncated"),
        (9_000_000, "file_bytes: the file is truncated"),
    ],
)
def test_a_table_that_is_not_whole_is_refused(work, started, size, reason, processors, tmp_path):
    """A file that is missing, or of which only the beginning is there."""
    path = tmp_path / "part.rbt"
    if size is not None:
        path.write_bytes((work / foam_run.TABLE).read_bytes()[:size])
    edits = [(CLOUD, '"corundum-steel.rbt"', f'"{path}"')]
    with pytest.raises(foam_run.FoamError) as refusal:
        shots.run_shots(work, tmp_path / "case", started, processors=processors, edits=edits)
    assert "FOAM FATAL IO ERROR" in str(refusal.value)
    assert f'tableFile: got "{path}"' in str(refusal.value)
    assert "allowed: a file that `sampler export` wrote" in str(refusal.value)
    assert reason in str(refusal.value)


@pytest.mark.study
def test_a_condition_outside_the_table_can_end_the_run(work, table, started, tmp_path):
    changes = {"spin": False, "domain": {"speed": [50.0, 300.0]}}
    scene = load_config("corundum-steel").with_changes(changes)
    path = tmp_path / "fast.rbt"
    contents = pruned(table.contents, scene)
    write_binary_table(path, contents)
    entries = f'"{path}"; outOfRange error;'
    edits = [LONG, (CLOUD, '"corundum-steel.rbt";', entries), (CLOUD, "outOfRange      clamp;", "")]
    with pytest.raises(foam_run.FoamError) as refusal:
        shots.run_shots(work, tmp_path / "case", started, edits=edits, end="0.02")
    slowest, fastest = sampler.Table(contents).speed_range
    assert 5.0 < slowest <= 50.0
    told = f"m/s relative to the wall, allowed: 0.5 to 90 deg, {slowest:.6g} to {fastest:.6g} m/s"
    assert told in str(refusal.value)


@pytest.mark.study
def test_bend(work):
    example = foam_run.PLUGIN.parents[1] / "docs" / "examples" / "openfoam_bend"
    subprocess.run([sys.executable, example, work], check=True)
    results = json.loads((work / "bend" / "bend.json").read_text(encoding="utf-8"))["results"]
    stock, tabulated = results["spheres"], results["table"]
    assert tabulated["hits"] > 20_000
    # what OpenFOAM wrote down are the hits that the wall model counted
    for name in ("table", "table-without-spin"):
        assert results[name]["impacts"] == pytest.approx(results[name]["hits"], rel=1e-3)
    # grains are scattered out of the bend's plane, spheres are not
    assert tabulated["spread_spanwise"] > 1.5 * stock["spread_spanwise"]
    # grains meet the outer wall twice, and bring the side walls what spheres do not, more with spin
    outer = results["table"]["walls"]["outer"]["whole"]
    assert outer["impacts"]["value"][0] == pytest.approx(2.0, abs=0.2)
    sides = {name: result["walls"]["sides"]["whole"]["energy"] for name, result in results.items()}
    energy = {name: of["value"][0] for name, of in sides.items()}
    assert energy["table"] > 1.1 * energy["table-without-spin"] > 2.0 * energy["spheres"]
    assert sides["table"]["error"][0] < 0.03 * energy["table"]
    assert (work / "bend" / "bend.png").stat().st_size > 10_000
