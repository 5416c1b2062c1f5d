"""OpenFOAM with the plugin: parcels carry their spin from wall to wall as a loop in Python does.

The table's spin law has random numbers: a law of no particle, which depends on the spin.
"""

from dataclasses import replace

import bounces
import foam_run
import numpy as np
import pytest
import shots
from spin_tables import with_spin_law

import sampler
from sampler.formats.image import write_binary_table

CLOUD = "constant/kinematicCloudProperties"
#: A run in which parcels meet up to nine walls.
END = 0.02
LONG = ("system/controlDict", "endTime         1e-3", f"endTime         {END}")
#: Parcels, of thousands, whose draw may differ because a condition differs in its last bits.
FEW = 2e-3
#: Rate [1/s] at which the gas of the case slows a sphere's spin down: 60 mu / (rho d^2).
DECAY = 60.0 * 1.8e-5 / (shots.DENSITY * shots.DIAMETER**2)
#: The end walls of the box become symmetry planes.
SYMMETRY = ("system/blockMeshDict", "ends\n    {\n        type wall", "ends { type symmetry")


@pytest.fixture(scope="module")
def spinning(table):
    """A table with a spin law."""
    return sampler.Table(with_spin_law(table.contents))


@pytest.fixture(scope="module")
def entries(spinning, tmp_path_factory):
    """The change to the case that names this table, and adds entries to the coefficients."""
    path = tmp_path_factory.mktemp("table") / "spinning.rbt"
    write_binary_table(path, spinning.contents)
    return lambda added="": (CLOUD, '"corundum-steel.rbt";', f'"{path}"; {added}')


def share_off(fields, velocity, omega):
    """Share of parcels that end otherwise than expected."""
    off = np.abs(fields["U"] - velocity).max(axis=1) > 1e-6
    return np.mean(off | (np.abs(fields["omega"] - omega).max(axis=1) > 1.0))


def last_counts(log):
    """Hits, clamped, extrapolated and spin lost, at the end of a run."""
    line = [line for line in log.splitlines() if "Tabulated rebounds" in line][-1]
    return [int(count) for count in line.split("=")[1].split(",")]


@pytest.mark.study
@pytest.mark.parametrize("cloud", ["kinematic", "colliding"])
@pytest.mark.parametrize("processors", [1, 2])
def test_parcels_keep_their_spin(work, spinning, entries, started, cloud, processors, tmp_path):
    before = spinning.clamped, spinning.extrapolated
    velocity, omega, hits = bounces.replay(spinning, started, END)
    outside = spinning.clamped - before[0], spinning.extrapolated - before[1]
    fields, log = shots.run_shots(
        work,
        tmp_path / "case",
        started,
        cloud,
        processors,
        edits=[LONG, entries()],
        end=f"{END}",
    )
    assert hits.max() > 5
    assert np.mean(fields["dTarget"] != hits) <= FEW
    assert share_off(fields, velocity, omega) <= FEW
    counts = last_counts(log)
    assert counts[0] == fields["dTarget"].sum()
    np.testing.assert_allclose(counts[1:3], outside, rtol=FEW)
    assert counts[3] == 0


@pytest.mark.study
@pytest.mark.parametrize("cloud", ["kinematic", "colliding"])
def test_the_gas_slows_the_spin_down(work, spinning, entries, started, cloud, tmp_path):
    velocity, omega, _ = bounces.replay(spinning, started, END, 2.0 * DECAY)
    kept, _, _ = bounces.replay(spinning, started, END)
    assert np.mean(np.abs(kept - velocity).max(axis=1) > 1e-3) > 0.2
    edits = [LONG, entries("gasTorque 2;")]
    fields, _ = shots.run_shots(work, tmp_path / "case", started, cloud, edits=edits, end=f"{END}")
    assert share_off(fields, velocity, omega) <= FEW


@pytest.mark.study
@pytest.mark.parametrize("cloud", ["kinematic", "colliding"])
def test_a_symmetry_plane_mirrors_the_spin(work, spinning, entries, started, cloud, tmp_path):
    velocity, omega, _ = bounces.replay(spinning, started, END, symmetry_axes=[0])
    edits = [LONG, entries(), SYMMETRY]
    fields, _ = shots.run_shots(work, tmp_path / "case", started, cloud, edits=edits, end=f"{END}")
    assert share_off(fields, velocity, omega) <= FEW


#: Two sides of the box that meet at a right angle, each the continuation of the other.
SIDES = """
    {name}
    {{
        type cyclic; neighbourPatch {other}; transform rotational;
        rotationAxis (0 1 0); rotationCentre (-0.4 0 -0.4);
        faces (({face}));
    }}"""


