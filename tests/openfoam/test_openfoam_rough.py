"""OpenFOAM with the plugin: rough walls, as in Python for the same keys."""

import bounces
import foam_run
import numpy as np
import pytest
import shots

import sampler

CLOUD = "constant/kinematicCloudProperties"
END = 0.01
LONG = ("system/controlDict", "endTime         1e-3", f"endTime         {END}")
#: Parcels, of thousands, whose draw may differ because a condition differs in its last bits.
FEW = 2e-3


def with_roughness(entries):
    """The change to the case that adds an entry to the coefficients."""
    return CLOUD, '"corundum-steel.rbt";', f'"corundum-steel.rbt"; roughness {{ {entries} }}'


@pytest.mark.study
@pytest.mark.parametrize(
    ("cloud", "entries", "roughness"),
    [
        ("kinematic", "tilt_deg 6;", np.radians(6.0)),
        (
            "colliding",
            "Ra 4e-6; Rq 5e-6; RSm 40e-6;",
            float(sampler.wall_tilt(4e-6, 5e-6, 40e-6, shots.DIAMETER)),
        ),
    ],
)
@pytest.mark.filterwarnings("ignore::sampler.OutsideTableWarning")
def test_rebounds_are_those_of_python(work, table, started, cloud, entries, roughness, tmp_path):
    velocity, omega, hits = bounces.replay(table, started, END, roughness=roughness)
    case = {"edits": [LONG, with_roughness(entries)], "end": f"{END}"}
    fields, _ = shots.run_shots(work, tmp_path / "case", started, cloud, **case)
    assert hits.max() > 2
    assert np.mean(fields["dTarget"] != hits) <= FEW
    off = np.abs(fields["U"] - velocity).max(axis=1) > 1e-6
    off |= np.abs(fields["omega"] - omega).max(axis=1) > 1.0
    assert np.mean(off) <= FEW
    smooth, _, _ = bounces.replay(table, started, END)
    assert np.mean(np.abs(smooth - velocity).max(axis=1) > 1e-3) > 0.9


@pytest.mark.study
@pytest.mark.parametrize(
    ("entries", "message"),
    [
        ("tilt_deg 29;", "roughness.tilt_deg: got 29, allowed: 0 to 28.64"),
        ("tilt_deg -1;", "roughness.tilt_deg: got -1, allowed: 0 to 28.64"),
        ("tilt_deg 1; Ra 1e-6;", "roughness.Ra: got one beside tilt_deg, allowed: tilt_deg alone"),
        ("Rz 1e-6;", "roughness.Rz: got one, allowed: tilt_deg alone, or Ra, Rq and RSm"),
        ("Ra 1e-6; Rq 1e-6;", "Entry 'RSm' not found in dictionary"),
        ("Ra 1e-6; Rq 1e-6; RSm 0;", "roughness.RSm: got 0, allowed: a positive length in m"),
        ("Ra -1e-6; Rq 1e-6; RSm 1;", "roughness.Ra: got -1e-06, allowed: 0 or a positive length"),
        (
            "Ra 1e-5; Rq 1e-5; RSm 1e-5;",
            "and a parcel of diameter 5e-05 m, allowed: a tilt up to",
        ),
    ],
)
def test_a_wrong_entry_is_refused(work, started, entries, message, tmp_path):
    with pytest.raises(foam_run.FoamError) as refusal:
        shots.run_shots(work, tmp_path / "case", started, edits=[with_roughness(entries)])
    assert message in str(refusal.value)
