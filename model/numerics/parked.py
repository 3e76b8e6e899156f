"""A kernel's arguments that stay the same from call to call, handed over as one address.

Python hands numba every array of a tuple one by one, at some 0.2 us each: five dozen of them cost as much as a step of
the rod. `Parked` keeps what they became inside numba, and `unpark` loads it from there.
"""

from typing import Any

import numpy as np
from llvmlite import ir
from numba import typeof
from numba.core import cgutils, types
from numba.extending import NativeValue, models, register_model, typeof_impl, unbox

from tendond.model.numerics.compile import bare, kernel


class Parked:
    """Arrays in a (named, nested) tuple, which kernels take as one argument; it keeps them alive.

    Attributes:
        values: the tuple. address: of what it is inside numba, in `memory`.
    """

    def __init__(self, values: Any) -> None:
        self.values = values
        self.memory = np.zeros(_size(typeof(values)), dtype=np.uint8)
        self.address = int(self.memory.ctypes.data)
        _park(self.memory, values)


class ParkedType(types.Type):
    """numba's type of `Parked`: that of its values decides."""

    def __init__(self, values: Any) -> None:
        self.values = values
        super().__init__(name=f"Parked({values})")


@typeof_impl.register(Parked)
def _typeof_parked(value: Parked, context: Any) -> ParkedType:
    return ParkedType(typeof(value.values))


@register_model(ParkedType)
class _ParkedModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, ir.IntType(8).as_pointer())  # type: ignore[no-untyped-call]


@unbox(ParkedType)
def _unbox_parked(kind: Any, value: Any, context: Any) -> NativeValue:
    number = context.pyapi.object_getattr_string(value, "address")
    address = context.pyapi.long_as_voidptr(number)
    context.pyapi.decref(number)
    return NativeValue(address, is_error=cgutils.is_not_null(context.builder, context.pyapi.err_occurred()))


def _size(kind: Any) -> int:
    """Bytes that a tuple of arrays takes inside numba, at most: seven words and a shape and strides per array."""
    if hasattr(kind, "types"):
        return 8 + sum(_size(one) for one in kind.types)
    return 8 * (7 + 2 * getattr(kind, "ndim", 0))


def _without_owner(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    """The same value, its arrays without their owners: who unparks them neither keeps nor frees them."""
    if hasattr(kind, "types"):
        for index, one in enumerate(kind.types):
            inner = _without_owner(context, builder, one, builder.extract_value(value, index))
            value = builder.insert_value(value, inner, index)
        return value
    if isinstance(kind, types.Array):
        view = context.make_array(kind)(context, builder, value)
        view.meminfo = view.meminfo.type(None)
        view.parent = view.parent.type(None)
        return view._getvalue()
    return value


@bare
def _store(context: Any, memory: Any, values: Any) -> Any:
    def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        value = _without_owner(context, builder, values, arguments[1])
        data = context.make_array(memory)(context, builder, arguments[0]).data
        builder.store(value, builder.bitcast(data, value.type.as_pointer()), align=8)
        return context.get_dummy_value()

    return types.void(memory, values), emit


@kernel
def _park(memory: Any, values: Any) -> None:
    _store(memory, values)


@bare
def unpark(context: Any, parked: Any) -> Any:
    """Load the tuple of arrays that is parked."""

    def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kind = context.get_value_type(parked.values)
        return builder.load(builder.bitcast(arguments[0], kind.as_pointer()), align=8)

    return parked.values(parked), emit
