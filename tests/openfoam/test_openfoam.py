"""OpenFOAM with the plugin: rebounds have the law of the direct model and the bits of Python.

Needs Debian 12; installs OpenFOAM's packages where they are missing, which asks for root.
"""

from dataclasses import replace
from pathlib import Path

import first_hits
import foam_files
import foam_run
import foam_wall
import numpy as np
import pytest
import shots

import sampler
from sampler.files import find_table
from sampler.formats.hdf5 import read_table
from sampler.formats.image import write_binary_table
from tablegen import load_config
from tablegen.simulation.direct import model_without_warnings
from tablegen.tables.prune import pruned

pytestmark = [pytest.mark.study, pytest.mark.filterwarnings("ignore::sampler.OutsideTableWarning")]
VECTORS = Path(__file__).parents[1] / "vectors"
CLOUD = "constant/kinematicCloudProperties"
#: A run in which parcels meet up to nine walls.
END = 0.02
LONG = ("system/controlDict", "endTime         1e-3", f"endTime         {END}")
#: Share of parcels whose draw may differ because a condition differs in its last bits: twelve
#: digits are written, and a draw jumps where its condition crosses a random threshold.
FEW = 2e-3
#: Density of the gas [kg/m3]: of the case, and of a perfect gas with OpenFOAM's constants.
GAS_DENSITY = {"colliding": 1.2, "kinematic": 1e5 * 28.96 / (6.02214179e26 * 1.38065e-23 * 300)}
#: The end walls of the box become symmetry planes.
SYMMETRY = ("system/blockMeshDict", "ends\n    {\n        type wall", "ends { type symmetry")
both_clouds = pytest.mark.parametrize("cloud", ["kinematic", "colliding"])
one_and_two = pytest.mark.parametrize("processors", [1, 2])


def with_entries(entries, file="corundum-steel.rbt"):
    """Return the change of the case that adds entries to the coefficients."""
    return CLOUD, '"corundum-steel.rbt";', f'"{file}"; {entries}'


def with_models(*coefficients):
    """Return the change of the case that has one tabulatedRebound for each of some coefficients."""
    model = "patchInteractionModel tabulatedRebound; tabulatedReboundCoeffs"
    common = 'tableFile "corundum-steel.rbt"; seed 7;'
    parts = [f"m{k} {{ {model} {{ {common} {c} }} }}" for k, c in enumerate(coefficients)]
    stock = "patchInteractionModel standardWallInteraction; standardWallInteractionCoeffs"
    parts.append(f"last {{ {stock} {{ type rebound; }} }}")
    models = f"multiInteractionCoeffs {{ oneInteractionOnly true; {' '.join(parts)} }}"
    named = "patchInteractionModel tabulatedRebound;"
    return CLOUD, named, f"patchInteractionModel multiInteraction; {models}"


def share_off(fields, velocity, omega, inertia):
    """Return the share of parcels that end elsewhere than expected."""
    off = np.abs(fields["U"] - velocity).max(axis=1) > 1e-6
    # spins of ten million rad/s, of which twelve digits are written
    off |= np.abs(fields["omega"] - omega).max(axis=1) > 1.0
    return np.mean(off | (np.abs(fields["inertia"] - inertia) > 1e-6))


def last_counts(log):
    """Return the counts at the end of a run: hits, deposits, and hits with each flag."""
    line = [line for line in log.splitlines() if "Tabulated rebounds" in line][-1]
    return [int(count) for count in line.split("=")[1].split(",")]


def test_statistics_are_those_of_direct_simulation(work):
    assert foam_wall.main(work) == 0


def test_a_wrong_law_is_rejected(work, tmp_path):
    started = shots.make_shots(2_000)
    stock = "standardWallInteraction;\n    standardWallInteractionCoeffs { type rebound; e 0.8; }"
    edits = [(CLOUD, "patchInteractionModel tabulatedRebound;", f"patchInteractionModel {stock}")]
    fields, _ = shots.run_shots(work, tmp_path / "case", started, "kinematic", edits=edits)
    direct, states = first_hits.direct_states(20_000), shots.states(started, fields)
    rows = first_hits.compare(states, started.condition, direct)
    assert all(row.ks > 10 * first_hits.KS for row in rows)
    # the right law at the speed of the next condition
    for k in range(len(direct)):
        states[started.condition == k] = direct[k - 1][:4_000]
    rows = first_hits.compare(states, started.condition, direct)
    assert not any(row.holds for row in rows)


