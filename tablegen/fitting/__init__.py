"""From simulated rebounds to the arrays of a table, of the sizes in resolution.

First impacts: node (one condition), components (classes of rebounds), marginals (quantile
functions), mixture (dependence).

Spin law: spin_law (all of it), law_conditions (impacts to fit), spin_coordinates (the numbers that
are fitted), tree and leaf (parts of the domain), experts, expectation and spin_scores (the mixture
of experts in a leaf).
"""
