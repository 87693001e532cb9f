"""The functions of `gaitsim.portable.scalar` in compiled code: of single numbers and of arrays."""

from functools import cache
from typing import Any

from numba import njit
from numba.extending import register_jitable

from gaitsim.portable import scalar

__all__ = ["cos", "exp", "log", "loop", "scalar", "sin", "tanh"]

for _function in vars(scalar).copy().values():
    if callable(_function) and _function.__module__ == scalar.__name__:
        # Inlined, so that loops over them vectorise: 3 ns a sine, not 20 ns.
        register_jitable(forceinline=True, error_model="numpy")(_function)

# For compiled code that is not a simple loop.
exp, log, sin, cos, tanh = (
    njit(error_model="numpy")(getattr(scalar, name))
    for name in ("exp", "log", "sin", "cos", "tanh")
)


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
