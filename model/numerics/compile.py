"""Compilation of the rod's kernels: one set of numba options for all of them.

`fastmath` keeps NaN and infinity meaningful (no `nnan`, `ninf`): a diverged shot must be recognised. It keeps the
order of sums as well (no `reassoc`): a compiler that is free to sort a long sum makes one chain of it, in any order; a
march is a tenth faster in the order that is written. Kernels release the GIL, are cached on disk,
and follow IEEE on division by zero instead of raising.
"""

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from numba import njit, typeof
from numba.core.registry import cpu_target
from numba.extending import intrinsic

_FASTMATH = {"contract", "arcp", "nsz"}


def sources_digest() -> str:
    """Hash all source files of the model: a compiled kernel is out of date as soon as any of them has changed."""
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).resolve().parents[1].rglob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


_SOURCES = sources_digest()
_KERNELS: list[Any] = []


def kernel(function: Any, counted: bool = True) -> Any:
    """Compile a kernel that Python calls: cached on disk, without the GIL."""
    options: dict[str, Any] = {} if counted else {"_nrt": False}
    compiled: Any = njit(function, fastmath=_FASTMATH, error_model="numpy", nogil=True, cache=True, **options)
    # numba looks at the kernel's own file only, and would go on using code inlined from another one that has changed.
    stored = compiled._cache._cache_file
    stored._source_stamp = _SOURCES
    stored._load_index = _forgiving(stored._load_index)
    _KERNELS.append(compiled)
    return compiled


def _forgiving(load: Callable[[], Any]) -> Callable[[], Any]:
    """Return a reader of a kernel's index on the disk that takes one it cannot read for an empty one.

    numba looks whether an index is out of date only after it has imported the modules of the types in it, and where one
    of them has moved since, no kernel would compile any more.
    """

    def load_index() -> Any:
        try:
            return load()
        except (ImportError, AttributeError):
            return {}

    return load_index


def lean(function: Any) -> Any:
    """Compile a kernel that makes no arrays: it does not count who refers to those it is handed, which costs calls."""
    return kernel(function, counted=False)


def uncached() -> list[str]:
    """Names of the imported kernels whose code, of these sources and for this processor, is not on the disk."""
    target = cpu_target.target_context.codegen().magic_tuple()
    return [
        one.py_func.__name__
        for one in _KERNELS
        if not any(key[1] == target for key in one._cache._cache_file._load_index())
    ]


def bind(compiled: Any, *arguments: Any) -> Any:
    """Compile or load the machine code of a kernel for arguments of these types: a function for these types only.

    It skips numba's inspection of every argument, which takes as long as a third of a step of the rod.
    """
    signature = tuple(typeof(argument) for argument in arguments)
    try:
        compiled.compile(signature)
    except RuntimeError:
        # numba cannot save a kernel that it linked to a restored one (QuantEcon.py#944); by then it has compiled it.
        if signature not in compiled.overloads:
            raise
    return compiled.get_overload(signature)


class Bound:
    """A kernel that is bound to the types of its arguments at its first call; see `bind`.

    Attributes:
        call: calls the kernel, with arguments of the same types each time.
    """

    __slots__ = ("_compiled", "call")

    def __init__(self, compiled: Any) -> None:
        self._compiled = compiled
        self.call: Any = self._first

    def _first(self, *arguments: Any) -> Any:
        self.call = bind(self._compiled, *arguments)
        return self.call(*arguments)


def inlined(function: Any) -> Any:
    """Compile a piece of a kernel that must dissolve in its caller, so that its numbers stay in registers."""
    return njit(function, fastmath=_FASTMATH, error_model="numpy", nogil=True, forceinline=True)


def bare(function: Any) -> Any:
    """numba's `intrinsic`, whose functions have one argument less than mypy believes."""
    return intrinsic(function)


@bare
def borrowed(context: Any, array: Any) -> Any:
    """The same array, without counting who refers to it: for a kernel's arguments, which outlive the call.

    Every view of a counted array, such as a slice, costs two atomic operations; a step of the rod makes dozens.
    """

    def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        view = context.make_array(array)(context, builder, arguments[0])
        view.meminfo = view.meminfo.type(None)
        view.parent = view.parent.type(None)
        return view._getvalue()

    return array(array), emit
