"""Names of the variables of a state, where nothing is imported: help pages show them."""

#: Variables of a state, in the order of every public array and file.
VARIABLES = ("u", "v", "w", "omega_x", "omega_y", "omega_z", "rotational_energy", "collisions")

#: Variables that every table has unless its scene says otherwise: u to omega_z.
STATE = VARIABLES[:6]
