"""The functions of `gaitsim.portable.scalar` in compiled code: of single numbers and of arrays."""

from collections.abc import Callable
from functools import cache
from typing import Any, TypeVar, cast

from llvmlite import ir
from numba import njit, types
from numba.extending import lower_builtin, register_jitable, type_callable

from gaitsim.portable import scalar

__all__ = ["exp", "inner", "log", "loop", "part", "scalar", "sin_and_cos", "tanh"]


_INNER: dict[str, Any] = {
    "error_model": "numpy",
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
}
_PART: dict[str, Any] = {**_INNER, "forceinline": True}
_Function = TypeVar("_Function", bound=Callable[..., Any])


def inner(function: _Function) -> _Function:
    """Compile a function that only compiled code calls, in a tenth less time than others."""
    return cast(_Function, njit(**_INNER)(function))


def part(function: _Function) -> _Function:
    """Compile a function that LLVM inlines, which takes less time than if Numba does."""
    return cast(_Function, njit(**_PART)(function))


def _instructions(function: Any, typing: Any) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator of a generator of instructions that stand for a function.

    The smallest functions are not compiled: each, for each length of polynomials, costs 20 ms.
    """
    type_callable(function)(lambda context: typing)
    any_types = types.VarArg(types.Any)  # type: ignore[no-untyped-call]
    decorate: Callable[[Callable[..., Any]], Any]
    decorate = lower_builtin(function, any_types)  # type: ignore[no-untyped-call]
    return decorate


@_instructions(scalar._bits, lambda x: types.int64(types.float64))
def _bits(context: Any, builder: Any, typed: Any, arguments: Any) -> Any:
    return builder.bitcast(arguments[0], ir.IntType(64))


@_instructions(scalar._float, lambda bits: types.float64(types.int64))
def _float(context: Any, builder: Any, typed: Any, arguments: Any) -> Any:
    return builder.bitcast(arguments[0], ir.DoubleType())


@_instructions(
    scalar._polynomial, lambda x, coefficients: types.float64(types.float64, coefficients)
)
def _polynomial(context: Any, builder: Any, typed: Any, arguments: Any) -> Any:
    x, coefficients = arguments
    total = ir.Constant(ir.DoubleType(), 0.0)
    for n in range(len(typed.args[1])):
        total = builder.fadd(builder.fmul(total, x), builder.extract_value(coefficients, n))
    return total


for _function in vars(scalar).copy().values():
    _own = callable(_function) and _function.__module__ == scalar.__name__
    if _own and _function.__name__ not in globals():
        # Inlined, so that loops over them vectorise: 3 ns a sine, not 20 ns.
        register_jitable(**_PART)(_function)

# For other compiled code.
exp, log, sin_and_cos, tanh = map(part, (scalar.exp, scalar.log, scalar.sin_and_cos, scalar.tanh))


@cache
def loop(name: str) -> Any:
    """Return a function of `scalar`, compiled for contiguous arrays, (n,), and an output, (n,)."""
    function = getattr(scalar, name)

    def unary(x: Any, out: Any) -> None:
        for i in range(len(out)):
            out[i] = function(x[i])

    def binary(x: Any, y: Any, out: Any) -> None:
        for i in range(len(out)):
            out[i] = function(x[i], y[i])

    fill = unary if function.__code__.co_argcount == 1 else binary
    return njit(nogil=True, cache=True, error_model="numpy")(fill)
