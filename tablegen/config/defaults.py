"""Choices and defaults that the command line shares with the library.

They lie here, where nothing is imported, so that a help page need not load what does the work.
"""

#: Name of the non-spherical shapes together, with the weights of the population.
MIXTURE = "mixture"

#: Conditions at which a new table is measured, and those of a validation.
GENERATE_CONDITIONS = 8
VALIDATE_CONDITIONS = 8

#: The same of a spin law.
GENERATE_SPIN_CONDITIONS = 24
VALIDATE_SPIN_CONDITIONS = 24

#: Particles of a case of the stability study.
STABILITY_COUNT = 16

#: Particles of each shape at each angle of the paper's figures.
FIGURES_COUNT, FIGURES_QUICK_COUNT = 200_000, 20_000

#: Particles of each shape at each measured condition of a calibration.
CALIBRATE_COUNT = 4000

#: Particles of each shape at each condition, in a comparison with measurements.
COMPARE_COUNT = 20_000
