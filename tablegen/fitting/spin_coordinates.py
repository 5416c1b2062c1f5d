"""Compute the numbers that the spin law is fitted to: inputs from conditions, outcomes of rebounds.

A grain arrives with the spin s = a Omega / V and the inertia k about it, over m a^2. Its energy is
m V^2 / 2 times E = 1 + k |s|^2. The rebound divides E between translation, rotation and the wall.

A grain that rolls along a wall hardly changes at a rebound, so outcomes are changes. They are
counted at a *nominal contact*, which lies straight towards the wall, at half the sum of the least
and the largest distance from the centre that the grain has while it turns (`Contact`). A force at
this contact changes a part g of the motion, in proportion to the velocity of the contact, and
leaves the rest d. The outcomes o say where d moves, in units of the share of the energy that is at
the contact, and the outcomes p how the contact and the wall divide what is left. Any values are
possible: whatever a table draws, the grain gains no energy, leaves the wall, and has an inertia
that it may have.

Units: angles in rad, speeds in m/s, spins in V/a, inertias over m a^2, energies over m V^2 / 2.
Docstrings name the formulae; `tables/FORMAT.md` has them once more, in the order of a draw.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import DTypeLike, NDArray

from sampler.formats.bounds import (
    END_OF_KAPPA,
    EQUAL_MOMENTS,
    FOLD,
    LEAST_LEFT,
    LEAST_REST,
    LEAST_TAKEN,
    LEAST_TILT,
    LEAST_WOBBLE,
    N_CONDITIONS,
    N_DIRECTIONS,
    N_FEATURES,
    N_INPUTS,
    PLACE_CORE,
    RATIOS,
    RISE,
    ROUND_CORE,
    SPIN_CORE,
    TILT_CORE,
    WOBBLE,
)
from sampler.formats.shape_codes import SHAPE_CODES
from tablegen.model.float_array import FloatArray
from tablegen.simulation.impact_chains import Impacts

#: Sizes of the spin over V/a that a law covers.
SPIN_RANGE = (0.0, 10.0)

#: Signs under reflection in the impact plane: of the first seven outcomes, and of the inputs.
OUTCOME_SIGNS = np.array([1.0, 1.0, -1.0, -1.0, -1.0, 1.0, 1.0])
INPUT_SIGNS = np.array([1.0, 1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 1.0, 1.0, -1.0, -1.0, 1.0, 1.0])

#: Column of sigma_x among the inputs.
_SIGMA_X = 2

#: Pairs of inputs whose products are features.
_PAIRS = np.triu_indices(N_INPUTS)


class SpeedCoordinate(NamedTuple):
    """The coordinate exp(-coefficient x^exponent) of a speed x in m/s."""

    coefficient: float
    exponent: float
    #: Largest effective speed of the law [m/s]; contacts that are faster count as this fast.
    largest: float

    def transform(self, speed: FloatArray) -> FloatArray:
        """Compute the coordinate of speeds [m/s]."""
        return np.exp(-self.coefficient * np.minimum(speed, self.largest) ** self.exponent)


class Moments(NamedTuple):
    """Largest and smallest moments of inertia of n grains over m a^2, (n,) each."""

    largest: FloatArray
    smallest: FloatArray

    @property
    def differ(self) -> NDArray[np.bool_]:
        """Whether the two moments of each grain differ, (n,)."""
        return np.asarray(self.largest - self.smallest > EQUAL_MOMENTS * self.largest)


def kappa_from_inertia(inertia: FloatArray, moments: Moments) -> FloatArray:
    """Compute the place kappa of inertias k between the moments J of their grains, (n,).

    With q = (1 / J_smallest - 1 / k) / (1 / J_smallest - 1 / J_largest),

        kappa = sqrt(q) / (sqrt(q) + sqrt(1 - q)).

    kappa is 0 for a grain that turns about its longest axis, 1 for one that turns about its
    shortest axis, and 1/2 if both moments are equal. Near 0 and near 1 it changes in proportion to
    the angle between spin and axis.
    """
    high, low = 1.0 / moments.smallest, 1.0 / moments.largest
    span = np.where(moments.differ, high - low, 1.0)
    place = np.clip((high - 1.0 / inertia) / span, 0.0, 1.0)
    return np.where(moments.differ, kappa_from_place(place), 0.5)


def kappa_from_place(place: FloatArray) -> FloatArray:
    """Compute kappa from the place q, from 0 to 1, of a reciprocal inertia between its ends."""
    first, second = np.sqrt(place), np.sqrt(1.0 - place)
    return first / (first + second)


def inertia_from_kappa(kappa: FloatArray, moments: Moments) -> FloatArray:
    """Compute the inertias over m a^2 at places kappa from 0 to 1, (n,)."""
    place = kappa**2 / (kappa**2 + (1.0 - kappa) ** 2)
    high, low = 1.0 / moments.smallest, 1.0 / moments.largest
    return np.where(moments.differ, 1.0 / (high - place * (high - low)), moments.largest)


class Contact(NamedTuple):
    """Nominal contacts of n grains, and their motion before the impact; fields are (n,)."""

    #: Place kappa of the inertia about the spin; 1/2 without a spin.
    kappa: FloatArray
    #: Distance of the contact from the centre, over a.
    distance: FloatArray
    #: Root of the inertia about the spin; without a spin, that of the mean of both moments.
    root_inertia: FloatArray
    #: Energy E.
    energy: FloatArray
    #: Speed q of the contact over V, and its part along the plane of the impact.
    speed: FloatArray
    slip: FloatArray
    #: Size of the spin; distance A from a motion in the plane of the impact; whether this plane is
    #: taken for a mirror of the grain.
    spin: FloatArray
    tilt: FloatArray
    mirrored: NDArray[np.bool_]
    #: (n, 3): the point e from which outcomes o count; (n,): their unit.
    base: FloatArray
    o_unit: FloatArray
    #: Unit of p_v, and part of p_u that p_w has if the contact slides as before.
    rise: FloatArray
    slide: FloatArray
    #: Rebounds of spheres from which outcomes p count, if they do.
    sphere: "Sphere | None" = None


class Sphere(NamedTuple):
    """Rebounds of spheres, from which those of ellipsoids count; fields are (n,)."""

    #: Velocities u and v over V after the impact, and the energy W that the wall takes.
    along: FloatArray
    away: FloatArray
    taken: FloatArray
    #: Units of the outcome p_v, and of p_u and p_w.
    v_unit: FloatArray
    side_unit: FloatArray


def nominal_contact(impacts: Impacts, moments: Moments) -> Contact:
    """Compute the nominal contacts of impacts.

    With kappa of the inertia k about the spin s, b and c of the grain over a, the contact lies at

        rho = (b + c)/2 + kappa (1 - c)/2,

    and its distance scatters by epsilon, while the grain turns, with

        epsilon^2 = [(1 - b)^2 kappa^2 + (b - c)^2 (1 - kappa)^2
                     + WOBBLE kappa (1 - kappa) (1 - c)^2]/2 + LEAST_WOBBLE.

    Its speed over V is q^2 = (cos a + rho s_z)^2 + (rho s_x)^2 + sin^2 a + epsilon^2 |s|^2. Without
    a spin kappa is 1/2.

    A grain that turns about its shortest axis, which lies across the impact, stays in the plane of
    the impact if this plane is a mirror of the grain. From such a motion it is away by

        A = ((s_x^2 + s_y^2)/|s|^2 + `LEAST_TILT`^2)^(1/2) + 1 - kappa,

    and the outcomes p_w, o_x and o_y of ellipsoids with a spin, which leave the plane, are in units
    of A. They count from the motion before the impact: o_x and o_y from the whole of it, and p_w
    from lambda p_u, the value that it has if the contact slides as before, with
    lambda = -(cos a + rho s_z) rho s_x/q^2. Grains of other shapes are thrown out of the plane by
    their corners.

    The outcome p_v of these ellipsoids is in units of (sin^2 a + `RISE` epsilon^2 |s|^2)^(1/2)/q,
    because at a small angle a rolling grain rises as fast as the distance of its contact changes.
    """
    b, c = impacts.grain[:, 1], impacts.grain[:, 1] * impacts.grain[:, 2]
    spin = np.linalg.norm(impacts.spin, axis=1)
    spins = spin > 0.0
    inertia = np.where(spins, impacts.inertia, 0.5 * (moments.largest + moments.smallest))
    kappa = np.where(spins, kappa_from_inertia(inertia, moments), 0.5)
    rest = 1.0 - kappa
    distance = 0.5 * (b + c) + 0.5 * kappa * (1.0 - c)
    square = ((1.0 - b) * kappa) ** 2 + ((b - c) * rest) ** 2 + WOBBLE * kappa * rest * (1 - c) ** 2
    slip = np.cos(impacts.alpha1) + distance * impacts.spin[:, 2]
    towards, scatter = np.sin(impacts.alpha1) ** 2, (0.5 * square + LEAST_WOBBLE) * spin**2
    speed = slip**2 + (distance * impacts.spin[:, 0]) ** 2 + towards + scatter
    energy = 1.0 + inertia * spin**2
    root = np.sqrt(inertia)
    across = np.square(impacts.spin[:, :2]).sum(axis=1) / np.where(spins, spin, 1.0) ** 2
    tilt = np.sqrt(across + LEAST_TILT**2) + rest
    mirrored = spins & (impacts.grain[:, 0] == SHAPE_CODES["ellipsoid"])
    contact = Contact(
        *(kappa, distance, root, energy, np.sqrt(speed), slip, spin, tilt, mirrored),
        base=np.empty(0),
        o_unit=np.minimum(1.0, np.sqrt(speed / energy)),
        rise=np.where(mirrored, np.sqrt((towards + RISE * scatter) / speed), 1.0),
        slide=np.where(mirrored, -slip * distance * impacts.spin[:, 0] / speed, 0.0),
    )
    velocity = np.column_stack(
        [np.cos(impacts.alpha1), np.sin(impacts.alpha1), np.zeros_like(spin)]
    )
    _, before = _parts(velocity, root[:, None] * impacts.spin, contact)
    kept = np.repeat((1.0 - contact.o_unit**2)[:, None], 3, axis=1)
    kept[mirrored, :2] = 1.0
    return contact._replace(base=kept * before / np.sqrt(energy)[:, None])


def beside_sphere(contact: Contact, impacts: Impacts, after: FloatArray) -> Contact:
    """Count the outcomes of ellipsoids without spin from the rebounds of spheres.

    An ellipsoid with the ratio c of its shortest to its longest axis is out of round by
    r = min(1, 2 (1 - c) + `ROUND_CORE`). A sphere leaves the same impact with u_s and v_s, is
    slowed down by D = cos a - u_s, and loses the energy

        W = (sin a - v_s)(sin a + v_s) + D (2 cos a - 7/2 D)

    to the wall, or `LEAST_TAKEN` of what it keeps, if this is more. Then outcomes o count from
    e = -(1 - r)(0, 0, cos a sin f), in units of r min(1, sin a + v_s + 2 D), outcomes p_v in units
    of r (sin a + v_s + 2 D)/sqrt(W), and p_u and p_w in units of
    r (2 D + r (sin a + v_s)/10)/sqrt(W).

    Parameters
    ----------
    contact : Contact
    impacts : Impacts
        Impacts without spin.
    after : (n, 2) float64
        Velocities u_s and v_s over V.
    """
    u, v, (along, away) = np.cos(impacts.alpha1), np.sin(impacts.alpha1), after.T
    ratio = impacts.grain[:, 1] * impacts.grain[:, 2]
    out_of_round = np.minimum(1.0, 2.0 * (1.0 - ratio) + ROUND_CORE)
    slower, normal = u - along, v + away
    taken = (v - away) * normal + slower * (2.0 * u - 3.5 * slower)
    taken = np.maximum(taken, LEAST_TAKEN * (along * along + away * away))
    shear, per_p = 2.0 * slower, out_of_round / np.sqrt(taken)
    sine = contact.distance / np.hypot(contact.root_inertia, contact.distance)
    zeros = np.zeros_like(u)
    return contact._replace(
        base=np.column_stack([zeros, zeros, (out_of_round - 1.0) * u * sine]),
        o_unit=out_of_round * np.minimum(1.0, normal + shear),
        sphere=Sphere(
            along,
            away,
            taken,
            per_p * (normal + shear),
            per_p * (shear + 0.1 * out_of_round * normal),
        ),
    )


def impact_inputs(
    impacts: Impacts, moments: Moments, contact: Contact, speed: SpeedCoordinate
) -> FloatArray:
    """Compute the inputs of impacts, and their directions, (n, 13).

    The inputs are sqrt(alpha1), the coordinate of the speed V q of the contact, three numbers of
    the vector sigma, the slip (cos alpha1 + rho s_z)/q,
    log((kappa + PLACE_CORE)/(1 - kappa + PLACE_CORE)), sqrt(1 - b/a) and sqrt(1 - c/b). The roots
    spread grains that are nearly round, whose rebounds change quickly with the ratios. The vector

        sigma = s (SPIN_CORE / |s| + (1 + |s|^2)^(-1/4))

    has the direction of the spin s. Its size begins at `SPIN_CORE`, because the law depends on the
    direction of even the slowest spin. It grows in proportion to a small spin, and with the root of
    a large one, on which the law depends less. Its numbers are
    sigma_x / sqrt(|sigma_x| + TILT_CORE), the same of sigma_y, and sigma_z: a grain that rolls
    along its path has s_z alone, and leaves rolling by tilts of its spin of a few hundredths, which
    the roots spread.

    The directions are s_x/(|s| A), s_y/(|s| A), (1 - kappa)/A and
    sin a/(sin^2 a + `RISE` epsilon^2 |s|^2)^(1/2) of ellipsoids with a spin, and 0 of others: the
    outcomes in units of A depend on the first three, however small A is, and p_v on the last one.
    """
    size, kappa = contact.spin, contact.kappa
    core = SPIN_CORE / np.where(size > 0.0, size, 1.0)
    sigma = impacts.spin * (core + 1.0 / np.sqrt(np.sqrt(1.0 + size * size)))[:, None]
    sigma[:, :2] /= np.sqrt(np.abs(sigma[:, :2]) + TILT_CORE)
    per_tilt = contact.mirrored / contact.tilt
    directions = impacts.spin[:, :2] * (per_tilt / np.where(size > 0.0, size, 1.0))[:, None]
    towards = contact.mirrored * np.sin(impacts.alpha1) / (contact.rise * contact.speed)
    return np.column_stack(
        [
            np.sqrt(impacts.alpha1),
            speed.transform(impacts.speed * contact.speed),
            sigma,
            contact.slip / contact.speed,
            np.log((kappa + PLACE_CORE) / (1.0 - kappa + PLACE_CORE)),
            np.sqrt(1.0 - impacts.grain[:, 1:]),
            directions,
            (1.0 - kappa) * per_tilt,
            towards,
        ]
    )


def choose_reflected(inputs: FloatArray, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Choose the conditions that are fitted as their mirror images, (n,), as a draw does.

    Conditions with a negative input of sigma_x are reflected, so that the law is fitted once for
    both signs. Within `FOLD` of 0 the choice is random: the law would otherwise jump at 0.
    """
    keep_probability = 0.5 + inputs[:, _SIGMA_X] * (0.5 / FOLD)
    return np.asarray(rng.random(len(inputs)) >= keep_probability)


