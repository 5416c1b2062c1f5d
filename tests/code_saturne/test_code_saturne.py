"""code_saturne with our user sources: particles rebound as in Python.

Needs code_saturne of Debian 12; sampler/code_saturne/install.sh installs it.
"""

import shutil

import box_run
import first_hits
import numpy as np
import pytest
import saturne_run
import saturne_wall

import sampler
from sampler.files import find_table
from sampler.formats.hdf5 import read_table
from tablegen import load_config
from tablegen.simulation.direct import model_without_warnings

pytestmark = pytest.mark.study

STEP = 2e-4
COUNT = 3000
#: Of velocities [m/s], spins [rad/s] and inertias: the box's drag is small, not nothing.
SAME = {"velocity": 1e-2, "omega": 1e4, "inertia": 1e-4}
#: Particles, of thousands, whose draw may differ because a condition differs in its last bits.
FEW = 1e-3


@pytest.fixture(scope="module")
def first(work):
    """Run of a hundred time steps."""
    return saturne_run.run(work, work / "first", 100, step=STEP, particles=COUNT)


def particles(folder):
    """Particles at the start of a run and at its end."""
    return [box_run.read_particles(folder, when) for when in ("start", "end")]


def share_off(particles, velocity, omega, inertia):
    """Share of particles that end otherwise than expected; those that began straight on aside."""
    off = np.abs(particles.velocity - velocity).max(axis=1) > SAME["velocity"]
    off |= np.abs(particles.omega - omega).max(axis=1) > SAME["omega"]
    off |= np.abs(particles.inertia - inertia) > SAME["inertia"]
    return off[~box_run.is_normal(particles.index)].mean()


def check(table, started, ended, time, **flight):
    """Particles of a run end as those that fly through the box in Python; returns their hits."""
    np.testing.assert_array_equal(started.index, ended.index)
    *after, hits = box_run.replay(table, started, time, **flight)
    assert share_off(ended, *after) <= FEW
    assert np.mean((hits != ended.hits)[~box_run.is_normal(started.index)]) <= FEW
    return hits


def test_the_shipped_user_functions_compile(work, tmp_path):
    """The box has its own user functions."""
    for path in (*saturne_run.SOURCES.glob("src/*.[ch]"), saturne_run.HEADER):
        shutil.copy(path, tmp_path)
    saturne_run.call(tmp_path, "code_saturne", "compile", "--test", "--source", tmp_path)
    assert "warning" not in (tmp_path / "code_saturne.log").read_text(encoding="utf-8")


def test_statistics_are_those_of_python(work):
    assert saturne_wall.main(work) == 0


def test_every_wall_counts_and_the_spin_is_kept(table, first):
    started, ended = particles(first)
    hits = check(table, started, ended, 100 * STEP)
    assert hits.max() > 4
    assert len(np.unique(started.index)) == COUNT
    log = (first / "run_solver.log").read_text(encoding="utf-8")
    counted = [line for line in log.splitlines() if "Tabulated rebounds" in line][-1]
    assert int(counted.split("=")[1].split(",")[0]) == ended.hits.sum()
    # without the spins at the walls they would end otherwise
    *after, _ = box_run.replay(table, started._replace(index=started.index + 1), 0.02)
    assert share_off(ended, *after) > 0.3


@pytest.fixture(scope="module")
def libraries(tmp_path_factory):
    return first_hits.direct_libraries(tmp_path_factory.mktemp("direct"))


def test_direct_simulation_is_that_of_the_model(work, libraries, tmp_path):
    given = {"step": STEP, "particles": COUNT}
    given["text"] = saturne_run.settings(direct=libraries["fits"])
    folder = saturne_run.run(work, tmp_path / "direct", 100, **given)
    model = model_without_warnings(load_config("corundum-steel"))
    assert check(model, *particles(folder), 100 * STEP).max() > 4


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("missing", "missing.so: cannot open shared object file: No such file or directory; run: "),
        ("other-pair", "other-pair.so: the object of direct simulation is of another material"),
        ("other-version", "other-version.so: the object of direct simulation was made for another"),
    ],
)
def test_a_library_that_does_not_go_with_the_table_is_refused(
    work, libraries, name, message, tmp_path
):
    text = saturne_run.settings(direct=libraries[name])
    with pytest.raises(saturne_run.SaturneError) as refusal:
        saturne_run.run(work, tmp_path / "run", 1, step=STEP, particles=10, text=text)
    assert f"rebound_wall.cfg: direct: {libraries[name].parent}/{message}" in str(refusal.value)


def test_several_walls_in_one_time_step(work, table, tmp_path):
    """Where the tracker's start stays behind at a rebound, 2 % of particles end otherwise."""
    folder = saturne_run.run(work, tmp_path / "long", 10, step=2e-3, particles=2 * COUNT)
    check(table, *particles(folder), 10 * 2e-3)


