"""OpenFOAM with the plugin: parcels carry their spin from wall to wall as a loop in Python does."""

import bounces
import foam_run
import numpy as np
import pytest
import shots

CLOUD = "constant/kinematicCloudProperties"
SEED_LINE = "seed            7;"
#: A run in which parcels meet up to nine walls.
END = 0.02
LONG = ("system/controlDict", "endTime         1e-3", f"endTime         {END}")
#: Parcels, of thousands, whose draw may differ because a condition differs in its last bits.
FEW = 2e-3
#: Rate [1/s] at which the gas of the case slows a sphere's spin down: 60 mu / (rho d^2).
DECAY = 60.0 * 1.8e-5 / (shots.DENSITY * shots.DIAMETER**2)


def entry(text):
    """The change to the case that adds an entry to the model's coefficients."""
    return CLOUD, SEED_LINE, f"{SEED_LINE}\n        {text}"


def share_off(fields, velocity, omega):
    """Share of parcels that end otherwise than expected."""
    off = np.abs(fields["U"] - velocity).max(axis=1) > 1e-6
    scale = np.abs(omega).max()
    return np.mean(off | (np.abs(fields["omega"] - omega).max(axis=1) > 1e-6 * scale))


def last_counts(log):
    """Hits, clamped, extrapolated and spin lost, at the end of a run."""
    line = [line for line in log.splitlines() if "Tabulated rebounds" in line][-1]
    return [int(count) for count in line.split("=")[1].split(",")]


@pytest.fixture(scope="module")
def spinning(table):
    """The table, if it has a spin law."""
    if not shots.has_spin_law(table):
        pytest.skip("the shipped table has no spin law")
    return table


@pytest.mark.study
@pytest.mark.parametrize("cloud", ["kinematic", "colliding"])
@pytest.mark.parametrize("processors", [1, 2])
def test_parcels_keep_their_spin(work, spinning, started, cloud, processors, tmp_path):
    velocity, omega, hits = bounces.replay(spinning, started, END)
    case = tmp_path / "case"
    fields, log = shots.run_shots(
        work, case, started, cloud, processors, edits=[LONG], end=f"{END}"
    )
    assert hits.max() > 5
    assert np.mean(fields["dTarget"] != hits) <= FEW
    assert share_off(fields, velocity, omega) <= FEW
    assert last_counts(log)[0] == fields["dTarget"].sum()
    assert last_counts(log)[3] == 0


@pytest.mark.study
@pytest.mark.parametrize("cloud", ["kinematic", "colliding"])
def test_the_gas_slows_the_spin_down(work, spinning, started, cloud, tmp_path):
    velocity, omega, _ = bounces.replay(spinning, started, END, 2.0 * DECAY)
    kept, _, _ = bounces.replay(spinning, started, END)
    assert np.mean(np.abs(kept - velocity).max(axis=1) > 1e-3) > 0.2
    edits = [LONG, entry("gasTorque 2;")]
    fields, _ = shots.run_shots(work, tmp_path / "case", started, cloud, edits=edits, end=f"{END}")
    assert share_off(fields, velocity, omega) <= FEW


@pytest.mark.study
@pytest.mark.parametrize("cloud", ["kinematic", "colliding"])
def test_a_symmetry_plane_mirrors_the_spin(work, spinning, started, cloud, tmp_path):
    velocity, omega, hits = bounces.replay(spinning, started, END, symmetry_axis=0)
    ends = ("system/blockMeshDict", "ends\n    {\n        type wall", "ends { type symmetry")
    fields, _ = shots.run_shots(
        work, tmp_path / "case", started, cloud, edits=[LONG, ends], end=f"{END}"
    )
    np.testing.assert_array_equal(fields["dTarget"] > 0, hits > 0)
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
def test_a_periodic_patch_turns_the_spin(work, spinning, started, processors, tmp_path):
    """OpenFOAM turns the angular momentum of colliding parcels; we the spin of the others."""
    left = SIDES.format(name="left", other="back", face="0 4 7 3")
    back = SIDES.format(name="back", other="left", face="0 3 2 1")
    boundary = ("system/blockMeshDict", "boundary\n(", f"boundary\n({left}{back}")
    edits = [
        LONG,
        boundary,
        ("system/blockMeshDict", "((0 4 7 3) (1 2 6 5))", "((1 2 6 5))"),
        ("system/blockMeshDict", "((0 3 2 1) (4 5 6 7))", "((4 5 6 7))"),
    ]
    ends = {}
    for cloud in ("kinematic", "colliding"):
        ends[cloud], _ = shots.run_shots(
            work, tmp_path / cloud, started, cloud, processors, edits=edits, end=f"{END}"
        )
    without, _, _ = bounces.replay(spinning, started, END)
    assert np.mean(np.abs(without - ends["colliding"]["U"]).max(axis=1) > 1e-3) > 0.2
    assert share_off(ends["kinematic"], ends["colliding"]["U"], ends["colliding"]["omega"]) <= FEW


@pytest.mark.study
@pytest.mark.parametrize("cloud", ["kinematic", "colliding"])
def test_spin_no_takes_the_law_of_particles_without_spin(work, spinning, started, cloud, tmp_path):
    edits = [entry("spin no;")]
    fields, log = shots.run_shots(work, tmp_path / "case", started, cloud, edits=edits)
    velocity, omega = spinning.rebound(
        started.velocity,
        shots.NORMAL[started.wall],
        0.5 * shots.DIAMETER,
        seed=shots.SEED,
        index=np.arange(len(started.velocity)),
        wall_velocity=shots.WALL_VELOCITY[started.wall],
    )
    hits, _, _, lost = last_counts(log)
    assert hits == len(velocity)
    assert lost == (hits if cloud == "kinematic" else 0)
    assert share_off(fields, velocity, 0.0 * omega if cloud == "kinematic" else omega) <= FEW


@pytest.mark.study
def test_two_models_of_one_cloud_share_the_spin(work, spinning, started, tmp_path):
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
        ("system/blockMeshDict", "ends\n    {\n        type wall", "ends { type symmetry"),
    ]
    fields, _ = shots.run_shots(
        work, tmp_path / "case", started, "kinematic", edits=edits, end=f"{END}"
    )
    velocity, omega, _ = bounces.replay(spinning, started, END, DECAY, symmetry_axis=0)
    assert share_off(fields, velocity, omega) <= FEW


@pytest.mark.study
@pytest.mark.parametrize(
    ("cloud", "change", "message"),
    [
        ("colliding", entry("gasTorque -1;"), "gasTorque: got -1, allowed: 0 or a positive"),
        ("colliding", entry("spin no; gasTorque 1;"), "gasTorque: got 1, allowed: 0, where no"),
        (
            "kinematic",
            (CLOUD, "dispersionModel none;", "dispersionModel stochasticDispersionRAS;"),
            "spin: got yes, allowed: no, with kinematic parcels and a dispersionModel",
        ),
    ],
)
def test_a_spin_that_cannot_be_kept_is_refused(
    work, spinning, started, cloud, change, message, tmp_path
):
    with pytest.raises(foam_run.FoamError) as refusal:
        shots.run_shots(work, tmp_path / "case", started, cloud, edits=[change])
    assert message in str(refusal.value)


@pytest.mark.study
def test_a_table_without_spin_law_keeps_no_spin(work, started, tmp_path):
    """The compact table of a scene of two velocities has none."""