def reflect(values: FloatArray, is_reflected: NDArray[np.bool_], signs: FloatArray) -> FloatArray:
    """Reflect some rows of inputs or outcomes in the impact plane.

    Parameters
    ----------
    values : (n, d) float64
    is_reflected : (n,) bool
    signs : (d,) float64
        `INPUT_SIGNS` for inputs, `OUTCOME_SIGNS` for outcomes.
    """
    return np.where(is_reflected[:, None], values * signs, values)


def rebound_outcomes(
    states: FloatArray, inertia: FloatArray, moments: Moments, contact: Contact
) -> FloatArray:
    """Compute the outcomes p, o and kappa of rebounds, (n, 7).

    With (c_u, c_v, c_w) the velocity over V, y the spin times the root of the inertia about it, and
    tan f = rho / sqrt(k) before the impact, a motion has the parts

        g = (c_u cos f + y_z sin f, c_v, c_w cos f - y_x sin f),
        d = (c_w sin f + y_x cos f, y_y, y_z cos f - c_u sin f).

    Before the impact |g|^2 + |d|^2 = E. After it (d', R) with R = E - |d'|^2 is a point of a sphere
    in four dimensions, Y' = (sqrt(R), d')/sqrt(E). It is seen from Y = (Y_0, (1 - Q^2) d/sqrt(E))
    of size 1, where Q = min(1, q/sqrt(E)): a grain whose whole energy is at the contact begins from
    rest, and one that rolls from where it is. In the tangential space at Y,

        o = 2 tan(theta/2)/Q in the direction of Y', theta the angle between Y and Y',
        p = g'/sqrt(R - |g'|^2),

    where p_v, p_w, o_x and o_y of ellipsoids with a spin are over their units
    (`nominal_contact`). The last outcome compares the odds of kappa' after the impact with those
    before. With the share S = min(1, q/(sqrt(k) |s|)) of the rotation that the contact has, and
    delta = S A,

        h = log(kappa' (1 - kappa + delta) / ((1 - kappa') (kappa + delta))) / U,
        U = delta / (kappa (1 - kappa) + delta).

    The contact turns the spin by about delta against the grain. Near an axis of the grain this
    angle is what is left of the angle between spin and axis, so U is 1; far from the axes the
    odds change in proportion to it.

    Parameters
    ----------
    states : (n, 6) float64
        Velocities over V, and angular velocities times a/V, after the rebound.
    inertia : (n,) float64
        Inertias about the spin after the rebound, over m a^2.
    moments : Moments
    contact : Contact
        Before the rebound.
    """
    energy = contact.energy[:, None]
    g, d = _parts(states[:, :3], np.sqrt(inertia)[:, None] * states[:, 3:], contact)
    left = np.maximum(energy - np.sum(d * d, axis=1)[:, None], LEAST_LEFT**2 * energy)
    loss = np.maximum(left - np.sum(g * g, axis=1)[:, None], LEAST_REST * left)
    after = np.hstack([np.sqrt(left), d]) / np.sqrt(energy)
    after /= np.linalg.norm(after, axis=1)[:, None]
    base, unit = contact.base, contact.o_unit[:, None]
    pole = np.sqrt(1.0 - np.sum(base * base, axis=1))[:, None]
    along = np.sum(base * after[:, 1:], axis=1)[:, None]
    ahead = pole * after[:, :1] + along
    side = after[:, 1:] - base * (after[:, :1] + along / (1.0 + pole))
    o = 2.0 * side / (np.maximum(1.0 + ahead, LEAST_LEFT) * unit)
    kappa = kappa_from_inertia(inertia, moments)
    kappa = np.clip(kappa, END_OF_KAPPA, 1.0 - END_OF_KAPPA)
    before, other, h_unit = _odds(contact)
    odds_ratio = kappa * other / ((1.0 - kappa) * before)
    p = g / np.sqrt(loss)
    unit = np.where(contact.mirrored, contact.tilt, 1.0)
    p[:, 2] = (p[:, 2] - contact.slide * p[:, 0]) / unit
    p[:, 1] /= contact.rise
    o[:, :2] /= unit[:, None]
    if contact.sphere:
        p = _beside_sphere(p, d, left[:, 0], contact, contact.sphere)
    return np.column_stack([p, o, np.log(odds_ratio) / h_unit])


