"""Evidence: report, figures of the paper, stability study."""
