"""The executable specification of the draw: plain Python, from the stored file.

It follows section "A draw" of tables/FORMAT.md step by step and shares nothing with the kernels but
the names of the channels. `contents` is a table as `sampler.formats.hdf5.read_table` reads it. The
normal quantile function is exact and the stored quantiles are taken as they are, in double
precision throughout, so states agree with those of the kernels to 1e-5 and half a 16-bit step of a
quantile; their bits are those of tests/vectors.
"""

import math

import numpy as np
from scipy.special import ndtri

from sampler.formats.channels import CHANNELS

MASK = 0xFFFFFFFF


def philox(key, counter):
    """Philox4x32-10 on Python integers."""
    k, c = list(key), list(counter)
    for _ in range(10):
        p, q = 0xD2511F53 * c[0], 0xCD9E8D57 * c[2]
        c = [(q >> 32) ^ c[1] ^ k[0], q & MASK, (p >> 32) ^ c[3] ^ k[1], p & MASK]
        k = [(k[0] + 0x9E3779B9) & MASK, (k[1] + 0xBB67AE85) & MASK]
    return c


def key_words(seed, index, hit, n_blocks=3):
    """Words of the first blocks of the keys of a rebound."""
    words = []
    for block in range(n_blocks):
        counter = (index & MASK, index >> 32, hit, block)
        words += philox((seed & MASK, seed >> 32), counter)
    return words


def _axis(value, nodes, span, coordinate):
    """Lower node and weight of the next."""
    if len(nodes) == 1:
        return 0, 0.0
    x = np.interp(value, np.linspace(*span, len(coordinate)), coordinate)
    x -= round(np.interp(nodes[0], np.linspace(*span, len(coordinate)), coordinate))
    lower = max(min(math.floor(x), len(nodes) - 2), 0)
    return lower, min(max(x - lower, 0.0), 1.0)


def _corner(word, t, r):
    """Which of the four nodes a word chooses: (upper angle, upper speed)."""
    c = ((word >> 12) + 0.5) / 2**20
    shares = [(1.0 - t) * (1.0 - r), (1.0 - t) * r, t * (1.0 - r)]
    return divmod(int(np.searchsorted(np.cumsum(shares), c, side="right")), 2)


def reference_channels(contents, alpha1, speed, words):
    """Channels by name: steps 1 to 5, from the words of blocks 0, 1 and 2."""
    w = [int(word) for word in words]
    # 1. cell and weights
    angles, ends = (np.deg2rad(contents[f"axes/alpha_{name}"]) for name in ("deg", "span_deg"))
    i0, t = _axis(alpha1, angles, ends, contents["axes/alpha_coordinate"])
    speeds, ends = contents["axes/speed"], contents["axes/speed_span"]
    j0, r = _axis(speed, speeds, ends, contents["axes/speed_coordinate"])
    # 2. node
    up_alpha, up_speed = _corner(w[1], t, r)
    i, j = i0 + up_alpha, j0 + up_speed

    # 3. component
    probability = contents["dependence/alias_probability"][i, j]
    column, low = divmod(w[0] * len(probability), 2**32)
    if low >> 16 >= probability[column]:
        column = contents["dependence/alias_index"][i, j, column]

    # 4. variates
    n = len(contents.channels)
    factor = np.zeros((n, n))
    factor[np.tril_indices(n)] = contents["dependence/cholesky"][i, j, column] / 4096.0
    normals = ndtri((np.array(w[2:8] + w[9:11])[:n] + 0.5) / 2**32)
    z = contents["dependence/mean"][i, j, column] / 4096.0 + factor @ normals
    if w[1] % 4096 < contents["dependence/reflection"][i, j, column]:
        z *= [
            -1.0 if name in ("w_hat", "omega_x", "omega_y") else 1.0 for name in contents.channels
        ]

    # 5. quantile functions of the class, averaged over the cell
    kind = int(np.sum(column >= contents["dependence/first_of_class"][i, j].astype(int))) - 1
    knots = contents["marginals/variate_knots"]
    channels = dict.fromkeys(CHANNELS, 0.0)
    for k, name in enumerate(contents.marginals):
        variate = z[contents.channels.index(name)]
        for a, weight_a in ((i0, 1.0 - t), (i0 + 1, t)):
            for b, weight_b in ((j0, 1.0 - r), (j0 + 1, r)):
                if weight_a * weight_b > 0.0:
                    quantiles = contents["marginals/quantiles"][a, b, kind, k]
                    channels[name] += weight_a * weight_b * np.interp(variate, knots, quantiles)
    return channels


def reference_draw(contents, alpha1, speed, words):
    """State in the order of the table's variables, from the words of blocks 0, 1 and 2."""
    c = reference_channels(contents, alpha1, speed, words)
    u = c["u_hat"] * math.sqrt(1.0 - c["v"] ** 2)
    w = c["w_hat"] * math.sqrt(1.0 - c["v"] ** 2 - u**2)
    values = {**c, "u": u, "w": w, "collisions": math.floor(c["collisions"])}
    values["rotational_energy"] = c["energy_hat"] * (1.0 - c["v"] ** 2 - u**2 - w**2)
    return np.array([values[name] for name in contents.variables])
