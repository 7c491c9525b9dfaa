"""The compiled library of the kernels."""

from __future__ import annotations

import ctypes
import os
from functools import cache
from pathlib import Path

NAME = "librockslip.so"


@cache
def library() -> ctypes.CDLL:
    """The library, loaded."""
    beside = Path(__file__).parent / NAME
    return ctypes.CDLL(os.environ.get("ROCKSLIP_KERNELS") or str(beside))