@both_clouds
@one_and_two
def test_every_wall_counts_and_the_spin_is_kept(work, table, started, cloud, processors, tmp_path):
    before = table.counts
    *after, hits = shots.replay(table, started, END)
    flagged = [number - before[kind] for kind, number in table.counts.items()]
    case = {"edits": [LONG], "end": f"{END}"}
    fields, log = shots.run_shots(work, tmp_path / "case", started, cloud, processors, **case)
    assert hits.max() > 5
    assert np.mean(fields["hits"] != hits) <= FEW
    assert share_off(fields, *after) <= FEW
    counts = last_counts(log)
    assert counts[:2] == [fields["hits"].sum(), 0]
    np.testing.assert_allclose(counts[2:], flagged, rtol=FEW, atol=1)


@pytest.fixture(scope="module")
def libraries(tmp_path_factory):
    return first_hits.direct_libraries(tmp_path_factory.mktemp("direct"))


@both_clouds
def test_direct_simulation_is_that_of_the_model(work, libraries, started, cloud, tmp_path):
    *after, hits = shots.replay(model_without_warnings(load_config("corundum-steel")), started, END)
    edits = [LONG, with_entries(f'directFile "{libraries["fits"].as_posix()}";')]
    case = {"edits": edits, "end": f"{END}"}
    fields, log = shots.run_shots(work, tmp_path / "case", started, cloud, **case)
    assert hits.max() > 5
    assert np.mean(fields["hits"] != hits) <= FEW
    assert share_off(fields, *after) <= FEW
    assert last_counts(log)[0] == fields["hits"].sum()


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("missing", "missing.so: cannot open shared object file: No such file or directory; run: "),
        ("other-pair", "other-pair.so: the object of direct simulation is of another material"),
        ("other-version", "other-version.so: the object of direct simulation was made for another"),
    ],
)
def test_a_library_that_does_not_go_with_the_table_is_refused(
    work, libraries, started, name, message, tmp_path
):
    edits = [LONG, with_entries(f'directFile "{libraries[name].as_posix()}";')]
    with pytest.raises(foam_run.FoamError, match="FOAM FATAL IO ERROR") as refusal:
        shots.run_shots(work, tmp_path / "case", started, edits=edits, end=f"{END}")
    assert f"directFile: {libraries[name].parent.as_posix()}/{message}" in str(refusal.value)


@both_clouds
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
    assert np.mean(restarted["hits"] != through["hits"]) <= FEW
    assert share_off(restarted, *(through[name] for name in ("U", "omega", "inertia"))) <= FEW
    assert last_counts(log) == last_counts(whole)


def test_walls_of_a_moving_mesh_rebound_as_those_at_rest(work, table, started, tmp_path):
    """Rebounds of the same shots, in a box that moves as a whole, are the same."""
    moving = replace(started, velocity=started.velocity + shots.BOX_VELOCITY)
    fields, _ = shots.run_shots(work, tmp_path / "case", moving, "colliding-moving")
    expected, *_ = shots.first_rebound(table, started)
    np.testing.assert_array_equal(fields["hits"], 1.0)
    off = np.abs(fields["U"] - shots.BOX_VELOCITY - expected).max(axis=1)
    assert np.mean(off > 1e-5) <= FEW


#: Of the case whose parcels of low normal speed stay on the wall.
DEPOSIT = "deposit { speed 18.575; diameter 100e-6; }"
SUMS = ("hits", "deposits", "mass", "energyBefore", "energyLost", "angle_deg")
#: Speed where the last bin would end, m/s; the fastest parcels are beyond.
MOST = 260.0
HISTOGRAMS = f"faceHistograms yes; histogramSpeed {MOST};"
BINS = [f"hitsOf{axis}{k}" for axis in ("Angle", "Speed") for k in range(10)]


