"""Evidence on a table and on the model: validation, report, the paper's figures, stability."""
