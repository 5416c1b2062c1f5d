"""A small table with made-up numbers: valid in every respect, and quick to make."""

import numpy as np
from scipy.special import ndtr

from sampler.formats.channels import CHANNELS, STATE
from sampler.formats.hdf5 import TableContents

ALPHA_DEG = np.array([20.0, 50.0, 90.0])
SPEED = np.array([50.0, 120.0, 300.0])
N_KNOTS, N_COMPONENTS = 65, 5
#: First component of each class at node (i, j) is FIRST_OF_CLASS[(i + j) % 2].
FIRST_OF_CLASS = ((0, 2), (0, 3))
VARIATE_MAX = 4.0
AXES = [f"axes/alpha_{part}" for part in ("deg", "span_deg", "coordinate")]
AXES += [f"axes/speed{part}" for part in ("", "_span", "_coordinate")]
HALF = 2048  # a probability of reflection of 1/2, as it is stored


def _axis(nodes, power, n_grid=101):
    """Nodes, ends, and number of the node at equal steps, from an abscissa that is not linear."""
    nodes = np.asarray(nodes, dtype=float)
    grid = np.linspace(nodes[0], nodes[-1], n_grid)
    sign = np.sign(power)  # np.interp wants a growing abscissa
    x = np.interp(sign * grid**power, sign * nodes**power, np.arange(len(nodes)))
    x[0], x[-1] = 0.0, len(nodes) - 1
    return nodes, nodes[[0, -1]], x


def channel_quantiles(probability, i, j, kind=0):
    """Smooth quantile functions (6, ...) of the channels of a class at node (i, j), three odd.

    Probabilities are those of all channels, or (6, ...), those of each.
    """
    p = np.broadcast_to(probability, (6, *np.shape(probability)[-1:]))
    a = 0.1 * i + 0.03 * j + 0.12 * kind
    odd = 2.0 * p - 1.0
    return np.array(
        [
            0.02 + (0.9 - a) * p[0] ** (1.5 - 0.5 * kind),
            -0.7 + a + 1.3 * p[1] ** 2,
            -2.0 + a + 2.5 * p[2],
            (0.4 + a) * odd[3],
            (0.5 + 0.5 * a) * (odd[4] + odd[4] ** 3),
            (1.5 + a) * odd[5],
        ]
    )


def _mixture(rng, n_components):
    """Weights, means and covariances of a mixture whose pooled covariance is about one."""
    weight = rng.dirichlet(np.full(n_components, 4.0))
    mean = 0.6 * rng.standard_normal((n_components, 6))
    mean -= weight @ mean
    root = rng.standard_normal((n_components, 6, 6)) / np.sqrt(6.0)
    return weight, mean, 0.5 * root @ root.transpose(0, 2, 1) + 0.1 * np.eye(6)


def _mirrored(weight, mean, covariance, share):
    """The mixture with a share of each component reflected, as one mixture of twice as many."""
    flip = np.diag([1.0, 1, 1, -1, -1, -1])
    return (
        np.concatenate(((1.0 - share) * weight, share * weight)),
        np.concatenate((mean, mean @ flip)),
        np.concatenate((covariance, flip @ covariance @ flip)),
    )


def _probabilities(weight, mean, covariance, knots):
    """Distribution functions of the mixture's own marginals, shape (6, n_knots)."""
    sd = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    z = (knots[:, None, None] - mean) / sd
    return np.einsum("k,mkc->cm", weight, ndtr(z))


def _alias(weight):
    """Alias table by Vose's method."""
    n = len(weight)
    share, index = weight * n, np.arange(n)
    probability = np.ones(n)
    small = [k for k in range(n) if share[k] < 1.0]
    large = [k for k in range(n) if share[k] >= 1.0]
    while small and large:
        low, high = small.pop(), large.pop()
        probability[low], index[low] = share[low], high
        share[high] -= 1.0 - share[low]
        (small if share[high] < 1.0 else large).append(high)
    return probability, index


def class_parts(first_of_class, n_components):
    """Components of each class, as slices."""
    ends = [*first_of_class[1:], n_components]
    return [slice(a, b) for a, b in zip(first_of_class, ends, strict=True)]


