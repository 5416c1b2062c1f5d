"""Particles that hit walls again and again, with six models of the wall.

    python docs/examples/many_hits chains
    python docs/examples/many_hits bend
    python docs/examples/many_hits separator

compare what a flow code would get after several walls from direct simulation, from a table with and
without the spin before the hit, and from spheres (`models`). ``chains`` has no gas: all particles
hit one wall, or two opposite ones, at the same angle and speed at first, and go straight on
(`chains`). ``bend`` blows them through a bend of 90 degrees, and ``separator`` through two bends in
the shape of an S, behind each of which a splitter takes the outer part of the duct away (`duct`,
`flow`). What hits the walls of both is listed place by place (`wall_impacts`).

A program takes its rebounds from a table or from `tablegen.DirectModel` by the same call, so the
models differ in one line each. Here all particles are moved together, in arrays of numpy;
`dusty_gas` is the same with one particle at a time, in compiled code.

What the flows assume: a gas of constant density whose velocity is known by formula (`duct`), no
turbulence and no boundary layer; few particles; spherical drag (Schiller and Naumann) and the
viscous torque on a sphere; no gravity, no Magnus force; a random orientation at each hit; particles
hit with their centre. Lengths are in m, times in s, angles in rad.
"""
