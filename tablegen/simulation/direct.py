"""A table whose law is direct simulation."""

from typing import Any, Literal

import numpy as np

from sampler.errors import InputError, value_text
from sampler.formats.channels import STATE
from sampler.table import Table
from tablegen.config.config import Config
from tablegen.config.population import Population
from tablegen.simulation.direct_law import DirectLaw, DirectParts


class DirectModel(Table):
    """A table whose law is direct simulation: each rebound is simulated instead of drawn.

    It has the methods, arguments, codes and counts of `sampler.Table`, and the same grains for the
    same keys. So it can replace a table in any program, and a chain of its rebounds is the direct
    simulation of a whole path. Equal keys give the states that the object of ``tablegen
    export-direct`` gives in C.

    Parameters
    ----------
    config : Config
        Configuration with laws, particles and numerical parameters, from `tablegen.load_config`.
    population : Population, optional
        Other particles than those of the configuration, for example
        ``config.population.restricted_to("prism")``.
    outside : {"clamp", "raise"}, optional
        What to do with impacts outside the range of `covered`, as for `sampler.Table`. A particle
        may turn by at most 1e6 rad before its first contact, ``2 |spin| / sin(alpha1)``; where it
        would turn by more, the angle counts as outside.

    Attributes
    ----------
    columns : tuple of str
        The variables in the columns of a state: u, v, w, omega_x, omega_y, omega_z. `rebound` gives
        works as well.
    content_sha256 : str
        Checksum of laws, particles and numerical parameters, hexadecimal.
    accuracy : dict of arrays
        Empty, because nothing is fitted.

    Raises
    ------
    InputError
        If an argument has a wrong type, or if the laws do not suit the particles.

    Notes
    -----
    Between walls a grain tumbles. Its angular momentum L and its rotational energy T are constant,
    and so are the mean angular velocity omega = (2T/L^2) L and the inertia about it, L^2 / (2T m
    a^2). These four numbers are passed to a rebound and returned by it.

    The keys draw the orientation in which a grain meets the next wall. An orientation is as likely
    as the share of time that a grain with these four numbers spends in it during free tumbling.
    That is right after a flight of a few turns (`tablegen.model.tumbling`). A grain without spin is
    oriented uniformly, and so is a grain with a spin whose inertia is not known.

    A grain may tumble around either end of an axis. For a mesh without symmetry the two ends
    differ, and the four numbers do not say which of them it is. One of them is drawn at each wall.

    A rebound that does not end, after 10**8 collisions, has the code `REBOUND_NOT_ENDED`.

    Examples
    --------
    Two grains hit a wall and then a second one. Their spin and inertia go from rebound to rebound:

    >>> import numpy as np
    >>> from tablegen import DirectModel, load_config
    >>> model = DirectModel(load_config("corundum-steel"))
    >>> velocity = np.array([[80.0, -60.0, 0.0], [80.0, -60.0, 0.0]])
    >>> keys = {"seed": 7, "index": [0, 1]}
    >>> first = model.rebound(velocity, [0.0, 1.0, 0.0], 1e-5, hit=0, **keys)
    >>> bool(np.all(first.velocity[:, 1] > 0.0))
    True
    >>> second = model.rebound(
    ...     first.velocity,
    ...     [0.0, -1.0, 0.0],
    ...     1e-5,
    ...     omega=first.omega,
    ...     inertia=first.inertia,
    ...     hit=1,
    ...     **keys,
    ... )
    >>> second.velocity.shape
    (2, 3)
    """

    def __init__(
        self,
        config: Config,
        population: Population | None = None,
        *,
        outside: Literal["clamp", "raise"] = "clamp",
    ) -> None:
        if not isinstance(config, Config):
            raise InputError("config", value_text(config), "a configuration of load_config")
        if not isinstance(population, Population | None):
            raise InputError("population", value_text(population), "a population, or None")
        self.config = config.text
        law = DirectLaw(DirectParts.from_config(config, population))
        self.pair, self.columns, self.has_spin = config.pair_name, STATE, True
        self.content_sha256, self.nbytes = law.parts.digest(), law.nbytes
        self.speed_independent = not config.pair.restitution.depends_on_speed
        self.shape_geometry = (population or config.population).shape_geometry()
        self._open(law, outside)
        self.alpha_nodes_deg = np.array(self.covered.alpha_deg)
        self.speed_nodes = np.array(self.covered.speed)
        self.accuracy: dict[str, Any] = {}

    def __repr__(self) -> str:
        return f"<tablegen.DirectModel {self.pair}: {self.covered}>"


def model_without_warnings(config: Config, population: Population | None = None) -> DirectModel:
    """Make a model that gives no warnings.

    It is for programs that simulate on purpose where the pair was not measured.
    """
    model = DirectModel(config, population)
    model._codes.warns = False
    return model
