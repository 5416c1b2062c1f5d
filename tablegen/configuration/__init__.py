"""Configurations of tables: TOML files merged, checked and turned into records."""
