"""The spin law: rebounds given the angle, the speed, the spin before the impact and the grain."""
