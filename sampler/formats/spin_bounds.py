"""Numbers of the spin law that its file, its reader and its draw share.

Outcomes are (p_u, p_v, p_w, omega_x, omega_y, omega_z). The velocities over V_e are
p / sqrt(1 + |p|^2): whatever p is, the speed stays below V_e, and a positive p_v leaves the wall.
The angular velocities are times a/V_e.
"""

#: Conditions: sqrt(alpha1), the speed's coordinate, and the three components of a Omega / V_e.
N_CONDITIONS = 5
#: Conditions and the ratios b/a and c/b.
N_INPUTS = N_CONDITIONS + 2
#: 1, the inputs, and the products of two conditions.
N_FEATURES = 1 + N_INPUTS + N_CONDITIONS * (N_CONDITIONS + 1) // 2
N_OUTCOMES = 6
N_FACTORS = N_OUTCOMES * (N_OUTCOMES + 1) // 2

#: Largest moment of inertia of a body of mass 1 and half-size 1, and so the weight of the spin in
#: the effective speed V_e = V sqrt(1 + INERTIA |spin|^2): no particle can leave faster.
INERTIA = 2.0 / 3.0

#: Squared spin a Omega / V_e below which the root of a tree takes a particle not to spin.
NO_SPIN = 1e-12

#: Bound of the score zeta = z / sqrt(1 + z^2 / SCORE_MAX^2), where the quantiles end.
SCORE_MAX = 6.0

#: Numbers of a unit: coefficients of gates, those of means, and factors. As 16-bit integers they
#: are bounded, and with what the layout allows of inputs every draw is finite.
GATE_UNIT, MEAN_UNIT, FACTOR_UNIT = 512, 2048, 4096

#: Groups of a leaf, and experts of a group. The same in every law, so that the compiler knows how
#: many weights lie side by side; those that a leaf does not need have a weight of almost 0.
N_GROUPS, GROUP_SIZE = 8, 16
N_EXPERTS = N_GROUPS * GROUP_SIZE

#: Effective speeds, m/s.
SPEED = (1e-9, 1e9)

#: Closed interval of outcomes: far beyond what is physical, and squares of them are finite.
OUTCOME = (-1e6, 1e6)

#: Bounds of what a leaf subtracts from its inputs and multiplies them by, and of a tree's cuts.
MOST_MIDDLE, MOST_SCALE, MOST_CUT = 1e3, 1e4, 1e3

#: Coefficient and exponent of the speed's coordinate.
SPEED_COORDINATE = (1e-6, 1e3)

#: Most of k V_e^n, which single precision must hold.
MOST_SPEED_SCALE = 1e30

#: Smallest ratio of half-sizes.
LEAST_RATIO = 1e-3