def _beside_sphere(
    p: FloatArray, d: FloatArray, left: FloatArray, contact: Contact, sphere: Sphere
) -> FloatArray:
    """Count outcomes p from a sphere; ``left`` (n,) is R, and d (n, 3) is d'.

    With s = v_s/sqrt(W), and y = (p_v - s^2/p_v)/2 in units of p_v, the outcome p_v becomes
    y + sqrt(y^2 + 1). Outcomes p_u and p_w count from the g with which the grain, whatever d' is,
    has u_s and no w,

        b = ((u_s + d'_z sin f)/cos f, -d'_x tan f),

    over sqrt((R - b^2)/(1 + p_v^2)). If b^2 is more than R - min(W + v_s^2, R)/2, it is this.
    """
    v = np.maximum(p[:, 1], 1e-12)
    y = 0.5 * (v - sphere.away**2 / (sphere.taken * v)) / sphere.v_unit
    tangent = contact.distance / contact.root_inertia
    b_u = sphere.along * np.hypot(1.0, tangent) + d[:, 2] * tangent
    b_w = -d[:, 0] * tangent
    square = b_u * b_u + b_w * b_w
    most = left - 0.5 * np.minimum(sphere.taken + sphere.away**2, left)
    shorter = np.sqrt(np.minimum(1.0, most / np.maximum(square, 1e-300)))
    per_p = shorter * np.sqrt((1.0 + v * v) / (left - np.minimum(square, most)))
    size = np.abs(y) + np.sqrt(y * y + 1.0)
    return np.column_stack(
        [
            (p[:, 0] - per_p * b_u) / sphere.side_unit,
            np.where(y > 0.0, size, 1.0 / size),
            (p[:, 2] - per_p * b_w) / sphere.side_unit,
        ]
    )


