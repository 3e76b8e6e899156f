"""SIMD vectors: several floats as one number, on which the processor works at once, for use inside kernels.

A SIMD vector adds, subtracts, multiplies and divides element by element, with others and with floats. A formula written
for floats thus holds for as many rods, or as many tendons, at once. Whether a loop becomes SIMD code is up to a
compiler's heuristics; a SIMD vector always does. Widths are those of tuples, which are compile-time constants.
"""

import math
import operator
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import lower_builtin, models, register_model

from tendond.model.numerics.compile import bare

ARITHMETIC: dict[Any, str] = {
    operator.add: "fadd",
    operator.sub: "fsub",
    operator.mul: "fmul",
    operator.truediv: "fdiv",
}
FUNCTIONS: dict[Any, str] = {operator.neg: "fneg", abs: "llvm.fabs", math.sqrt: "llvm.sqrt"}


class SimdVector(types.Type):
    """numba's type of a SIMD vector of `width` floats."""

    def __init__(self, width: int) -> None:
        self.width = width
        super().__init__(name=f"SimdVector({width})")


@register_model(SimdVector)
class _SimdVectorModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        models.PrimitiveModel.__init__(self, manager, kind, ir.VectorType(ir.DoubleType(), kind.width))


def _number(width: int) -> Any:
    """Type of `width` floats: a float if there is one."""
    return types.float64 if width == 1 else SimdVector(width)


def _at(element: int) -> Any:
    return ir.Constant(ir.IntType(32), element)


def _elements(builder: Any, vector: Any, elements: list[int]) -> Any:
    """Vector of the elements with these indices."""
    mask = ir.Constant(ir.VectorType(ir.IntType(32), len(elements)), elements)
    return builder.shuffle_vector(vector, vector, mask)


def _spread(builder: Any, number: Any, width: int) -> Any:
    """Vector of `width` times the same float."""
    empty = ir.Constant(ir.VectorType(ir.DoubleType(), width), ir.Undefined)
    return _elements(builder, builder.insert_element(empty, number, _at(0)), [0] * width)


def _define_arithmetic(operation: Any, instruction: str) -> None:
    @infer_global(operation)
    class ArithmeticTemplate(AbstractTemplate):
        def generic(self, arguments: Any, keywords: Any) -> Any:
            vectors = [argument for argument in arguments if isinstance(argument, SimdVector)]
            numbers = all(isinstance(argument, (SimdVector, types.Float)) for argument in arguments)
            if len(arguments) != 2 or not vectors or not numbers or len({one.width for one in vectors}) > 1:
                return None
            return signature(vectors[0], *arguments)

    def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        vectors = [
            value if isinstance(kind, SimdVector) else _spread(builder, value, signature.return_type.width)
            for kind, value in zip(signature.args, arguments, strict=True)
        ]
        return getattr(builder, instruction)(*vectors)

    for kinds in ((SimdVector, SimdVector), (SimdVector, types.Float), (types.Float, SimdVector)):
        lower_builtin(operation, *kinds)(emit)


def _define_function(function: Any, instruction: str) -> None:
    @infer_global(function)
    class FunctionTemplate(AbstractTemplate):
        def generic(self, arguments: Any, keywords: Any) -> Any:
            return signature(arguments[0], *arguments) if isinstance(arguments[0], SimdVector) else None

    def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        if not instruction.startswith("llvm."):
            return getattr(builder, instruction)(*arguments)
        vector = arguments[0].type
        kind = ir.FunctionType(vector, [vector])
        name = f"{instruction}.v{vector.count}f64"
        return builder.call(cgutils.get_or_insert_function(builder.module, kind, name), arguments)

    lower_builtin(function, SimdVector)(emit)


for _operation, _instruction in ARITHMETIC.items():
    _define_arithmetic(_operation, _instruction)
for _function, _instruction in FUNCTIONS.items():
    _define_function(_function, _instruction)


def _address(context: Any, builder: Any, kind: Any, array: Any, index: Any, value: Any) -> Any:
    """Address of an array's elements from `index` on, as a pointer to a value of that LLVM type."""
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [index]), value.as_pointer())


@bare
def simd_load(context: Any, array: Any, index: Any, like: Any) -> Any:
    """Load elements of a contiguous array of one dimension, as many as a tuple or a SIMD vector has: a float if one."""

    def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        value = context.get_value_type(signature.return_type)
        return builder.load(_address(context, builder, array, arguments[0], arguments[1], value), align=8)

    return (like if isinstance(like, SimdVector) else _number(like.count))(array, types.intp, like), emit


@bare
def simd_store(context: Any, array: Any, index: Any, value: Any) -> Any:
    """Store a float or a SIMD vector in a contiguous array of one dimension."""

    def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        place = _address(context, builder, array, arguments[0], arguments[1], arguments[2].type)
        builder.store(arguments[2], place, align=8)
        return context.get_dummy_value()

    return types.void(array, types.intp, value), emit


@bare
def simd_vector(context: Any, numbers: Any, lanes: Any) -> Any:
    """SIMD vector of the floats of a tuple, each as many times as the tuple `lanes` has entries."""

    def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        vector = ir.Constant(context.get_value_type(signature.return_type), ir.Undefined)
        for k, number in enumerate(cgutils.unpack_tuple(builder, arguments[0])):
            for lane in range(lanes.count):
                vector = builder.insert_element(vector, number, _at(k * lanes.count + lane))
        return vector

    return SimdVector(numbers.count * lanes.count)(numbers, lanes), emit


@bare
def simd_repeat(context: Any, number: Any, times: Any) -> Any:
    """Repeat a SIMD vector's floats as many times as the tuple `times` has entries; a float stays what it is."""

    def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        if not isinstance(number, SimdVector):
            return arguments[0]
        return _elements(builder, arguments[0], list(range(number.width)) * times.count)

    return (SimdVector(number.width * times.count) if isinstance(number, SimdVector) else number)(number, times), emit


@bare
def simd_multiply_add(context: Any, factor: Any, vector: Any, total: Any) -> Any:
    """Add a float times a SIMD vector to another one, rounded once."""

    def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kind = arguments[1].type
        spread = _spread(builder, arguments[0], kind.count)
        name = f"llvm.fma.v{kind.count}f64"
        function = cgutils.get_or_insert_function(builder.module, ir.FunctionType(kind, [kind, kind, kind]), name)
        return builder.call(function, [spread, arguments[1], arguments[2]])

    return total(factor, vector, total), emit


@bare
def simd_sum(context: Any, numbers: Any, lanes: Any) -> Any:
    """Sum a SIMD vector's floats for each of the `lanes`, where lane follows lane: a float if there is one lane."""

    def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        vector, width = arguments[0], numbers.width
        while width % (2 * lanes.count) == 0:  # by halves, which takes the fewest instructions
            width //= 2
            halves = [_elements(builder, vector, list(range(start, start + width))) for start in (0, width)]
            vector = builder.fadd(*halves)
        result, *others = (
            _elements(builder, vector, list(range(start, start + lanes.count)))
            for start in range(0, width, lanes.count)
        )
        for other in others:
            result = builder.fadd(result, other)
        return builder.extract_element(result, _at(0)) if lanes.count == 1 else result

    return _number(lanes.count)(numbers, lanes), emit
