"""Names of variables, and quantities in the unit that suits them."""

#: Names of variables on axes.
LABELS = {
    "u": "u⁺ / V",
    "v": "v⁺ / V",
    "w": "w⁺ / V",
    "omega_x": "Ωx⁺ a / V",
    "omega_y": "Ωy⁺ a / V",
    "omega_z": "Ωz⁺ a / V",
}

#: Prefixes of units; nobody says kiloseconds.
_PREFIXES = {
    "s": ((1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n")),
    "B": ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, "")),
    "": ((1.0, ""),),
}


def quantity_text(value: float, unit: str = "") -> str:
    """Positive seconds or bytes with the prefix that suits them, as "2 µs"; or a plain number."""
    prefixes = _PREFIXES[unit]
    # a tick of 1e-6 may be a hair below it
    scale, prefix = next((p for p in prefixes if value >= p[0] * (1.0 - 1e-9)), prefixes[-1])
    return f"{float(f'{value / scale:.3g}'):g} {prefix}{unit}".rstrip()
