"""Study `how_sure`: the laws below the measured speeds, and the command."""

import how_sure
import numpy as np
import pytest

LOW = how_sure.SPEED < 48.0


def test_yield_laws_meet_the_measured_one_and_rise_to_one(config):
    laws = how_sure.restitutions(config.pair.restitution)
    for name, values in laws.items():
        if name.endswith("below 50 m/s"):
            np.testing.assert_allclose(values[:, ~LOW], laws["tabulated"][:, ~LOW], atol=0.006)
            assert (np.diff(values[:, LOW], axis=1) <= 1e-12).all()
    # at normal impact from 50 to 0.5 m/s, a fall of yield laws by V^-1/4; Thornton's ends at 1
    ends = [laws[f"{name} below 50 m/s"][-1, 0] for name in ("Johnson", "constant")]
    assert ends[0] / ends[1] == pytest.approx(100.0**0.25)
    assert how_sure.thornton(1e-6) == pytest.approx(1.185 * 1e-6**0.25, rel=1e-3)
    assert how_sure.thornton(1.0) == pytest.approx(1.0)


def test_command_prints(capsys):
    how_sure.main(["--grains", "200"])
    rows = capsys.readouterr().out.splitlines()
    assert rows[4].startswith("| tabulated | ")
    # the tabulated law is that of the pair
    assert float(rows[4].split(" | ")[-1].rstrip(" |")) < 3.5


def test_flows_and_pairs_are_chosen(capsys):
    how_sure.main(["--flow", "cyclone", "--grains", "40"])
    out = capsys.readouterr().out
    assert out.count("| twice the resistance | ") == 3
    how_sure.main(["--pairs", "corundum-steel", "forder-1998", "--grains", "60"])
    rows = capsys.readouterr().out.splitlines()
    assert [row.split(" | ")[0] for row in rows[3:5]] == ["| corundum-steel", "| forder-1998"]
