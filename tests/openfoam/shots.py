"""The wall case: parcels shot at floor and moving lid of a box, in OpenFOAM and in Python."""

from dataclasses import dataclass

import foam_files
import foam_run
import numpy as np
from first_hits import CONDITIONS, DIAMETER, HALF_SIZE, SEED, states_of
from free_flight import fly

IS_NORMAL = np.array([alpha == np.pi / 2 for alpha, _ in CONDITIONS])
DENSITY = 3950.0
MASS = DENSITY * np.pi / 6 * DIAMETER**3
#: Angular momentum over angular velocity of a colliding parcel: OpenFOAM's sphere.
SPHERE = 0.1 * MASS * DIAMETER**2
#: Velocities [m/s] of floor and lid, their normals into the gas, and their heights [m].
WALL_VELOCITY = np.array([[0.0, 0.0, 0.0], [30.0, 0.0, 10.0]])
NORMAL = np.array([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]])
HEIGHT = np.array([0.0, 0.4])
END_TIME = 1e-3
#: Corners of the box [m].
LOWER, UPPER = np.array([-0.4, 0.0, -0.4]), np.array([0.4, 0.4, 0.4])
#: Velocity [m/s] of the whole box in "colliding-moving", as in its dynamicMeshDict.
BOX_VELOCITY = np.array([0.0, 20.0, 0.0])
SOLVERS = {
    "kinematic": "uncoupledKinematicParcelFoam",
    "colliding": "icoUncoupledKinematicParcelFoam",
    "colliding-moving": "icoUncoupledKinematicParcelDyMFoam",
}


@dataclass(frozen=True)
class Shots:
    """Parcels before their impact: index into `CONDITIONS`, wall (0 floor, 1 lid), m and m/s."""

    condition: np.ndarray
    wall: np.ndarray
    position: np.ndarray
    velocity: np.ndarray


def make_shots(count, plane=False, seed=1):
    """Make `count` parcels of each condition at each wall, which meet it once within `END_TIME`.

    In a plane case they move in the plane z = 0.
    """
    rng = np.random.default_rng(seed)
    condition = np.repeat(np.arange(len(CONDITIONS)), 2 * count)
    wall = np.tile(np.repeat([0, 1], count), len(CONDITIONS))
    n = condition.size
    alpha, speed = np.array(CONDITIONS)[condition].T
    azimuth = rng.uniform(0.0, 2.0 * np.pi, n)
    if plane:
        azimuth = np.pi * rng.integers(0, 2, n)
    # exactly none at normal impact, else the direction along the wall would be rounding noise
    along = np.where(IS_NORMAL[condition], 0.0, speed * np.cos(alpha))
    velocity = WALL_VELOCITY[wall] * ([1, 1, 0] if plane else [1, 1, 1])
    velocity = velocity - (speed * np.sin(alpha))[:, None] * NORMAL[wall]
    velocity[:, 0] += along * np.cos(azimuth)
    velocity[:, 2] += 0.0 if plane else along * np.sin(azimuth)
    depth = np.zeros(n) if plane else rng.uniform(-0.1, 0.1, n)
    target = np.column_stack([rng.uniform(-0.1, 0.1, n), HEIGHT[wall], depth])
    flight = rng.uniform(0.2, 0.8, n) * END_TIME
    return Shots(condition, wall, target - flight[:, None] * velocity, velocity)


def run_shots(work, folder, shots, cloud="colliding", processors=1, edits=(), end="0.001"):
    """Run the wall case; return the parcels' fields at its end, and the solver's log.

    `edits`: changes to the case, (file, old text, new text). Fields: U (m/s), hits, omega (rad/s)
    and inertia (over m a^2), as of `read_cloud`.
    """
    case = foam_run.copy_case("wall", folder, work)
    for change in edits:
        foam_run.edit(case, *change)
    foam_run.run(work, case, "blockMesh")
    foam_files.write_cloud(case, shots.position, shots.velocity, DIAMETER, DENSITY)
    if processors > 1:
        foam_run.run(work, case, "decomposePar")
        # decomposePar writes coordinates, but links the entry that says positions
        foam_run.edit(case, foam_files.GEOMETRY, "positions", "coordinates")
    log = foam_run.run(work, case, SOLVERS[cloud], processors=processors)
    return read_fields(case, end, cloud), log


def read_fields(case, time, cloud="colliding"):
    """Fields of the parcels of a case, as `run_shots` returns them."""
    kept_in = "UTurb" if cloud == "kinematic" else "angularMomentum"
    fields = foam_files.read_cloud(case, time, ["U", "dTarget", kept_in])
    fields["omega"] = fields.pop(kept_in) / (1.0 if cloud == "kinematic" else SPHERE)
    fields["inertia"], fields["hits"] = np.modf(fields.pop("dTarget"))
    return fields


def rebound(table, velocity, normal, **given):
    """Let `Table.rebound` compute rebounds of the grains of these parcels."""
    return table.rebound(velocity, normal, HALF_SIZE, seed=SEED, **given)


def first_rebound(table, shots):
    """Draw in Python for the first wall of each parcel: velocity, omega and inertia after it."""
    return rebound(
        table,
        shots.velocity,
        NORMAL[shots.wall],
        index=np.arange(len(shots.velocity)),
        hit=0,
        wall_velocity=WALL_VELOCITY[shots.wall],
    )


def states(shots, fields):
    """Return states (n, 6) in the frame of each impact, from the files of OpenFOAM."""
    wall, straight = WALL_VELOCITY[shots.wall], IS_NORMAL[shots.condition]
    before, after = shots.velocity - wall, fields["U"] - wall
    return states_of(before, NORMAL[shots.wall], after, fields["omega"], straight)


def replay(table, started, end, spin=True, roughness=None, isotropic=False, **flight):
    """Follow parcels through the box in Python; arguments and result as of `free_flight.fly`.

    Without `spin` they come to each wall without the one that they have.
    """

    def at_wall(rows, normal, velocity, omega, inertia, hits):
        wall = WALL_VELOCITY[(normal[:, 1] < 0.0).astype(int)]
        given = {"omega": omega, "inertia": inertia} if spin else {}
        given |= {"wall_velocity": wall, "roughness": roughness, "isotropic": isotropic}
        return rebound(table, velocity, normal, index=rows, hit=hits, **given)

    start, box = (started.position, started.velocity), (LOWER, UPPER)
    return fly(start, end, box, at_wall, **flight)
