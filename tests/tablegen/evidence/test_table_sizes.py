"""The sweep over table sizes: enough settings, valid ones, compared between their nodes."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from tablegen.evidence.sampling_methods import DOMAIN, BenchmarkCase
from tablegen.evidence.table_sizes import (
    FAMILY,
    design_condition,
    design_config,
    design_methods,
    designs,
    other_table,
    part_of,
    seconds_at_random,
    whole_table,
)
from tiny_tables import TINY

import sampler
from sampler.errors import InputError
from sampler.formats.hdf5 import write_table
from tablegen.config.config import load_config
from tablegen.tables.prune import prune

CONFIG = load_config("corundum-steel")


def test_at_least_twelve_settings():
    every = designs()
    assert len({design.name for design in every}) == len(every) >= 12
    assert {design.varied for design in every} == {"base", "nodes", "components", "knots"}


@pytest.mark.parametrize("design", designs(), ids=lambda design: design.name)
def test_designs_are_compared_between_their_nodes(design):
    config = design_config(CONFIG, design, 1000, 1)
    assert config.domain.alpha_deg == (60.0, 75.0)
    assert config.domain.speed == (123.0, 186.0)
    for value, nodes in zip(
        design_condition(CONFIG),
        (config.table.alpha_nodes_deg, config.table.speed_nodes),
        strict=True,
    ):
        low, high = next((a, b) for a, b in pairwise(nodes) if a <= value <= b)
        assert 0.2 < (value - low) / (high - low) < 0.8


def test_a_design_is_generated_and_says_what_it_took():
    alpha_deg, speed = design_condition(CONFIG)
    method = next(method for method in design_methods(1500) if method.settings["components"] == 4)
    ready = method.prepare(BenchmarkCase(CONFIG, alpha_deg, speed, np.empty((0, 6)), 2))
    assert ready.draw(50, 1).shape == (50, 6)
    assert ready.size > 10_000
    assert ready.setup > 0.0


def test_parts_of_ranges():
    assert part_of((0.5, 90.0), (0.665, 0.8325)) == (60.0, 75.0)
    assert part_of((40.0, 40.0), (0.2, 0.4)) == (40.0, 40.0)
    low, high = part_of((40.0, 41.0), (0.2, 0.4))
    assert 40.0 <= low < high <= 41.0


def test_draws_at_random_conditions_take_time():
    assert 0.0 < seconds_at_random(sampler.load("corundum-steel"), 1000, 1) < 1.0


class TestTablesBeside:
    def test_are_drawn_from_at_the_same_conditions(self, tiny):
        method = other_table(str(tiny.path), sampler.load(tiny.path))
        assert (method.family, method.covers) == (FAMILY, DOMAIN)

    def test_of_another_pair_are_refused(self, tiny, tmp_path):
        other = tmp_path / "other.h5"
        write_table(other, replace(sampler.load(tiny.path).contents, pair="sand-glass"))
        with pytest.raises(InputError, match="got pair sand-glass, allowed: corundum-steel"):
            other_table(str(other), sampler.load(tiny.path))

    def test_of_a_smaller_range_are_refused(self, tiny):
        shipped = sampler.load("corundum-steel")
        with pytest.raises(InputError, match=r"got a range of 35 to 45 degrees, allowed: 0.5 to"):
            other_table(str(tiny.path), shipped)

    def test_without_all_components_are_refused(self, tiny, tmp_path):
        part = tmp_path / "part.h5"
        prune(tiny.path, TINY.with_changes({"domain": {"components": ["u", "v"]}}), part)
        with pytest.raises(InputError, match="got components u, v, allowed: u, v, w, omega_x"):
            whole_table(str(part))