@both_clouds
def test_deposits_stay_and_faces_have_statistics(work, table, started, cloud, tmp_path):
    """Statistics are the same on one processor, and on two with a restart in between."""
    edits = [with_entries(f"faceSums yes; {HISTOGRAMS} {DEPOSIT}")]
    whole, case = tmp_path / "whole", tmp_path / "case"
    fields, log = shots.run_shots(work, whole, started, cloud, edits=edits)
    half = ("system/controlDict", "endTime         1e-3", "endTime         5e-4")
    shots.run_shots(work, case, started, cloud, 2, [*edits, half], "0.0005")
    foam_run.edit(case, "system/controlDict", "endTime         5e-4", "endTime         1e-3")
    foam_run.edit(case, "system/controlDict", "writeInterval   $endTime", "writeInterval 5e-4")
    foam_run.edit(case, "system/controlDict", "startFrom       startTime", "startFrom latestTime")
    foam_run.run(work, case, shots.SOLVERS[cloud], processors=2)

    alpha, speed = np.array(first_hits.CONDITIONS)[started.condition].T
    stays = speed * np.sin(alpha) < 50.0
    assert last_counts(log)[:2] == [stays.size, stays.sum()]
    np.testing.assert_array_equal(fields["hits"], 1.0)
    np.testing.assert_array_equal((fields["U"] == 0.0).all(axis=1), stays)
    drawn, *_ = shots.first_rebound(table, started)
    relative = np.where(stays[:, None], 0.0, drawn - shots.WALL_VELOCITY[started.wall])
    mass = shots.DENSITY * np.pi / 6.0 * first_hits.DIAMETER**3
    before, after = mass / 2.0 * speed**2, mass / 2.0 * (relative**2).sum(axis=1)
    expected = {"hits": stays.size, "deposits": stays.sum(), "mass": stays.size * mass}
    expected |= {"energyBefore": before.sum(), "energyLost": (before - after).sum()}
    sums = {name: foam_files.read_faces(whole, "0.001", f"kinematicCloud_{name}") for name in SUMS}
    for name, total in expected.items():
        assert sums[name].sum() == pytest.approx(total, rel=1e-6), name
    assert sums["hits"] @ sums["angle_deg"] == pytest.approx(np.degrees(alpha).sum(), rel=1e-6)
    # not the bins that meet at 45 degrees, which many parcels have
    for name in set(SUMS) | set(BINS) - {"hitsOfAngle4", "hitsOfAngle5"}:
        field = f"kinematicCloud_{name}"
        here, there = (foam_files.read_faces(run, "0.001", field) for run in (whole, case))
        np.testing.assert_allclose(np.sort(there[there > 0.0]), np.sort(here[here > 0.0]))


def test_faces_have_histograms(work, started, tmp_path):
    """The histograms agree with the places of the parcels on floor and lid."""
    shots.run_shots(work, tmp_path, started, edits=[with_entries(HISTOGRAMS)])
    foam_run.run(work, tmp_path, "postProcess", "-func", "writeCellCentres", "-latestTime")
    alpha, speed = np.array(first_hits.CONDITIONS)[started.condition].T
    height = shots.HEIGHT[started.wall] - started.position[:, 1]
    places = started.position + (height / started.velocity[:, 1])[:, None] * started.velocity
    for wall, patch in enumerate(("floor", "lid")):
        rows = started.wall == wall
        centres = np.transpose(
            [foam_files.read_faces(tmp_path, "0.001", name, patch) for name in ("Cx", "Cz")]
        )
        counts = np.zeros((len(centres), len(BINS)))
        for k, name in enumerate(BINS):  # a bin without hits is uniform
            hits = foam_files.read_faces(tmp_path, "0.001", f"kinematicCloud_{name}", patch)
            counts[:, k] = hits if hits.size else 0.0
        face = np.abs(places[rows][:, None, ::2] - centres).max(axis=2).argmin(axis=1)
        first_hits.check_bins(counts, face, alpha[rows], speed[rows], MOST)


@pytest.mark.parametrize("roughness", ["", "roughness { tilt_deg 1e-5; }"])
def test_faces_have_works(work, started, roughness, tmp_path):
    """The table has works, particles have no spin at first, and the wall is hardly rough."""
    name = "spin-works.rbt"
    table, file = sampler.load(VECTORS / "spin-works.h5"), (VECTORS / name).as_posix()
    edits = [with_entries(f"faceSums yes; {roughness}", file)]
    shots.run_shots(work, tmp_path, started, edits=edits)
    alpha, speed = np.array(first_hits.CONDITIONS)[started.condition].T
    keys = {"seed": first_hits.SEED, "index": np.arange(speed.size), "hit": 0}
    values = table.sample(alpha, speed, spin=np.zeros(3), **keys)[:, -2:]
    mass = shots.DENSITY * np.pi / 6.0 * first_hits.DIAMETER**3
    expected = mass / 2.0 * speed**2 @ values
    for field, total in zip(("workNormal", "workShear"), expected, strict=True):
        sums = foam_files.read_faces(tmp_path, "0.001", f"kinematicCloud_{field}")
        assert sums.sum() == pytest.approx(total, rel=1e-4), field


