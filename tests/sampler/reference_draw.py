"""The draw once more, in plain Python, from its description and not from the kernels."""

import math

import numpy as np
from scipy.special import ndtri

MASK = 0xFFFFFFFF


def philox(key, counter):
    """Philox4x32-10 on Python integers."""
    k, c = list(key), list(counter)
    for _ in range(10):
        p, q = 0xD2511F53 * c[0], 0xCD9E8D57 * c[2]
        c = [(q >> 32) ^ c[1] ^ k[0], q & MASK, (p >> 32) ^ c[3] ^ k[1], p & MASK]
        k = [(k[0] + 0x9E3779B9) & MASK, (k[1] + 0xBB67AE85) & MASK]
    return c


def key_words(seed, index, hit, n_blocks=2):
    """Words of the first blocks of the keys of a rebound."""
    words = []
    for block in range(n_blocks):
        counter = (index & MASK, index >> 32, hit, block)
        words += philox((seed & MASK, seed >> 32), counter)
    return words


def _axis(value, nodes, coordinate):
    """Lower node and weight of the next."""
    grid = np.linspace(nodes[0], nodes[-1], len(coordinate))
    x = np.interp(value, grid, coordinate) if len(nodes) > 1 else 0.0
    lower = max(min(math.floor(x), len(nodes) - 2), 0)
    return lower, x - lower


def reference_draw(contents, alpha1, speed, words):
    """State (6,) from eight words."""
    w = [int(word) for word in words]
    i0, t = _axis(alpha1, np.deg2rad(contents["axes/alpha_deg"]), contents["axes/alpha_coordinate"])
    j0, r = _axis(speed, contents["axes/speed"], contents["axes/speed_coordinate"])

    c = ((w[1] >> 1) + 0.5) / 2**31
    up_alpha = c < t
    c = c / t if up_alpha else (c - t) / (1.0 - t)
    i, j = i0 + up_alpha, j0 + (c < r)

    probability = contents["dependence/alias_probability"][i, j]
    column, low = divmod(w[0] * len(probability), 2**32)
    if (low + 0.5) / 2**32 >= probability[column]:
        column = contents["dependence/alias_index"][i, j, column]

    factor = np.zeros((6, 6))
    factor[np.tril_indices(6)] = contents["dependence/cholesky"][i, j, column] / 4096.0
    normals = ndtri((np.array(w[2:8]) + 0.5) / 2**32)
    z = contents["dependence/mean"][i, j, column] / 4096.0 + factor @ normals
    if contents.mirror and w[1] & 1:
        z[3:] *= -1.0

    kind = int(np.sum(column >= contents["dependence/first_of_class"][i, j].astype(int))) - 1
    variate_knots = contents["dependence/variate_knots"]
    score_knots = contents["marginals/score_knots"]
    channels = np.zeros(6)
    for k in range(6):
        s = np.interp(z[k], variate_knots, contents["dependence/scores"][i, j, kind, k])
        for a, weight_a in ((i0, 1.0 - t), (i0 + 1, t)):
            for b, weight_b in ((j0, 1.0 - r), (j0 + 1, r)):
                if weight_a * weight_b > 0.0:
                    quantiles = contents["marginals/quantiles"][a, b, kind, k]
                    channels[k] += weight_a * weight_b * np.interp(s, score_knots, quantiles)
    v, u_hat, omega_z, w_hat, omega_x, omega_y = channels
    u = u_hat * math.sqrt(1.0 - v**2)
    return np.array([u, v, w_hat * math.sqrt(1.0 - v**2 - u**2), omega_x, omega_y, omega_z])
