"""From simulated states to the arrays of one table node.

classes     the two classes of rebounds, and their shares of the mixture components
marginals   quantile functions of the channels, at knots in the mixture's variate
mixture     Gaussian mixture of the normal scores: the copula
scores      normal scores of a sample, and the distribution functions of a mixture's marginals
alias       alias tables for the mixture weights
resolution  particles, knots and mixture components of a node
node        one node: simulate, fit, pack
"""
