"""Names of the components, where nothing is imported: help pages show them."""

#: Components of a state, in the order of every public array and file.
COMPONENTS = ("u", "v", "w", "omega_x", "omega_y", "omega_z", "rotational_energy", "collisions")

#: Components that every table has unless its scene says otherwise: u to omega_z.
STATE = COMPONENTS[:6]
