"""Named tuples of arrays that kernels take as one address, and read field by field.

numba hands over a tuple of arrays as all the numbers of all of them: five dozen arrays are four hundred arguments of
each call, which cost as much as a step of the rod from Python, and inside kernels most of the time of compilation.
`Parked` keeps where the arrays are in a block of memory; a kernel gets the block's address, and loads what it names.
Inside kernels and outside, it is read as the tuple that it holds.
"""

import zlib
from collections.abc import Iterator
from typing import Any, TypeVar, cast

import numpy as np
from llvmlite import ir
from numba import typeof
from numba.core import cgutils, types
from numba.core.imputils import lower_getattr_generic
from numba.core.typing.templates import AttributeTemplate
from numba.extending import NativeValue, infer_getattr, models, register_model, typeof_impl, unbox
from numba.np.arrayobj import populate_array

from tendond.model.numerics.compile import bare

Fields = TypeVar("Fields", bound=tuple[Any, ...])


class Parked:
    """A named tuple of contiguous arrays, and of other parked ones, that kernels take as one argument.

    Attributes:
        values: the tuple, kept alive. kind: numba's type of it. address: of `memory`, which says where the values are.
    """

    __slots__ = ("address", "kind", "memory", "values")
    address: int
    kind: "ParkedType"

    def __init__(self, values: Any) -> None:
        words: list[int] = []
        for one in values:
            if isinstance(one, Parked):
                words.append(one.address)
            elif one.flags.c_contiguous:
                words += [one.ctypes.data, *one.shape]
            else:
                raise TypeError("an array that is not contiguous cannot be parked")
        self.values = values
        self.memory = np.array(words, dtype=np.int64)
        self.address = int(self.memory.ctypes.data)
        self.kind = ParkedType(type(values).__name__, dict(zip(values._fields, map(typeof, values), strict=True)))

    def __getattr__(self, name: str) -> Any:
        return getattr(self.values, name)

    def __iter__(self) -> Iterator[Any]:
        return iter(self.values)

    def __reduce__(self) -> tuple[Any, ...]:
        raise TypeError("a rod's working arrays cannot be copied: make another rod from the same robot")


def park(values: Fields) -> Fields:
    """Return a named tuple parked: to be read as before."""
    return cast("Fields", Parked(values))


def address_of(values: Any) -> int:
    """Return the address of what is parked, for `parked_at`."""
    address: int = values.address
    return address


class ParkedType(types.Type):
    """numba's type of `Parked`: the types of its fields by their names."""

    def __init__(self, name: str, fields: dict[str, Any]) -> None:
        self.fields = fields
        super().__init__(name=f"Parked({name}, {zlib.crc32(repr(list(fields.items())).encode()):x})")

    def place(self, name: str) -> int:
        """Return the number of the word at which a field begins."""
        before = 0
        for field, kind in self.fields.items():
            if field == name:
                break
            before += 1 + getattr(kind, "ndim", 0)
        return before


register_model(ParkedType)(models.OpaqueModel)


@typeof_impl.register(Parked)
def _typeof_parked(value: Parked, context: Any) -> ParkedType:
    return value.kind


@unbox(ParkedType)
def _unbox_parked(kind: Any, value: Any, context: Any) -> NativeValue:
    number = context.pyapi.object_getattr_string(value, "address")
    address = context.pyapi.long_as_voidptr(number)
    context.pyapi.decref(number)
    return NativeValue(address, is_error=cgutils.is_not_null(context.builder, context.pyapi.err_occurred()))


def _type_of_field(template: Any, parked: ParkedType, name: str) -> Any:
    return parked.fields.get(name)


infer_getattr(type("_Fields", (AttributeTemplate,), {"key": ParkedType, "generic_resolve": _type_of_field}))


@lower_getattr_generic(ParkedType)
def _load_field(context: Any, builder: Any, parked: Any, address: Any, name: str) -> Any:
    """Load what a field says; it never changes, so that loops need not load it again."""
    kind, first = parked.fields[name], parked.place(name)
    word = ir.IntType(64)
    words = builder.bitcast(address, word.as_pointer())

    def load(number: int, of: Any) -> Any:
        place = builder.gep(words, [ir.Constant(word, first + number)])
        value = builder.load(builder.bitcast(place, of.as_pointer()))
        value.set_metadata("invariant.load", builder.module.add_metadata([]))
        return value

    if isinstance(kind, ParkedType):
        return load(0, context.get_value_type(kind))
    array = context.make_array(kind)(context, builder)
    size = context.get_abi_sizeof(context.get_data_type(kind.dtype))
    shape = [load(1 + axis, word) for axis in range(kind.ndim)]
    strides = [ir.Constant(word, size)]
    for extent in reversed(shape[1:]):
        strides.insert(0, builder.mul(strides[0], extent))
    populate_array(
        array, data=load(0, array.data.type), shape=shape, strides=strides, itemsize=ir.Constant(word, size),
        meminfo=None,
    )  # fmt: skip
    return array._getvalue()


@bare
def parked_at(context: Any, like: Any, address: Any) -> Any:
    """Return what is parked at an address, of the type of `like`."""

    def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[1], context.get_value_type(like))

    return like(like, address), emit
