"""Made-up simulations and outcomes for tests of the stability study."""

import numpy as np
from tablegen.evidence.cases import Case
from tablegen.evidence.outcome import Change, Figures, Outcome
from tablegen.evidence.stability_study import Study

from tablegen.model.audit import AUDIT_SIZE
from tablegen.simulation.simulate import Simulation

CASE = Case("prism", (0.5, 0.02), 20.0, 200.0, -5.0)


def simulation(count=4, audited=True, **changes):
    """Rebounds that keep every law; ``changes`` replace arrays."""
    state = np.tile([0.6, 0.3, 0.01, 0.1, -0.2, -0.4], (count, 1))
    arrays = {
        "state": state,
        "collisions": np.arange(1, count + 1),
        "shape": np.ones(count, dtype=np.int64),
        "aspect": np.tile(CASE.aspect, (count, 1)),
        "energy": np.tile([0.5, 0.2], (count, 1)),
        "work": np.tile([0.2, 0.1], (count, 1)),
        "audit": np.zeros(AUDIT_SIZE if audited else 0),
    }
    return Simulation(**(arrays | changes))


def figures(**changes):
    """Figures of a case that is well; ``changes`` replace some."""
    well = {
        "growth": 0.0,
        "residual": 1e-15,
        "drift": 1e-11,
        "depth": 2e-12,
        "least_velocity": 0.1,
        "most_collisions": 3,
        "mean_collisions": 1.5,
        "contact": Change(1e-6, 1e-5),
        "flight": Change(1e-9, 1e-8),
    }
    return Figures(**(well | changes))


def outcome(case=CASE, *, measured=None, **changes):
    """Outcome of a case that is well; ``changes`` replace fields."""
    well = {
        "case": case,
        "seed": 7,
        "extrapolated": False,
        "particles": 4,
        "non_finite": 0,
        "unfinished": 0,
        "figures": figures() if measured is None else measured,
        "cost": 2e-6,
    }
    return Outcome(**(well | changes))


def study(*outcomes):
    """Study with these outcomes."""
    return Study("corundum-steel", 1e-3, 1e-10, 1, 4, outcomes)
