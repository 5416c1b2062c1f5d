"""The executable specification of the draw: plain Python, from the stored file.

It follows sections "A draw" and "The spin law" of tables/FORMAT.md step by step and shares nothing
with the kernels but the names of the channels. `contents` is a table as
`sampler.formats.hdf5.read_table` reads it. The normal quantile function is exact and the stored
quantiles are taken as they are, in double precision throughout, so states agree with those of the
kernels to 1e-5 and half a 16-bit step of a quantile; their bits are those of tests/vectors.
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
    normal = c["normal_hat"] ** 6 * (1.0 - c["v"] ** 2)
    u = c["u_hat"] * math.sqrt(1.0 - c["v"] ** 2 - normal)
    w = c["w_hat"] * math.sqrt(1.0 - c["v"] ** 2 - normal - u**2)
    left = 1.0 - c["v"] ** 2 - normal - u**2 - w**2
    # no more energy of rotation than is left, of the grain with the smallest moment of inertia
    turns = contents.least_inertia * sum(c[f"omega_{axis}"] ** 2 for axis in "xyz")
    for axis in "xyz":
        c[f"omega_{axis}"] *= math.sqrt((left + normal) / max(turns, left + normal))
    values = {**c, "u": u, "w": w, "collisions": math.floor(c["collisions"])}
    values["rotational_energy"] = c["energy_hat"] * left
    values |= {"work_normal": normal, "work_shear": left - values["rotational_energy"]}
    return np.array([values[name] for name in contents.variables])


def reference_grain(contents, seed, index, hit=0):
    """Grain of a particle: shape code, b/a and c/b, from its keys and the stored population."""
    words = key_words(seed ^ 0x53494D554C415445, index, hit, 2)
    u = (np.array(words) + 0.5) / 2**32
    weights = contents["spin/shape_weights"]
    drawn = np.flatnonzero(weights > 0.0)
    shares = np.cumsum(weights[drawn]) / weights.sum()
    row = drawn[min(int(np.sum(u[5] >= shares)), len(drawn) - 1)]
    code, ratios = int(contents["spin/shape_codes"][row]), []
    for k in range(2):
        mean, deviation, low, high = contents["spin/aspect"][k]
        drawn = mean + deviation * ndtri(low + u[k] * (high - low)) if deviation else mean
        own = code == 4 or code >= 64  # a sphere, a mesh
        bounded = min(max(drawn, 0.001), 1.0)
        ratios.append(contents["spin/ratio_range"][row, k, 0] if own else bounded)
    return code, *ratios


def reference_moments(contents, grain):
    """Smallest and largest moment of inertia of a grain over m a^2."""
    code, beta, gamma = grain
    row = list(contents["spin/shape_codes"]).index(code)
    g1, g3 = contents["spin/shape_inertia"][row]
    return g3 * beta**2 * (1.0 + gamma**2), g1 * (1.0 + beta**2)


def reference_kappa(inertia, least, most):
    """Place of an inertia between the moments of a grain: 0 at the smallest, 1 at the largest."""
    if most - least <= 1e-9 * most:
        return 0.5
    share = (1.0 / least - 1.0 / inertia) / (1.0 / least - 1.0 / most)
    share = min(max(share, 0.0), 1.0)
    return math.sqrt(share) / (math.sqrt(share) + math.sqrt(1.0 - share))


def reference_inertia(kappa, least, most):
    """Inertia of such a place."""
    if most - least <= 1e-9 * most:
        return most
    share = kappa**2 / (kappa**2 + (1.0 - kappa) ** 2)
    return 1.0 / (1.0 / least - share * (1.0 / least - 1.0 / most))


def _leaf(contents, row, condition):
    """Leaf of a condition in the tree of a shape: six numbers, the squared spin, and ratios."""
    node = int(contents["spin/roots"][row])
    while node >= 0:
        value = condition[contents["spin/node_axis"][node]]
        second = int(value >= contents["spin/node_cut"][node])
        node = int(contents["spin/node_child"][node, second])
    return -1 - node


def _chosen(logits, word):
    """Number that a word chooses, with weights that are exponentials of the logits."""
    sums = np.cumsum(np.exp(logits - logits.max()))
    share = (int(word) // 256 + 0.5) / 2**24 * sums[-1]
    return int(np.sum(share >= sums[:-1]))


def reference_before(contents, speed, spin, inertia, grain, words):
    """Spin, inertia, kappa, energy over m V^2 / 2 and effective speed of what arrives."""
    square, most_spin = sum(x * x for x in spin), contents["spin/spin_range"][1]
    spin = min(1.0, most_spin / math.sqrt(square)) * np.array(spin) if square else np.zeros(3)
    least, most = reference_moments(contents, grain)
    if not square:
        inertia, kappa = 0.5 * (least + most), 0.5
    elif inertia:
        inertia = min(max(inertia, least), most)
        kappa = reference_kappa(inertia, least, most)
    else:
        row = list(contents["spin/shape_codes"]).index(grain[0])
        quantiles = contents["spin/kappa_quantiles"][row]
        u = (int(words[11]) + 0.5) / 2**32
        kappa = np.interp(u, np.linspace(0.0, 1.0, quantiles.size), quantiles)
        inertia = reference_inertia(kappa, least, most)
        kappa = kappa if most - least > 1e-9 * most else 0.5
    energy = 1.0 + inertia * (spin @ spin)
    return spin, inertia, kappa, energy, speed * math.sqrt(energy)


def reference_contact(alpha, spin, inertia, kappa, grain):
    """Distance of the nominal contact, the square of its speed over V, and its slip over V."""
    b, c, rest = grain[1], grain[1] * grain[2], 1.0 - kappa
    distance = (b + c + kappa * (1.0 - c)) / 2.0
    wobble = ((1.0 - b) * kappa) ** 2 + ((b - c) * rest) ** 2 + 2.4 * kappa * rest * (1.0 - c) ** 2
    slip = math.cos(alpha) + distance * spin[2]
    speed = slip**2 + (distance * spin[0]) ** 2 + math.sin(alpha) ** 2
    return distance, speed + (wobble / 2.0 + 1e-6) * (spin @ spin), slip


def reference_moved(point, outcomes, share):
    """Point of the unit sphere in four dimensions to which outcomes move another point."""
    tangent = np.array(outcomes) * share / 2.0
    square = tangent @ tangent
    z = np.array([1.0 - square, *2.0 * tangent]) / (1.0 + square)
    pole = np.array([1.0, 0.0, 0.0, 0.0])
    half = pole + point
    return z - half * (half @ z) / (1.0 + point[0]) + 2.0 * point * z[0]


def _tabulated(table, angle, speed):
    """Value of a table of angles and speeds, and the numbers behind it."""
    n, m = int(table[0]), int(table[1])
    angles, speeds = table[2 : 2 + n], table[2 + n : 2 + n + m]
    values = np.reshape(table[2 + n + m : 2 + n + m + n * m], (n, m))
    return np.interp(speed, speeds, [np.interp(angle, angles, column) for column in values.T])


def reference_sphere(laws, alpha, speed):
    """Velocities u and v of a sphere after an impact without spin, and the energy W."""
    u, v, length = math.cos(alpha), math.sin(alpha), int(laws[7])
    least = laws[0] * min(1.0, v / 0.0087)
    away = max(_tabulated(laws[8 : 8 + length], alpha, speed) * v, least)
    c = _tabulated(laws[8 + length :], alpha, 1.0) * (v + away)
    along = u * (1.0 - c / (1.0 + 1.75 * c))
    taken = v**2 - away**2 + (u - along) * (2.0 * u - 3.5 * (u - along))
    return along, away, max(taken, 1e-3 * (along**2 + away**2))


def reference_p(p, sphere, out_of_round, velocity, d, left, slope):
    """Outcomes p of a grain by itself, from those that count from a sphere."""
    (along, away, taken), slower = sphere, velocity[0] - sphere[0]
    kick = velocity[1] + away + 2.0 * slower
    y = out_of_round * kick * (p[1] - 1.0 / p[1]) / (2.0 * math.sqrt(taken))
    p_v = y + math.sqrt(y * y + away**2 / taken)
    b = np.array([along * math.hypot(1.0, slope) + d[2] * slope, -d[0] * slope])
    most = left - min(taken + away**2, left) / 2.0
    b *= min(1.0, math.sqrt(most / (b @ b)))
    unit = out_of_round * (2.0 * slower + out_of_round * (velocity[1] + away) / 10.0)
    side = b * math.sqrt((1.0 + p_v**2) / (left - b @ b)) + unit / math.sqrt(taken) * p[[0, 2]]
    return np.array([side[0], p_v, side[1]])


def reference_spin_draw(contents, alpha1, speed, spin, inertia, grain, words):
    """State of a particle that arrives spinning, works, and last the inertia about its spin.

    Steps 1 to 7 of "The spin law". `words` are those of blocks 0, 1 and 2 of the keys, `grain` a
    shape code, b/a and c/b, `inertia` that about the spin, 0 if it is not known. In double
    precision throughout: where a share falls next to the border between two experts, or a condition
    next to a cut, the kernels, in single precision, may choose the other.
    """
    w = [int(word) for word in words]
    # 1. condition
    alphas, speeds = np.deg2rad(contents["spin/alpha_range_deg"]), contents["spin/speed_range"]
    speed = min(speed, contents["axes/speed"][-1])
    before = reference_before(contents, speed, spin, inertia, grain, w)
    spin, inertia, kappa, energy, effective = before
    size = math.sqrt(spin @ spin)
    sigma = spin / size * (0.3 + size / (1.0 + size**2) ** 0.25) if size else np.zeros(3)
    tilts = sigma[:2] / np.sqrt(np.abs(sigma[:2]) + 0.02)
    side = (w[0] % 256 * 256 + w[1] % 256 + 0.5) / 2**16
    turn = 1.0 if side < 0.5 + 5.0 * tilts[0] else -1.0
    tilts, spin = turn * tilts, spin * [turn, turn, 1.0]
    alpha = min(max(alpha1, alphas[0]), alphas[1])
    effective = min(max(effective, speeds[0]), speeds[1])
    distance, square, slip = reference_contact(alpha, spin, inertia, kappa, grain)
    k, n = contents["spin/speed_coordinate"]
    fast = min(effective / math.sqrt(energy) * math.sqrt(square), speeds[1])
    place = math.log((kappa + 0.03) / (1.03 - kappa))
    q = [
        math.sqrt(alpha),
        math.exp(-k * fast**n),
        *tilts,
        sigma[2],
        slip / math.sqrt(square),
        place,
    ]
    roots = [math.sqrt(1.0 - ratio) for ratio in grain[1:]]
    # 2. leaf
    row = list(contents["spin/shape_codes"]).index(grain[0])
    leaf = _leaf(contents, row, [*q, sigma @ sigma, *roots])
    # 3. features
    t = (np.array([*q, *roots]) - contents["spin/centre"][leaf]) * contents["spin/scale"][leaf]
    products = [t[i] * t[j] - 0.5 * (i == j) for i in range(9) for j in range(i, 9)]
    across = (spin[0] ** 2 + spin[1] ** 2) / size**2 if size else 0.0
    tilt, mirrored = math.sqrt(across + 1e-6) + 1.0 - kappa, grain[0] == 0 and size
    scatter = square - slip**2 - (distance * spin[0]) ** 2 - math.sin(alpha) ** 2
    rise = math.sqrt(math.sin(alpha) ** 2 + 8.0 * scatter)
    directions = np.zeros(4)
    if mirrored:
        tilted = [*(spin[:2] / size), 1.0 - kappa]
        directions = np.array([*tilted, tilt * math.sin(alpha) / rise]) / tilt
    features = np.array([1.0, *t, *products, *directions])
    # 4. expert
    group = _chosen(features @ (contents["spin/group_gate"][leaf] / 512.0), w[0])
    within = _chosen(features @ (contents["spin/gate"][leaf, group] / 512.0), w[1])
    expert = group * contents["spin/gate"].shape[3] + within
    # 5. scores
    n = contents["spin/mean"].shape[-1]
    lower = np.zeros((n, n))
    lower[np.tril_indices(n)] = contents["spin/factor"][leaf, expert] / 4096.0
    z = features @ (contents["spin/mean"][leaf, expert] / 2048.0)
    normals = ndtri((np.array(w[2:8] + w[9:11])[:n] + 0.5) / 2**32)
    if group == 0:  # the slowest rebounds
        above = math.sqrt((normals[1] - 1.0) ** 2 + 2.5) - (normals[1] - 1.0)
        normals[1] = 15.146 - math.sqrt(196.0 + 3.0 * above**2)
    z = z + lower @ normals
    # 6. outcomes
    quantiles = contents["spin/quantiles"][leaf]
    knots = np.linspace(-6.0, 6.0, quantiles.shape[1])
    bounded = z / np.sqrt(1.0 + z * z / 36.0)
    x = np.array([np.interp(bounded[j], knots, quantiles[j]) for j in range(n)])
    # 7. state
    share = min(1.0, math.sqrt(square / energy))
    root, arm = math.sqrt(inertia), math.hypot(math.sqrt(inertia), distance)
    cosine, sine, y = root / arm, distance / arm, root * spin
    rest = np.array([y[0] * cosine, y[1], y[2] * cosine - math.cos(alpha) * sine])
    rest *= np.array([*[1.0 if mirrored else 1.0 - share**2] * 2, 1.0 - share**2])
    rest /= math.sqrt(energy)
    if mirrored:
        x[3:5] *= tilt
        x[1] *= rise / math.sqrt(square)
        x[2] = tilt * x[2] - slip * distance * spin[0] / square * x[0]
    sphere, out_of_round = None, min(1.0, 2.0 * (1.0 - grain[1] * grain[2]) + 0.02)
    if "spin/laws" in contents.datasets and grain[0] == 0 and not size:
        sphere = reference_sphere(contents["spin/laws"], alpha, effective)
        rest = np.array([0.0, 0.0, (out_of_round - 1.0) * math.cos(alpha) * sine])
        kick = math.sin(alpha) + sphere[1] + 2.0 * (math.cos(alpha) - sphere[0])
        share = out_of_round * min(1.0, kick)
    moved = reference_moved(np.array([math.sqrt(1.0 - rest @ rest), *rest]), x[3:6], share)
    left, rest = energy * moved[0] ** 2, math.sqrt(energy) * moved[1:]
    if sphere:
        velocity = math.cos(alpha), math.sin(alpha)
        x[:3] = reference_p(x[:3], sphere, out_of_round, velocity, rest, left, sine / cosine)
    loss = left / (1.0 + x[:3] @ x[:3])
    g = math.sqrt(loss) * x[:3]
    turning = root * math.sqrt(spin @ spin)
    part = min(1.0, math.sqrt(square) / turning) if turning else 1.0
    delta = part * tilt
    unit = delta / (kappa * (1.0 - kappa) + delta)
    first, second = math.exp(unit * x[6]) * (kappa + delta), 1.0 - kappa + delta
    after = reference_inertia(first / (first + second), *reference_moments(contents, grain))
    velocity = [g[0] * cosine - rest[2] * sine, g[1], g[2] * cosine + rest[0] * sine]
    y = np.array([rest[0] * cosine - g[2] * sine, rest[1], g[0] * sine + rest[2] * cosine])
    omega = y / math.sqrt(after)
    share = min(max(x[7], 0.0), 1.0) ** 6 if n > 7 else 0.0
    works = [share * loss, (1.0 - share) * loss] if n > 7 else []
    return np.array([*velocity * np.array([1, 1, turn]), *omega * [turn, turn, 1.0], *works, after])
