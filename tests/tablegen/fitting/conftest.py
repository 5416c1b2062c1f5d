"""Tests of the fit compare it with the executable specification of the draw."""

import sys
from pathlib import Path

# pytest adds that folder only where its own tests are collected
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "sampler"))
