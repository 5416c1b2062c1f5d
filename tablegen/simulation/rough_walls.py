"""Direct rebounds from rough walls: from facet to facet until a particle leaves.

The facets are those that `tablegen.model.roughness` draws with the same keys. A bounce begins with
the spin and the inertia after the one before, and all bounces of a hit have one grain. As a table
does, a bounce draws the phases of the tumbling anew, by its keys: both have one law.
"""

import numpy as np

from sampler.errors import CASCADE_NOT_ENDED
from tablegen.model.roughness import MAX_BOUNCES, facet_normals, mark_leaving, seed_of_bounce
from tablegen.simulation.direct_impacts import (
    OWN,
    DirectArrays,
    DirectImpacts,
    DirectResults,
    Failure,
)
from tablegen.simulation.smooth_walls import smooth_rebounds


def rough_rebounds(arrays: DirectArrays, impacts: DirectImpacts, results: DirectResults) -> None:
    """Rebound particles from rough walls, and write their results; raises `Failure`.

    Every impact on the mean wall must be possible. The code is 0 for a particle that never leaves a
    facet.
    """
    count = len(results.states)
    impacts.conditions(count, arrays.numerics)
    seed, wall_velocity = impacts.seed, np.broadcast_to(impacts.wall_velocity, (count, 3))
    going = impacts._replace(
        # relative to the wall
        velocity=np.array(np.broadcast_to(impacts.velocity - impacts.wall_velocity, (count, 3))),
        wall_velocity=np.zeros((1, 3)),
        made_at=OWN[:0],
        grain=impacts.grains(count, arrays.population),
    )
    rows = np.arange(count)
    for bounce in range(MAX_BOUNCES):
        # compiled code takes an int of Python for a signed number
        going = going._replace(seed=np.uint64(seed_of_bounce(seed, bounce)))
        after = DirectResults.empty(len(rows))
        try:
            smooth_rebounds(arrays, _on_facets(going, len(rows)), after)
        except Failure as failure:
            raise Failure(int(rows[failure.row]), failure.code) from None
        results.states[rows], results.inertia[rows] = after.states, after.inertia
        leaving = np.empty(len(rows), dtype=np.bool_)
        mark_leaving(after.states, going.normal, leaving)
        results.states[rows[leaving], :3] += wall_velocity[rows[leaving]]
        stays = np.flatnonzero(~leaving)
        if len(stays) == 0:
            return
        rows = rows[stays]
        going = going.of(stays)._replace(
            velocity=after.states[stays, :3].copy(),
            omega=after.states[stays, 3:].copy(),
            inertia=after.inertia[stays],
        )
    raise Failure(int(rows[0]), CASCADE_NOT_ENDED)


def _on_facets(impacts: DirectImpacts, count: int) -> DirectImpacts:
    """Draw the facet that each particle meets: smooth walls in place of the rough ones."""
    facets, wall = np.empty((count, 3)), (impacts.normal, impacts.roughness, impacts.across)
    facet_normals(impacts.velocity, *wall, impacts.keys, facets)
    return impacts._replace(normal=facets)
