"""A calibration for people: its numbers as text, and a picture of fit and residuals."""
