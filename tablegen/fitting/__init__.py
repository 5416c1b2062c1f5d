"""From simulated states to the arrays of one table node.

marginals   quantile functions of the channels, at knots in normal score
mixture     Gaussian mixture of the normal scores: the dependence
scores      normal scores of a sample; maps from the mixture's own marginals to scores
alias       alias tables for the mixture weights
axes        where the nodes are, and the look-up that finds them
node        one node: simulate, fit, pack
"""
