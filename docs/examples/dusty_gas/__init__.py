"""A dusty gas flows past a cylinder or a sphere, with four models of the wall.

    python docs/examples/dusty_gas

follows corundum particles in a uniform stream past a blunt body, as flow codes do, and lets them
rebound as spheres, as non-spherical particles simulated at every hit, and by draws from a table.
Those simulated keep their spin and their grain from hit to hit ("direct"), or are at every hit
another particle without spin ("memoryless"). A table with the law of particles that arrive spinning
is given the spin before each hit, and holds the law of the first; any other table that of the
second. It lives beside the tests because it compares `sampler` with `tablegen`, and the first never
imports the second. `walls.table_rebound` is all that a flow code needs.

What it assumes: steady potential flow of an incompressible gas round the body, no boundary layer
and no wake; few particles, so that neither the gas nor other particles feel them; spherical drag
(Stokes, with the correction of Schiller and Naumann) for every wall model; no gravity, no Magnus
force; between hits the gas brakes the spin as that of a sphere in Stokes flow, and a particle's
orientation at a hit is random; particles hit with their centre.

Units of the tracker: body radius R, stream speed U, time R/U. The stream moves along +x, the
centre of the body is the origin, the axis of the cylinder is z.
"""