def test_a_plane_case_drops_the_velocity_out_of_its_plane(work, table, tmp_path):
    started = shots.make_shots(200, plane=True)
    sides, mesh = "frontAndBack\n    {\n        type ", "system/blockMeshDict"
    edits = [(mesh, "(16 8 16)", "(16 8 1)"), (mesh, f"{sides}wall", f"{sides}empty")]
    fields, _ = shots.run_shots(work, tmp_path / "case", started, edits=edits)
    expected, omega, inertia = shots.first_rebound(table, started)
    assert np.abs(expected[:, 2]).max() > 10.0
    np.testing.assert_array_equal(fields["U"][:, 2], 0.0)
    np.testing.assert_allclose(fields["U"][:, :2], expected[:, :2], rtol=0, atol=1e-6)
    np.testing.assert_allclose(fields["omega"], omega, rtol=1e-6)
    np.testing.assert_allclose(fields["inertia"], inertia, rtol=1e-6)


def test_other_walls_are_left_to_other_models(work, table, started, tmp_path):
    edits = [with_models("patches (floor);")]
    fields, _ = shots.run_shots(work, tmp_path / "case", started, edits=edits)
    floor = started.wall == 0
    expected, *_ = shots.first_rebound(table, started)
    np.testing.assert_allclose(fields["U"][floor], expected[floor], atol=1e-6)
    np.testing.assert_array_equal(fields["hits"], floor)
    mirrored = started.velocity[~floor] * (1.0, -1.0, 1.0)
    np.testing.assert_allclose(fields["U"][~floor], mirrored, atol=1e-6)


TWO_MODELS = with_models(*(f"gasTorque 1; patches ({p});" for p in ("floor", "lid frontAndBack")))


@both_clouds
@pytest.mark.parametrize(
    ("edits", "flight"),
    [
        ([with_entries("gasTorque 2;")], {"gas_torque": 2.0}),
        ([SYMMETRY], {"symmetry_axes": [0]}),
        # two models of one cloud: one decay, and one mirror at symmetry planes
        ([SYMMETRY, TWO_MODELS], {"gas_torque": 1.0, "symmetry_axes": [0]}),
        ([with_entries("roughness { tilt_deg 6; }")], {"roughness": np.radians(6.0)}),
        (
            [with_entries("roughness { Ra 4e-6; Rq 5e-6; RSm 40e-6; }")],
            {"roughness": float(sampler.wall_tilt(4e-6, 5e-6, 40e-6, first_hits.DIAMETER))},
        ),
        (
            [with_entries("roughness { tilt_deg 6; isotropic yes; }")],
            {"roughness": np.radians(6.0), "isotropic": True},
        ),
    ],
    ids=["gas torque", "symmetry plane", "two models", "tilt", "profile", "isotropic"],
)
def test_flights_are_those_of_python(work, table, started, cloud, edits, flight, tmp_path):
    case = {"edits": [LONG, *edits], "end": f"{END}"}
    fields, _ = shots.run_shots(work, tmp_path / "case", started, cloud, **case)
    flight = dict(flight)
    if factor := flight.pop("gas_torque", None):
        flight["slow"] = first_hits.torque_on(shots.MASS, GAS_DENSITY[cloud], 1.8e-5, factor)
    *after, _ = shots.replay(table, started, END, **flight)
    assert share_off(fields, *after) <= FEW
    velocity, other = after[0], shots.replay(table, started, END)[0]
    assert np.mean(np.abs(other - velocity).max(axis=1) > 1e-3) > 0.1


#: Two sides of the box that meet at a right angle, each the continuation of the other.
SIDES = """
    {name}
    {{
        type cyclic; neighbourPatch {other}; transform rotational;
        rotationAxis (0 1 0); rotationCentre (-0.4 0 -0.4);
        faces (({face}));
    }}"""


@one_and_two
def test_a_periodic_patch_turns_the_spin(work, table, started, processors, tmp_path):
    """OpenFOAM turns the angular momentum of colliding parcels, the plugin the spin of others."""
    left = SIDES.format(name="left", other="back", face="0 4 7 3")
    back = SIDES.format(name="back", other="left", face="0 3 2 1")
    mesh = "system/blockMeshDict"
    edits = [
        LONG,
        (mesh, "boundary\n(", f"boundary\n({left}{back}"),
        (mesh, "((0 4 7 3) (1 2 6 5))", "((1 2 6 5))"),
        (mesh, "((0 3 2 1) (4 5 6 7))", "((4 5 6 7))"),
    ]
    given = {"processors": processors, "edits": edits, "end": f"{END}"}
    ends = {
        cloud: shots.run_shots(work, tmp_path / cloud, started, cloud, **given)[0]
        for cloud in ("kinematic", "colliding")
    }
    without, *_ = shots.replay(table, started, END)
    assert np.mean(np.abs(without - ends["colliding"]["U"]).max(axis=1) > 1e-3) > 0.05
    colliding = [ends["colliding"][name] for name in ("U", "omega", "inertia")]
    assert share_off(ends["kinematic"], *colliding) <= FEW


