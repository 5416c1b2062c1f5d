"""Samples of contact laws: one of every kind, as a pair file states it."""

SOURCE = {"source": "where it was published"}

RESTITUTION = {
    "exponential": {"law": "exponential", "coefficient": 0.2, "exponent": 0.5},
    "polynomial": {"law": "polynomial", "coefficients": [0.993, -1.76, 1.56, -0.49]},
    "constant": {"law": "constant", "value": 0.6},
    "power": {"law": "power", "coefficient": 0.5, "reference_speed": 100.0, "exponent": 0.25},
    "tabulated": {
        "law": "tabulated",
        "angle_deg": [10.0, 45.0, 90.0],
        "speed": [50.0, 200.0],
        "value": [[0.9, 0.8], [0.6, 0.5], [0.4, 0.2]],
    },
}
RESISTANCE = {
    "orientation": {"law": "exponential-orientation", "strength": 1.0},
    "constant": {"law": "constant", "value": 1.0},
    "coulomb": {"law": "coulomb", "static": 0.4, "dynamic": 0.3},
    "tabulated": {"law": "tabulated", "angle_deg": [10.0, 60.0], "value": [0.9, 0.2]},
}
