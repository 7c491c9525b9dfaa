"""The machine that times were measured on, in one line."""

from __future__ import annotations

import os
import platform
from pathlib import Path


def machine() -> str:
    """Processor, how many of them, threads of BLAS, system and Python."""
    threads = os.environ.get("OMP_NUM_THREADS", "all")
    count = len(os.sched_getaffinity(0))
    return (
        f"{_processor()}, {count} processor{'s' * (count > 1)}, "
        f"BLAS on {threads} thread{'s' * (threads != '1')}, "
        f"{platform.system()} {platform.release()}, Python {platform.python_version()}"
    )


def _processor() -> str:
    """Name of the processor, as the kernel has it, or at least its kind."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return next((name for name in names if name), platform.machine() or "unknown processor")
