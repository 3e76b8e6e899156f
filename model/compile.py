"""How the rod's kernels are compiled: one set of numba options for all of them.

`fastmath` keeps NaN and infinity meaningful (no `nnan`, `ninf`): a diverged shot must be seen as such.
Kernels release the GIL, are cached on disk, and follow IEEE on division by zero instead of raising.
"""

from typing import Any

from numba import njit

_FASTMATH = {"contract", "reassoc", "arcp", "nsz"}


def kernel(function: Any) -> Any:
    """Compile a kernel that Python calls: cached on disk, without the GIL."""
    return njit(function, fastmath=_FASTMATH, error_model="numpy", nogil=True, cache=True)


def inlined(function: Any) -> Any:
    """Compile a piece of a kernel that must dissolve in its caller, so that loops around it vectorise."""
    return njit(function, fastmath=_FASTMATH, error_model="numpy", nogil=True, forceinline=True)
