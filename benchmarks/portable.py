"""Time of portable functions, draws and products, per number, compared with NumPy's.

NumPy's times depend on the processor: with AVX-512, some functions take a fifth of the time that
they take without.
"""

from collections.abc import Callable

import numpy as np
from timing import medians, print_figure, print_machine

from gaitsim import portable

COUNT = 100_000  # numbers in a call
UNARY = ("exp", "log", "sin", "cos", "tan", "tanh", "arctan", "arcsin")
BINARY = ("arctan2", "power")


def compare(
    name: str, own: Callable[[], object], library: Callable[[], object], count: int
) -> None:
    ours, theirs = medians(own, library, repeats=10)
    print_figure(name, f"{1e9 * ours / count:.1f} ns", f"NumPy {1e9 * theirs / count:.1f} ns")


def compare_function(name: str, *arguments: object) -> None:
    own, library = getattr(portable, name), getattr(np, name)
    compare(name, lambda: own(*arguments), lambda: library(*arguments), COUNT)


def compare_product(genes: int, rng: np.random.Generator) -> None:
    samples, axes = rng.random((30, genes)), rng.random((genes, genes))
    compare(
        f"product of (30, {genes}) and ({genes}, {genes}), per number",
        lambda: portable.matmul(samples, axes),
        lambda: samples @ axes,
        30 * genes,
    )


def main() -> None:
    print_machine()
    rng = np.random.default_rng(0)
    numbers, others = rng.random(COUNT), rng.random(COUNT)
    for name in UNARY:
        compare_function(name, numbers)
    for name in BINARY:
        compare_function(name, numbers, others)
    compare(
        "normal draw",
        lambda: portable.standard_normal(rng, COUNT),
        lambda: rng.standard_normal(COUNT),
        COUNT,
    )
    for genes in (10, 48, 100):
        compare_product(genes, rng)


if __name__ == "__main__":
    main()
