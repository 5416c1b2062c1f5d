"""The contact laws of a pair at a few angles and speeds, as a text to look at before generating."""

import math

from tablegen.config.config import Config
from tablegen.config.pairs import CoulombResistance, OrientationResistance
from tablegen.model.contact_laws import resistance, restitution
from tablegen.presentation import TextTable

#: Angles of the contact velocity from the wall [degrees].
_ANGLES = (10.0, 30.0, 45.0, 60.0, 90.0)


def law_text(config: Config) -> str:
    """Write restitution and resistance of a contact that is below the centre of the particle."""
    pair = config.pair
    law = pair.kernel_arguments(config.population.only_spheres)
    low, high = config.domain.speed
    speeds = [low, (low * high) ** 0.5, high] if pair.restitution.depends_on_speed else [high]
    speeds = list(dict.fromkeys(speeds))
    friction = isinstance(pair.resistance, CoulombResistance)
    head = ["angle", *(f"a_nc at {speed:.4g} m/s" for speed in speeds)]
    rows = []
    for angle in _ANGLES:
        sine = math.sin(math.radians(angle))
        cells = [f"{angle:g}", *(f"{restitution(law, speed, sine):.4f}" for speed in speeds)]
        if not friction:
            oriented = isinstance(pair.resistance, OrientationResistance)
            value = (
                law.factor * math.exp(law.strength * sine)  # Python cannot call the kernel
                if oriented
                else resistance(law, sine, 1.0, 1.0, sine)
            )
            cells.append(f"{value:.4f}")
        rows.append(cells)
    if not friction:
        head.append("C_f")
    title = f"{pair.particle} on {pair.wall}: laws at a contact below the centre"
    lines = [str(TextTable(title, head, rows))]
    if isinstance(pair.resistance, CoulombResistance):
        lines.append(
            f"friction: static {pair.resistance.static:g}, dynamic {pair.resistance.dynamic:g}"
        )
    lines.append("angle: of the contact velocity from the wall, degrees; a_nc: normal restitution")
    return "\n".join(lines)
