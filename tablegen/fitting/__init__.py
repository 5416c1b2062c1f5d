"""Fit the law of a table to simulated rebounds.

A table has two laws, and each is a mixture of normal laws in the normal scores of its numbers, with
quantile functions that turn scores back into numbers. ``docs/method.md`` explains the method,
``tables/FORMAT.md`` has the formulae of a draw, and ``EXPERIMENTS.md`` in this folder has what was
tried and measured. Read it before you change a size or a constant.

First impacts: one law at each node, a pair of angle and speed
--------------------------------------------------------------
====================  ==============================================================================
file                  what it does
====================  ==============================================================================
node                  begin here: simulates a node, fits it, and rounds it as a file stores it
components            divides rebounds into two classes, and components between the classes
marginals             normal scores of a sample, and the quantile functions of its channels
mixture               a Gaussian mixture, fitted by expectation-maximisation
====================  ==============================================================================

The spin law: one law for all angles, speeds, spins and grains, divided into leaves
-----------------------------------------------------------------------------------
====================  ==============================================================================
file                  what it does
====================  ==============================================================================
spin_law              begin here: the tasks of the fit, and the datasets of the law
law_conditions        draws the impacts to which the law is fitted
spin_coordinates      the inputs and the outcomes that are fitted, from impacts and rebounds
tree                  divides the conditions into leaves
leaf                  fits one leaf, rounds it as a file stores it, and makes its quantiles
experts               a mixture of linear regressions, fitted by expectation-maximisation
expectation           the kernels of this fit and of that of the mixture
tile_products         sums of products in vector registers, for these kernels
rounding              rounds coefficients together, so that their sums change little
spin_scores           draws scores from a rounded leaf, for its quantiles
====================  ==============================================================================

``resolution`` has the sizes of both laws for each preset of the accuracy.

If you change
-------------
- the numbers of a rebound or of a condition: change `spin_coordinates`, the draw in
  ``sampler/c/src`` (conditions.h, outcomes.h) and ``tests/sampler/reference_draw.py`` together;
- what a node or a leaf stores: change `NodeArrays` or `LeafArrays`, whose fields are datasets of
  `sampler.formats.layout`;
- anything else here: the format stays, and `tablegen validate` tells whether tables are better.

Everything is a function of the configuration and its seed, so tables can be made again.
"""
