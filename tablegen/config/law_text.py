"""The contact laws of a pair at a few angles and speeds, as a text to look at before generating."""

import math

from tablegen.config.config import Config
from tablegen.config.pairs import CoulombResistance, OrientationResistance
from tablegen.model.contact_laws import resistance, restitution
from tablegen.presentation import TextTable

#: Angles of the contact velocity from the wall [degrees].
_ANGLES = (10.0, 30.0, 45.0, 60.0, 90.0)


def law_at(config: Config, name: str, angle_deg: float, speed: float) -> float:
    """Compute a_nc ("restitution") or C_f ("resistance") of a contact below the particle's centre.

    The angle is that of the contact velocity from the wall. Coulomb's law has no C_f.
    """
    law = config.pair.kernel_arguments(config.population.only_spheres)
    sine = math.sin(math.radians(angle_deg))
    if name == "restitution":
        return float(restitution(law, speed, sine))
    if isinstance(config.pair.resistance, OrientationResistance):
        return float(law.factor * math.exp(law.strength * sine))  # Python cannot call the kernel
    return float(resistance(law, sine, 1.0, 1.0, sine))


def law_text(config: Config) -> str:
    """Write restitution and resistance of a contact that is below the centre of the particle."""
    pair = config.pair
    low, high = config.domain.speed
    speeds = [low, (low * high) ** 0.5, high] if pair.restitution.depends_on_speed else [high]
    speeds = list(dict.fromkeys(speeds))
    coulomb = pair.resistance if isinstance(pair.resistance, CoulombResistance) else None
    head = ["angle", *(f"a_nc at {speed:.4g} m/s" for speed in speeds)]
    head += [] if coulomb else ["C_f"]
    rows = []
    for angle in _ANGLES:
        values = [law_at(config, "restitution", angle, speed) for speed in speeds]
        values += [] if coulomb else [law_at(config, "resistance", angle, high)]
        rows.append([f"{angle:g}", *(f"{value:.4f}" for value in values)])
    title = f"{pair.particle} on {pair.wall}: laws at a contact below the centre"
    lines = [str(TextTable(title, head, rows))]
    if coulomb:
        lines.append(f"friction: static {coulomb.static:g}, dynamic {coulomb.dynamic:g}")
    lines.append("angle: of the contact velocity from the wall, degrees; a_nc: normal restitution")
    return "\n".join(lines)