def make_datasets(seed=1, alpha_deg=ALPHA_DEG, speed=SPEED, standard=False, reflection=HALF):
    """Datasets by path.

    With ``standard`` there is one class, and its mixture is one correlated normal law with standard
    marginals. Else there are two classes of several components. Either way the marginals at the
    nodes are `channel_quantiles`.
    """
    rng = np.random.default_rng(seed)
    shape = (len(alpha_deg), len(speed))
    knots = np.linspace(-VARIATE_MAX, VARIATE_MAX, N_KNOTS)
    n, n_classes = (1, 1) if standard else (N_COMPONENTS, 2)
    quantiles = np.empty((*shape, n_classes, 6, N_KNOTS))
    first_of_class = np.zeros((*shape, n_classes), dtype=np.int64)
    probability, index = np.empty((*shape, n)), np.empty((*shape, n), dtype=np.int64)
    mean, cholesky = np.empty((*shape, n, 6)), np.empty((*shape, n, 21))
    for i, j in np.ndindex(*shape):
        weight, centre, covariance = _mixture(rng, n)
        if standard:
            sd = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
            centre, covariance = 0.0 * centre, covariance / (sd[:, :, None] * sd[:, None, :])
            # Reflection at random removes correlations between the two halves: leave none.
            covariance[:, :3, 3:] = covariance[:, 3:, :3] = 0.0
        else:
            first_of_class[i, j] = FIRST_OF_CLASS[(i + j) % 2]
        for kind, part in enumerate(class_parts(first_of_class[i, j], n)):
            own = weight[part] / weight[part].sum(), centre[part], covariance[part]
            p = _probabilities(*_mirrored(*own, reflection / 4096.0), knots)
            quantiles[i, j, kind] = channel_quantiles(p, i, j, kind)
        probability[i, j], index[i, j] = _alias(weight)
        mean[i, j] = centre
        cholesky[i, j] = np.linalg.cholesky(covariance)[:, *np.tril_indices(6)]
    return {
        **dict(zip(AXES, (*_axis(alpha_deg, 0.5), *_axis(speed, -0.5)), strict=True)),
        "marginals/variate_knots": knots,
        "marginals/quantiles": quantiles,
        "dependence/first_of_class": first_of_class,
        "dependence/alias_probability": np.minimum(np.rint(probability * 65536), 65535).astype(int),
        "dependence/alias_index": index,
        "dependence/reflection": np.full((*shape, n), reflection),
        "dependence/mean": np.rint(mean * 4096.0).astype(np.int16),
        "dependence/cholesky": np.rint(cholesky * 4096.0).astype(np.int16),
        "accuracy/alpha_deg": np.array([33.0, 71.0]),
        "accuracy/speed": np.array([80.0, 200.0]),
        "accuracy/ks": np.full((2, 6), 0.01),
        "accuracy/sliced_wasserstein": np.array([0.004, 0.005]),
        "accuracy/correlation_error": np.array([0.01, 0.02]),
        "accuracy/auc": np.array([0.55, 0.56]),
    }


def make_contents(datasets=None, **changes):
    """Valid contents, with datasets or attributes changed."""
    attributes = {
        "pair": "made-up",
        "config": 'name = "made-up"\n',
        "seed": 2**64 - 1,
        "software_version": "0.0-test",
        "variables": STATE,
        "channels": CHANNELS[:6],
        "speed_independent": False,
        "least_inertia": 0.0,
    }
    return TableContents(datasets=datasets or make_datasets(), **(attributes | changes))


def table_of(variables, channels, alpha, speed, knots, quantiles, **dependence):
    """Contents with other arrays; an axis has nodes, the ends of its range and its coordinate."""
    datasets = make_datasets() | {f"dependence/{name}": x for name, x in dependence.items()}
    datasets |= dict(zip(AXES, (*alpha, *speed), strict=True))
    datasets |= {"marginals/variate_knots": knots, "marginals/quantiles": quantiles}
    datasets["accuracy/ks"] = np.full((2, len(variables)), 0.01)
    return make_contents(datasets, variables=tuple(variables), channels=tuple(channels))
