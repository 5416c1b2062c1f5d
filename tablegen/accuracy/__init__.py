"""How far two samples of rebound states differ: metrics, their noise, and verdicts."""
