"""Direct simulation: one condition, many conditions, rough walls, chains of impacts."""