@both_clouds
def test_spin_no_gives_the_table_none(work, table, started, cloud, tmp_path):
    case = {"edits": [LONG, with_entries("spin no;")], "end": f"{END}"}
    fields, _ = shots.run_shots(work, tmp_path / "case", started, cloud, **case)
    velocity, omega, inertia, _ = shots.replay(table, started, END, spin=False)
    kept = 0.0 if cloud == "kinematic" else 1.0
    assert share_off(fields, velocity, kept * omega, 0.0 * inertia) <= FEW


@pytest.fixture(scope="module")
def tables(work):
    """Tables by name; one is of fast impacts only."""
    contents = read_table(find_table("corundum-steel"))
    unfit = first_hits.unfit_tables(work / foam_run.TABLE, contents)
    changes = {"spin": False, "domain": {"speed": [50.0, 300.0]}}
    scene = load_config("corundum-steel").with_changes(changes)
    write_binary_table(work / "fast.rbt", pruned(contents, scene))
    return unfit | {"fast": work / "fast.rbt"}


@pytest.mark.parametrize(
    ("file", "entries", "message"),
    [
        (None, "seed -1;", "seed: got -1"),
        (None, "outOfRange mirror;", "outOfRange: got mirror"),
        (None, "halfSizeRule 0;", "halfSizeRule: got 0"),
        (None, "deposit { speed 0; }", "deposit.speed: got 0"),
        (None, "gasTorque -1;", "gasTorque: got -1"),
        (None, "spin no; gasTorque 1;", "gasTorque: parcels keep no spin"),
        (None, "roughness { tilt_deg 29; }", "roughness.tilt_deg: got 29"),
        (None, "faceHistograms yes; histogramSpeed 0;", "histogramSpeed: got 0"),
        (None, "roughness { Ra 1e-6; Rq 1e-6; }", "Entry 'RSm' not found in dictionary"),
        (None, "roughness { Ra 1; Rq 1; RSm 1; }", "and a parcel of diameter 5e-05 m, allowed:"),
        ("none", "", "the file does not exist, or may not be read"),
        ("short", "", "the file is damaged: "),
        ("plain", "spin yes;", "spin: the table has no spin law"),
        ("fast", "outOfRange error;", " rad/s, allowed: 0.05 to 90 deg"),
    ],
)
def test_a_wrong_entry_is_refused(work, tables, started, file, entries, message, tmp_path):
    changed = entries.split()[0] if entries else None
    edits = [LONG, with_entries(entries, tables.get(file, "corundum-steel.rbt"))]
    for name, value in (("seed", "7"), ("outOfRange", "clamp")):
        if name == changed:
            edits.append((CLOUD, f"{name:15} {value};", ""))
    with pytest.raises(foam_run.FoamError) as refusal:
        shots.run_shots(work, tmp_path / "case", started, edits=edits, end=f"{END}")
    assert "FOAM FATAL" in str(refusal.value)
    assert message in str(refusal.value)


def test_kinematic_parcels_keep_no_spin_beside_a_dispersion_model(work, started, tmp_path):
    edits = [(CLOUD, "dispersionModel none;", "dispersionModel stochasticDispersionRAS;")]
    with pytest.raises(foam_run.FoamError) as refusal:
        shots.run_shots(work, tmp_path / "case", started, "kinematic", edits=edits)
    assert "spin: UTurb of a kinematic parcel keeps the spin" in str(refusal.value)


def test_bend(work):
    done = foam_run.script("bend.sh", work)
    assert done.returncode == 0, done.stderr
    assert (work / "bend" / "bend.png").stat().st_size > 10_000
    log = (work / "bend" / "table" / "log.icoUncoupledKinematicParcelFoam").read_text()
    assert last_counts(log)[0] > 20_000
    rows = [line.split("|")[2:5] for line in done.stdout.splitlines() if line.startswith("| imp")]
    numbers = [[float(cell.split("±")[0]) for cell in row] for row in rows]
    # impacts and energy on outer, inner and side walls: spheres, table without spin, table
    (impacts, *_), (*_, energy) = numbers[0:2], numbers[1::2]
    assert impacts[2] == pytest.approx(2.0, abs=0.2)
    # grains bring the side walls energy that spheres do not, more with spin
    assert energy[2] > 1.1 * energy[1] > 2.0 * energy[0]
