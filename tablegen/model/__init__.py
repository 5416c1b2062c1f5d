"""The direct model of a rebound: numba kernels on floats and arrays, nothing else.

collision   one collision, equations (1)-(7) of the paper
shapes      vertices, moments of inertia, support function
rotation    free rotation of an asymmetric body as a Taylor series
contact     when and where a free particle next touches the wall
rebound     a whole rebound: collisions and flights until the particle has left
audit       every law checked on every collision and flight
population  random shape, aspect ratios and orientation
batch       many particles at one condition
"""
