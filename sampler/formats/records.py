"""The records of the interface: the one description that all languages follow.

`tools/generated_code.py` writes the records of C, of Fortran and of devices; ctypes and
numba make theirs from here. Callers fill them by name in C and in Fortran.
"""

from typing import NamedTuple

#: What a field is: an array that must be given, one that may be NULL, one for results, or numbers
#: in the record itself.
REQUIRED, OPTIONAL, RESULT, NUMBER = "required", "optional", "result", "number"


class Field(NamedTuple):
    """One field of a record.

    Attributes
    ----------
    name : str
    role : str
        `REQUIRED`, `OPTIONAL`, `RESULT` or `NUMBER`.
    kind : str
        Type of the numbers in C.
    width : int
        How many of them a row of the array has, or the record itself.
    meaning : str
        A comment of the header.
    """

    name: str
    role: str
    kind: str
    width: int
    meaning: str


_INDEX = Field("index", REQUIRED, "uint64_t", 1, "Identities of the particles. Required.")
_HIT = Field("hit", REQUIRED, "uint32_t", 1,
    "Number of walls that each particle has met before. Required.")  # fmt: skip

#: The records by the name that follows ``rbt_`` in C.
RECORDS = {
    "conditions": (
        Field("alpha1", REQUIRED, "double", 1,
            "Impact angles from the wall, rad, above 0, at most pi/2. Required."),
        Field("speed", REQUIRED, "double", 1, "Impact speeds V, m/s, above 0. Required."),
        Field("spin", OPTIONAL, "double", 3,
            "Angular velocities before the impact, times a/V, 3 n. NULL: the law of first "
            "impacts, of particles of any grain that do not spin."),
        Field("inertia", OPTIONAL, "double", 1,
            "Inertias k about the spin, over m a^2. NULL or 0: not known."),
        Field("grain", OPTIONAL, "double", 3,
            "Prescribed grains, 3 n. NULL: the grains of the keys. Grains without `spin` do not "
            "spin, and are drawn from the spin law."),
        _INDEX,
        _HIT,
        Field("inertia_after", RESULT, "double", 1,
            "Written: inertias k after the rebound; 0 by the law of first impacts. NULL: not "
            "wanted."),
        Field("fresh", NUMBER, "int", 1,
            "1: another grain at each hit. 0: particles keep their grains."),
    ),
    "impacts": (
        Field("velocity", REQUIRED, "double", 3,
            "Velocities of the particles at the contact, m/s, 3 n. Required."),
        Field("normal", REQUIRED, "double", 3,
            "Normals from the wall into the gas, 3 n, of any length but 0. Required."),
        Field("half_size", REQUIRED, "double", 1,
            "Largest half-sizes a, 1e-9 to 100 m. Required."),
        Field("wall_velocity", OPTIONAL, "double", 3,
            "Velocities of the walls at the contact, m/s, 3 n. NULL: walls at rest."),
        Field("omega", OPTIONAL, "double", 3,
            "Mean angular velocities before the impact, rad/s, 3 n. NULL: zeros."),
        Field("inertia", OPTIONAL, "double", 1,
            "Inertias k about omega, over m a^2. NULL or 0: not known."),
        Field("roughness", OPTIONAL, "double", 1,
            "Standard deviations of the tilt of facets, 0 to 0.5 rad. NULL: smooth walls."),
        Field("grain", OPTIONAL, "double", 3,
            "Prescribed grains, 3 n. NULL: the grains of the keys."),
        _INDEX,
        _HIT,
        Field("fresh", NUMBER, "int", 1,
            "1: another grain at each hit. From smooth walls, without omega and grain, it is "
            "drawn from the law of first impacts; a table without a spin law has no other. 0: "
            "particles keep their grains."),
        Field("isotropic", NUMBER, "int", 1,
            "1: facets are tilted across the plane of incidence as well. 0: they are tilted in "
            "that plane only."),
    ),
    "rebounds": (
        Field("velocity", RESULT, "double", 3, "Velocities after the rebound, m/s, 3 n."),
        Field("omega", RESULT, "double", 3,
            "Mean angular velocities after the rebound, rad/s, 3 n."),
        Field("inertia", RESULT, "double", 1,
            "Inertias k about omega, over m a^2; 0 by the law of first impacts."),
        Field("works", RESULT, "double", 2,
            "Energies that the impulses along the normal and along the wall take, J for each kg "
            "of the particle, 2 n. If the table has no works, RBT_ERR_NO_WORKS."),
        Field("codes", RESULT, "int", 1, "Codes of the rows, n."),
        Field("bad", NUMBER, "size_t", 1, "Written: number of rows with an error."),
        Field("first_bad", NUMBER, "size_t", 1,
            "Written: the first row with an error; n if there is none."),
        Field("flagged", NUMBER, "size_t", 8,
            "Written: in place k the number of rows with the flag 1 << k."),
    ),
}  # fmt: skip


def argument_arrays(record: str) -> tuple[str, ...]:
    """List the arrays that a record takes, in the order of the record."""
    return tuple(f.name for f in RECORDS[record] if f.role in (REQUIRED, OPTIONAL))
