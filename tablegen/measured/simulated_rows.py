"""Direct simulation of measured rows: rebounds of each shape at given impact conditions."""

import math
from typing import Any

import numpy as np

from sampler.arguments import MAX_ROUGHNESS, as_integer
from sampler.limits import Bounds
from tablegen.config.config import Config
from tablegen.measured.moments import SimulatedMoments, mixed_moments, variables_of
from tablegen.model.float_array import FloatArray
from tablegen.model.model_bounds import HALF_SIZE
from tablegen.parallel import in_threads
from tablegen.progress import bar
from tablegen.simulation.direct import model_without_warnings
from tablegen.simulation.simulate import check_impact_angle, check_run

#: Standard deviation of the tilt of facets.
WALL_TILT_DEG = Bounds(0.0, math.degrees(MAX_ROUGHNESS), " degrees")


class SimulatedRows:
    """Rebounds of each shape of a population at each of n impact conditions, the rows.

    The random numbers are common: a particle is keyed by (seed, row, shape, number), whatever the
    laws, the aspect ratios and the weights. So moments change smoothly with those.

    Facets of a rough wall are drawn as by `sampler.Table.rebound` with ``roughness``, and moments
    refer to the mean wall. Angles (n,) are in degrees from the wall, speeds (n,) in m/s.
    """

    def __init__(
        self,
        config: Config,
        alpha_deg: FloatArray,
        speed: FloatArray,
        *,
        seed: int,
        wall_tilt_deg: float = 0.0,
        threads: int | None = None,
    ) -> None:
        tilt = WALL_TILT_DEG.checked("wall_tilt_deg", wall_tilt_deg)
        self._roughness = min(math.radians(tilt), MAX_ROUGHNESS)
        self._alpha_deg, self._speed = np.asarray(alpha_deg, dtype=np.float64), speed
        self._alpha = [check_impact_angle(a, "alpha_deg") for a in np.radians(self._alpha_deg)]
        self._shapes = config.population.strata()
        self._models = [model_without_warnings(config, shape.population) for shape in self._shapes]
        self._seed, self._threads = seed, threads

    def moments(self, count: int, progress: bool = False) -> SimulatedMoments:
        """Simulate means and spreads, with ``count`` particles of each shape at each row."""
        as_integer("count", count, 2, 2**32 - 1, "2 to 2**32 - 1")
        workers = check_run(count, self._seed, 0, self._threads)
        rebounds_of_row = count * len(self._shapes)
        total = rebounds_of_row * len(self._alpha)
        with bar(progress, "rebound", total=total, unit_scale=True, desc="simulating") as counted:
            rows = in_threads(
                lambda row: self._row_moments(row, count),
                range(len(self._alpha)),
                lambda finished: counted.update(finished * rebounds_of_row),
                workers,
            )
        return SimulatedMoments.from_rows(rows)

    def _row_moments(self, row: int, count: int) -> FloatArray:
        """Simulate the moments at a row."""
        parts = [self._simulate_variables(row, shape, count) for shape in range(len(self._shapes))]
        shares = [stratum.share for stratum in self._shapes]
        return mixed_moments(parts, shares, float(self._alpha_deg[row]))

    def _simulate_variables(self, row: int, shape: int, count: int) -> FloatArray:
        """Simulate the variables (count, 5) of a shape at a row."""
        # each row and shape has indices of its own, whatever the other rows and shapes are
        first = (self._shapes[shape].code << 48) + (row << 32)
        index = np.arange(first, first + count, dtype=np.uint64)
        keys: dict[str, Any] = {"seed": self._seed, "index": index, "threads": 1}
        model, alpha, speed = self._models[shape], self._alpha[row], self._speed[row]
        if self._roughness == 0.0:
            return variables_of(model.sample(alpha, speed, **keys))
        velocity = speed * np.array([math.cos(alpha), -math.sin(alpha), 0.0])
        normal = (0.0, 1.0, 0.0)
        after = model.rebound(velocity, normal, HALF_SIZE, roughness=self._roughness, **keys)
        return variables_of(np.hstack([after.velocity, after.omega * HALF_SIZE]) / speed)