@pytest.mark.study
@pytest.mark.parametrize("processors", [1, 2])
def test_a_periodic_patch_turns_the_spin(work, spinning, entries, started, processors, tmp_path):
    """OpenFOAM turns the angular momentum of colliding parcels; we the spin of the others."""
    left = SIDES.format(name="left", other="back", face="0 4 7 3")
    back = SIDES.format(name="back", other="left", face="0 3 2 1")
    edits = [
        LONG,
        entries(),
        ("system/blockMeshDict", "boundary\n(", f"boundary\n({left}{back}"),
        ("system/blockMeshDict", "((0 4 7 3) (1 2 6 5))", "((1 2 6 5))"),
        ("system/blockMeshDict", "((0 3 2 1) (4 5 6 7))", "((4 5 6 7))"),
    ]
    ends = {}
    for cloud in ("kinematic", "colliding"):
        ends[cloud], _ = shots.run_shots(
            work, tmp_path / cloud, started, cloud, processors, edits=edits, end=f"{END}"
        )
    without, _, _ = bounces.replay(spinning, started, END)
    assert np.mean(np.abs(without - ends["colliding"]["U"]).max(axis=1) > 1e-3) > 0.05
    assert share_off(ends["kinematic"], ends["colliding"]["U"], ends["colliding"]["omega"]) <= FEW


@pytest.mark.study
@pytest.mark.parametrize("cloud", ["kinematic", "colliding"])
def test_spin_no_takes_the_law_without_spin(work, table, entries, started, cloud, tmp_path):
    edits = [entries("spin no;")]
    fields, log = shots.run_shots(work, tmp_path / "case", started, cloud, edits=edits)
    velocity, omega = shots.first_rebound(table, started, with_spin=False)
    hits, _, _, lost = last_counts(log)
    assert hits == len(velocity)
    assert lost == (hits if cloud == "kinematic" else 0)
    assert share_off(fields, velocity, 0.0 * omega if cloud == "kinematic" else omega) <= FEW


@pytest.mark.study
def test_two_models_of_one_cloud_share_the_spin(work, spinning, entries, started, tmp_path):
    """Of floor and other walls: one decay, and one mirror at symmetry planes."""
    coefficients = 'tableFile "corundum-steel.rbt"; seed 7; gasTorque 1; patches'
    model = "patchInteractionModel tabulatedRebound; tabulatedReboundCoeffs"
    models = f"""multiInteraction;
    multiInteractionCoeffs
    {{
        oneInteractionOnly true;
        first {{ {model} {{ {coefficients} (floor); }} }}
        second {{ {model} {{ {coefficients} (lid frontAndBack); }} }}
    }}"""
    edits = [
        LONG,
        (CLOUD, "patchInteractionModel tabulatedRebound;", f"patchInteractionModel {models}"),
        entries(),
        SYMMETRY,
    ]
    fields, _ = shots.run_shots(
        work, tmp_path / "case", started, "kinematic", edits=edits, end=f"{END}"
    )
    velocity, omega, _ = bounces.replay(spinning, started, END, DECAY, symmetry_axes=[0])
    assert share_off(fields, velocity, omega) <= FEW


@pytest.mark.study
@pytest.mark.parametrize(
    ("added", "message"),
    [
        ("gasTorque -1;", "gasTorque: got -1, allowed: 0 or a positive number"),
        ("spin no; gasTorque 1;", "gasTorque: got 1, allowed: 0, where no spin is kept"),
        ("spin maybe;", "Expected 'true/false', 'on/off' ... found maybe"),
    ],
)
def test_a_wrong_entry_is_refused(work, entries, started, added, message, tmp_path):
    with pytest.raises(foam_run.FoamError) as refusal:
        shots.run_shots(work, tmp_path / "case", started, edits=[entries(added)])
    assert message in str(refusal.value)


@pytest.mark.study
def test_beside_a_dispersion_model_kinematic_parcels_keep_no_spin(work, entries, started, tmp_path):
    dispersion = (CLOUD, "dispersionModel none;", "dispersionModel stochasticDispersionRAS;")
    edits = [entries(), dispersion]
    with pytest.raises(foam_run.FoamError) as refusal:
        shots.run_shots(work, tmp_path / "case", started, "kinematic", edits=edits)
    assert "spin: got yes, allowed: no, with kinematic parcels and a dis" in str(refusal.value)


@pytest.mark.study
def test_a_table_without_spin_law_keeps_no_spin(work, spinning, entries, started, tmp_path):
    contents = spinning.contents
    datasets = {path: x for path, x in contents.datasets.items() if not path.startswith("spin")}
    path = tmp_path / "without.rbt"
    write_binary_table(path, replace(contents, datasets=datasets))
    file = (CLOUD, '"corundum-steel.rbt";', f'"{path}";')
    _, log = shots.run_shots(work, tmp_path / "case", started, "kinematic", edits=[file])
    assert last_counts(log)[3] == len(started.velocity)
    edits = [(*file[:2], f"{file[2]} spin yes;")]
    with pytest.raises(foam_run.FoamError) as refusal:
        shots.run_shots(work, tmp_path / "refused", started, edits=edits)
    assert "spin: got yes, allowed: no, with a table without spin law" in str(refusal.value)
