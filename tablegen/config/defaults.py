"""Choices and defaults shared by the command line and the library; importing this loads nothing."""

#: Name of the non-spherical shapes and the meshes together, with the weights of the population.
MIXTURE = "mixture"

#: Number of conditions at which each law of a table is measured.
VALIDATE_CONDITIONS = 8

#: Particles of one case of the stability study.
STABILITY_COUNT = 16

#: Particles under one law of Coulomb friction in the stability study; the quick one has 5 %.
STABILITY_FRICTION = 20_000

#: Grains of each kind in the chains of hits of the stability study; the quick one has a tenth.
STABILITY_GRAINS = 1_000

#: Particles of each shape at each condition of a comparison with measurements.
COMPARE_COUNT = 20_000
