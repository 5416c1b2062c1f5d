"""Words for metrics and variables, on axes, in tables and in controls."""

from tablegen.configuration.metric_table import METRICS

#: Words for metrics, in the order of `METRICS`.
METRIC_WORDS = {name: metric.label for name, metric in METRICS.items()}

#: Short words for the same.
SHORT = {name: metric.short for name, metric in METRICS.items()}

#: Names of components on axes, and as plain text.
LABELS = {
    "u": "u⁺ / V",
    "v": "v⁺ / V",
    "w": "w⁺ / V",
    "omega_x": "Ωx⁺ a / V",
    "omega_y": "Ωy⁺ a / V",
    "omega_z": "Ωz⁺ a / V",
}