def _parts(
    velocity: FloatArray, root_spin: FloatArray, contact: Contact
) -> tuple[FloatArray, FloatArray]:
    """Divide motions into the part g at the nominal contact and the part d, (n, 3) each."""
    root, rho = contact.root_inertia, contact.distance
    size = np.sqrt(root**2 + rho**2)
    cosine, sine = root / size, rho / size
    (c_u, c_v, c_w), (y_x, y_y, y_z) = velocity.T, root_spin.T
    return (
        np.column_stack([c_u * cosine + y_z * sine, c_v, c_w * cosine - y_x * sine]),
        np.column_stack([c_w * sine + y_x * cosine, y_y, y_z * cosine - c_u * sine]),
    )


def _odds(contact: Contact) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return kappa + delta and 1 - kappa + delta before the impact, and U (`rebound_outcomes`)."""
    turning, other = contact.root_inertia * contact.spin, 1.0 - contact.kappa
    delta = contact.tilt * np.minimum(1.0, contact.speed / np.maximum(turning, 1e-300))
    return contact.kappa + delta, other + delta, delta / (contact.kappa * other + delta)


def normal_work_outcome(works: FloatArray) -> FloatArray:
    """Compute the outcome a of normal and shear works (n, 2): the sixth root of the normal share.

    At grazing incidence the share is so small that its sixth root is easier to interpolate.
    """
    taken = works.sum(axis=1)
    share = np.divide(works[:, 0], taken, out=np.zeros_like(taken), where=taken > 0.0)
    return np.cbrt(np.sqrt(np.clip(share, 0.0, 1.0)))


def features(t: FloatArray, dtype: DTypeLike = np.float64) -> NDArray[Any]:
    """Compute the features of standardised inputs and of directions (n, 13): (n, 59) of a type.

    The features are 1, the inputs t_i, the products t_i t_j for i < j, t_i^2 - 1/2, and directions.
    """
    phi = np.empty((len(t), N_FEATURES), dtype=dtype)
    phi[:, 0], phi[:, 1 : 1 + N_INPUTS] = 1.0, t[:, :N_INPUTS]
    phi[:, -N_DIRECTIONS:] = t[:, N_INPUTS:]
    for column, (i, j) in enumerate(zip(*_PAIRS, strict=True), 1 + N_INPUTS):
        phi[:, column] = t[:, i] * t[:, j] - 0.5 * (i == j)
    return phi


def used_features(varies: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Find which of the 59 features are not constant, from which inputs and directions vary."""
    i, j = _PAIRS
    inputs, directions = varies[:N_INPUTS], varies[N_INPUTS:]
    return np.concatenate([[True], inputs, varies[i] & varies[j], directions])


#: Number of the axis |sigma|^2 of a tree: it follows the six inputs of the impact.
SPIN_AXIS = N_CONDITIONS
#: Number of the axis of a tree for each input; the ratios come last.
AXES = np.array([*range(N_CONDITIONS), *(N_CONDITIONS + 1 + k for k in range(len(RATIOS)))])
