"""The shapes of particles by name; nothing is imported here, for help pages list them."""

#: Code of each shape, in kernels and in files. Files written before must keep their meaning: a new
#: shape takes the next number that is free, and none changes.
SHAPE_CODES = {
    "ellipsoid": 0,
    "prism": 1,
    "truncated-prism": 2,
    "tetrahedron": 3,
    "sphere": 4,
    "mesh": 5,
}

#: Shapes that a population may hold by name; meshes it holds besides.
SHAPE_NAMES = tuple(name for name in SHAPE_CODES if name != "mesh")

#: Mesh number k of a population is FIRST_MESH + k, above all other codes.
FIRST_MESH = 1 + max(SHAPE_CODES.values())
