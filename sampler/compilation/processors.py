"""How many processors this process may use: what the system grants, not what the machine has."""

import math
import os
from pathlib import Path

#: Where Linux says what share of the processors a container may use: "QUOTA PERIOD", in
#: microseconds, or "max PERIOD".
_QUOTA = Path("/sys/fs/cgroup/cpu.max")


def processors() -> int:
    """Count the processors that this process may use.

    A batch system, ``taskset`` or a container may grant a part of those that the machine has.

    Returns
    -------
    int
        At least 1: the processors of the affinity mask (`os.process_cpu_count` from Python 3.13
        on, which heeds ``PYTHON_CPU_COUNT``), and no more than a container's quota of time.
    """
    if hasattr(os, "process_cpu_count"):
        granted = os.process_cpu_count() or 1
    elif hasattr(os, "sched_getaffinity"):
        granted = len(os.sched_getaffinity(0))
    else:
        granted = os.cpu_count() or 1
    return max(1, math.ceil(min(granted, _quota())))


def _quota() -> float:
    """Processors whose time a container may use; infinite where nothing says so."""
    try:
        quota, period = map(float, _QUOTA.read_text(encoding="ascii").split())
    except (OSError, ValueError):  # no such file; or "max"
        return math.inf
    return quota / period
