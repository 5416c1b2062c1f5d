"""Words for metrics and components, on axes, in tables and in controls."""

#: Words for metrics, in the order of `METRICS`.
METRIC_WORDS = {
    "ks": "Kolmogorov–Smirnov distance, worst component",
    "sliced_wasserstein": "sliced Wasserstein distance",
    "correlation_error": "largest error of a correlation",
    "auc": "AUC of a classifier (0.5: cannot tell)",
}

#: Short words for the same.
SHORT = {
    "ks": "KS distance",
    "sliced_wasserstein": "sliced Wasserstein",
    "correlation_error": "correlation error",
    "auc": "AUC",
}

#: Names of components on axes, and as plain text.
LABELS = {
    "u": "u⁺ / V",
    "v": "v⁺ / V",
    "w": "w⁺ / V",
    "omega_x": "Ωx⁺ a / V",
    "omega_y": "Ωy⁺ a / V",
    "omega_z": "Ωz⁺ a / V",
}
