"""The evidence: error against run time of every way to get a rebound state, as text, JSON, HTML."""
