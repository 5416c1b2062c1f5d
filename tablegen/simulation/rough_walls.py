"""Direct simulation of rough walls: particles bounce from facet to facet until they leave.

`tablegen.model.roughness` draws the facets. A bounce begins with the spin and the inertia after the
bounce before, and all bounces of a hit have the same grain. Each bounce draws the phases of the
tumbling by its own keys, as a table does.
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

    Each impact must be allowed on the mean wall. The code of the failure is 0 if a particle never
    leaves a facet.
    """
    count = len(results.states)
    impacts.conditions(count, arrays.numerics)
    seed, wall_velocity = impacts.seed, np.broadcast_to(impacts.wall_velocity, (count, 3))
    going = impacts._replace(
        # velocities are relative to the wall from here on
        velocity=np.array(np.broadcast_to(impacts.velocity - impacts.wall_velocity, (count, 3))),
        wall_velocity=np.zeros((1, 3)),
        grain_hits=OWN[:0],
        grain=impacts.grains(count, arrays.population),
    )
    rows = np.arange(count)
    for bounce in range(MAX_BOUNCES):
        # converted, because compiled code takes a Python int for a signed number
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
        going = going.select(stays)._replace(
            velocity=after.states[stays, :3].copy(),
            omega=after.states[stays, 3:].copy(),
            inertia=after.inertia[stays],
        )
    raise Failure(int(rows[0]), CASCADE_NOT_ENDED)


def _on_facets(impacts: DirectImpacts, count: int) -> DirectImpacts:
    """Replace the normal of the rough wall by that of the smooth facet that each particle meets."""
    facets, wall = np.empty((count, 3)), (impacts.normal, impacts.roughness, impacts.across)
    facet_normals(impacts.velocity, *wall, impacts.keys, facets)
    return impacts._replace(normal=facets)