@pytest.mark.parametrize("processors", [1, 2])
def test_a_restart_changes_nothing(work, table, first, processors, tmp_path):
    """Nor does another number of processes from there on."""
    given = {"step": STEP, "particles": COUNT, "processors": processors}
    again = saturne_run.run(work, tmp_path / "again", 200, restart=first, **given)
    started = box_run.read_particles(first, "start")
    ended = box_run.read_particles(again, "end")
    check(table, started, ended, 200 * STEP)
    assert ended.hits.sum() > box_run.read_particles(first, "end").hits.sum() + COUNT // 2


def test_a_symmetry_plane_mirrors_the_spin(work, table, tmp_path):
    given = {"step": STEP, "particles": COUNT, "symmetry": 1}
    folder = saturne_run.run(work, tmp_path / "mirror", 100, **given)
    started, ended = particles(folder)
    check(table, started, ended, 100 * STEP, symmetry_axes=[0])
    through, *_ = box_run.replay(table, started, 100 * STEP)
    assert np.mean(np.abs(through - ended.velocity).max(axis=1) > 1.0) > 0.1


def test_the_gas_slows_the_spin_down(work, table, tmp_path):
    given = {"step": STEP, "particles": COUNT, "text": saturne_run.settings(gas_torque=2)}
    folder = saturne_run.run(work, tmp_path / "gas", 100, **given)
    started, ended = particles(folder)
    slow = first_hits.torque_on(box_run.MASS, *box_run.GAS, factor=2)
    *after, _ = box_run.replay(table, started, 100 * STEP, slow=slow)
    # of two walls in one time step the second is met at another time, since the tracker starts
    # beside the first: 1.2 %, and a quarter of that with a quarter of the step
    assert share_off(ended, *after) <= 20 * FEW
    kept, *_ = box_run.replay(table, started, 100 * STEP)
    assert np.mean(np.abs(kept - after[0]).max(axis=1) > 1e-2) > 0.2


def test_rough_walls(work, table, tmp_path):
    """The tilt by its standard deviation, and the same from a profile."""
    tilt_deg = np.degrees(np.arctan(2 * 0.5 / 20))
    profile = {"Ra": 0.5e-6, "Rq": 0.5e-6, "RSm": 20e-6}
    walls = {"tilt": {"tilt_deg": tilt_deg}, "profile": profile}
    walls["isotropic"] = profile | {"isotropic": "yes"}
    for name, given in walls.items():
        text = saturne_run.settings(**given)
        folder = saturne_run.run(work, tmp_path / name, 100, step=STEP, particles=COUNT, text=text)
        hits = box_run.read_hits(folder)
        rough = {"roughness": np.radians(tilt_deg), "isotropic": "isotropic" in given}
        drawn, spin, inertia = box_run.rebound(table, hits, **rough)
        rows = ~(box_run.is_normal(hits.index) & (hits.hit == 0))
        off = np.abs(drawn - hits.new_velocity).max(axis=1) > 1e-6
        off |= np.abs(spin - hits.new_omega).max(axis=1) > 1.0
        off |= np.abs(inertia - hits.new_inertia) > 1e-9
        assert off[rows].mean() <= FEW
        smooth = box_run.rebound(table, hits).velocity
        assert np.mean(np.abs(smooth - drawn).max(axis=1) > 1e-6) > 0.9


def test_slow_particles_stay_on_the_wall(work, table, tmp_path):
    """Particles of 50 um that stay below 40 m/s."""
    critical = 40.0
    text = saturne_run.settings(
        deposit_speed=critical / 2.0 ** (10.0 / 7.0), deposit_diameter=100e-6
    )
    folder = saturne_run.run(work, tmp_path / "run", 100, step=STEP, particles=COUNT, text=text)
    hits, ended = box_run.read_hits(folder), box_run.read_particles(folder, "end")
    stays = sampler.deposits(hits.velocity, hits.normal, critical)
    assert 0.2 < stays.mean() < 0.9
    np.testing.assert_array_equal((hits.new_velocity == 0.0).all(axis=1), stays)
    fixed = np.isin(ended.index, hits.index[stays])
    assert fixed.sum() == stays.sum()
    np.testing.assert_array_equal((ended.velocity == 0.0).all(axis=1), fixed)
    off = np.abs(ended.position - saturne_run.LOWER), np.abs(ended.position - saturne_run.UPPER)
    assert np.minimum(*off).min(axis=1)[fixed].max() < 1e-3
    log = (folder / "run_solver.log").read_text(encoding="utf-8")
    assert log[log.rindex(") =") :].split(",")[1] == f" {stays.sum()}"


#: Speed at which the last bin of histograms would end, m/s.
MOST = 130.0


