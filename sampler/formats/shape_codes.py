"""The shapes of particles by name. Help pages list them, so this module imports nothing."""

#: Shapes that a population may hold by name, in the order of their codes. Files keep their
#: meaning: a new shape goes to the end, and none changes its place.
SHAPE_NAMES = ("ellipsoid", "prism", "truncated-prism", "tetrahedron", "sphere")

#: Code of each shape, in kernels and in files.
SHAPE_CODES = {name: code for code, name in enumerate(SHAPE_NAMES)}

#: Mesh number k of a population has the code FIRST_MESH + k.
FIRST_MESH = 64