def check_faces(folder, runs):
    """Faces of a run, and of those that it goes on from, have the hits that were recorded."""
    hits = box_run.read_hits(*runs)
    places = np.concatenate([box_run.places(run) for run in runs])
    centres, sums, bins = box_run.read_faces(folder)
    face = np.abs(places[:, None] - centres).max(axis=2).argmin(axis=1)
    before, after = (np.square(v).sum(axis=1) for v in (hits.velocity, hits.new_velocity))
    alpha = np.arcsin(-(hits.velocity * hits.normal).sum(axis=1) / np.sqrt(before))
    ones, energy = np.ones(len(alpha)), 0.5 * box_run.MASS * before
    lost = energy - 0.5 * box_run.MASS * after
    expected = np.zeros((len(centres), 6))
    rows = ones, after == 0.0, box_run.MASS * ones, energy, lost, np.degrees(alpha)
    np.add.at(expected, face, np.transpose(rows))
    expected[:, 5] /= np.maximum(expected[:, 0], 1.0)
    np.testing.assert_allclose(sums[:, :6], expected, rtol=1e-9, atol=1e-20)
    assert sums[:, 1].sum() > 100.0
    first_hits.check_bins(bins, face, alpha, np.sqrt(before), MOST)


def test_faces_have_statistics(work, tmp_path):
    """Through on one process, and stopped and restarted on two, as by the hits themselves."""
    given = {"step": STEP, "particles": COUNT}
    wanted = {"face_sums": "yes", "face_histograms": "yes", "histogram_speed": MOST}
    given["text"] = saturne_run.settings(**wanted, deposit_speed=40)
    half = saturne_run.run(work, tmp_path / "half", 50, **given)
    again = saturne_run.run(work, tmp_path / "a", 100, restart=half, processors=2, **given)
    check_faces(half, [half])
    check_faces(again, [half, again])
    assert [*again.glob("postprocessing/results_boundary.rebound_hits_of_angle_9*")]


@pytest.mark.parametrize("tilt_deg", [0, 1e-5])
def test_faces_have_works(work, tilt_deg, tmp_path):
    """Of a table with works, whose hits are drawn again; tilts are tiny."""
    file = box_run.VECTORS / "spin-works"
    text = saturne_run.settings(face_sums="yes", table=f"{file}.rbt", tilt_deg=tilt_deg)
    folder = saturne_run.run(work, tmp_path / "a", 50, step=STEP, particles=COUNT, text=text)
    table, hits = sampler.load(f"{file}.h5"), box_run.read_hits(folder)
    works = np.zeros((len(hits.hit), 2))
    box_run.rebound(table, hits, table.mean_half_size(50e-6), works=works)
    assert hits.hit.max() > 0
    sums = box_run.read_faces(folder)[1][:, 6:].sum(axis=0)
    np.testing.assert_allclose(sums, box_run.MASS * works.sum(axis=0), rtol=1e-6)


@pytest.fixture(scope="module")
def tables(work):
    contents = read_table(find_table("corundum-steel"))
    return first_hits.unfit_tables(work / saturne_run.TABLE, contents)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"table": "short"}, "table: {}: the file is damaged"),
        ({"table": "plain", "spin": "yes"}, "spin: the table has no spin law"),
        ({"seed": "7x"}, "seed: got 7x"),
        ({"spin": "maybe"}, "spin: got maybe"),
        ({"gas_torque": "nan"}, "gas_torque: got nan"),
        ({"spin": "no", "gas_torque": "1"}, "gas_torque: particles keep no spin"),
        ({"deposit_speed": "-1"}, "deposit_speed: got -1"),
        ({"tilt_deg": "30"}, "tilt_deg: got 30"),
        ({"histogram_speed": "0"}, "histogram_speed: got 0"),
        ({"Ra": "1e-6"}, "RSm: the setting is missing"),
        ({"tilt_deg": "3", "RSm": "1"}, "tilt_deg: Ra, Rq and RSm give a tilt as well"),
        ({"isotropic": "yes"}, "isotropic: the walls are smooth"),
        ({"sed": "7"}, "sed: no setting has this name"),
        ({"spin": ""}, "spin: the value is missing"),
    ],
)
def test_a_wrong_setting_is_refused(work, tables, changed, message, tmp_path):
    path = tables.get(changed.get("table"))
    text = saturne_run.settings(**{**changed, **({"table": path} if path else {})})
    with pytest.raises(saturne_run.SaturneError) as refusal:
        saturne_run.run(work, tmp_path / "run", 1, step=STEP, particles=10, text=text)
    assert f"rebound_wall.cfg: {message.format(path)}" in str(refusal.value)
    assert not list(tmp_path.glob("run/*.bin"))


def test_an_impact_outside_the_table_can_end_the_run(work, tmp_path):
    text = saturne_run.settings(out_of_range="error")
    with pytest.raises(saturne_run.SaturneError) as refusal:
        saturne_run.run(work, tmp_path / "run", 400, step=STEP, particles=COUNT, text=text)
    assert "out_of_range: got an impact at (" in str(refusal.value)
    assert "rad/s, allowed: 0.05 to 90 deg, 5 to 300 m/s" in str(refusal.value)
