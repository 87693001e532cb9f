"""Rules for plots and exporters, which are tried on small runs."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, get_args

from gaitsim.contracts.product import Exporter, Input, Plot, Product, Subject
from gaitsim.errors import GaitsimError
from gaitsim.registry import EXPERIMENTS, entries
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.testing.report import Finding, advice, error

FEELING = {"organism.reflexes": {"heading": {}}, "organism.duration": 2.0}
SAMPLES: Mapping[str, Mapping[str, Any]] = {
    "spider": {},
    "spider-atlas": {},
    "spider-front": {},
    "hexapod": FEELING,
}
"""Presets, with options, of the runs on which products are tried, the first that has the data."""


def product_rules(product: Product) -> Iterator[Finding]:
    """Check the declarations of a product, and make it twice."""
    for name in ("title", "group", *(("suffix",) if isinstance(product, Exporter) else ())):
        if not isinstance(getattr(product, name, None), str):
            yield error(
                "declarations",
                f"a string {name}",
                f"{type(product).__name__} has none",
                f"{name}: ClassVar[str] = …",
            )
            return
    if product.input not in get_args(Input):
        allowed = ", ".join(map(repr, get_args(Input)))
        yield error("declarations", f"an input among {allowed}", repr(product.input), "")
        return
    with _sample(product) as subject:
        if subject is None:
            yield advice(
                "trial",
                "a product that can be made from one of the bundled runs",
                f"none of {', '.join(SAMPLES)} has the data",
                "test the product in your package",
            )
            return
        first, *rest = outputs(product, subject)
        if not first:
            yield error("content", "a file, or a folder with files", "nothing was written", "")
        elif any(other != first for other in rest):
            yield error(
                "reproducible",
                "the same bytes each time",
                "two files that differ",
                "write no time, no name of the machine, and no random numbers",
            )


def outputs(product: Product, subject: Subject) -> tuple[object, ...]:
    """Return the content of a product that was made twice."""
    with TemporaryDirectory() as folder:
        return tuple(_output(product, subject, Path(folder) / f"trial{turn}") for turn in "12")


def _output(product: Product, subject: Subject, folder: Path) -> object:
    from gaitsim.render.plots.style import THEMES, picture

    if isinstance(product, Plot):
        return picture(product.draw(subject), "svg", THEMES[product.theme])
    assert isinstance(product, Exporter)
    folder.mkdir()
    path = folder / product.file_name(subject)
    product.write(subject, path)
    files = sorted(one for one in folder.rglob("*") if one.is_file())
    return [(str(one.relative_to(folder)), one.read_bytes()) for one in files]


@contextmanager
def _sample(product: Product) -> Iterator[Subject | None]:
    """Yield a small run with the data that a product needs; None if no preset has them."""
    with TemporaryDirectory() as folder:
        for preset in SAMPLES:
            if preset not in entries(EXPERIMENTS):
                continue
            for name, content in _runs(preset).items():
                path = Path(folder) / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(content)
            run = RunSnapshot(Path(folder) / f"{preset}-0")
            individual = run.individual()
            try:
                product.check(individual)
            except GaitsimError:
                continue
            yield Subject(run, () if product.input == "run" else (individual,))
            return
        yield None


@cache
def _runs(preset: str) -> dict[str, bytes]:
    """Evolve two small runs, and return their files.

    They are kept in memory, as a process that examines plugins is killed, and would leave them.
    """
    from gaitsim.api import evolve

    with TemporaryDirectory() as folder:
        for seed in (1, 0):  # the first one repeats the second one
            with evolve(
                preset,
                generations=2,
                population=24,
                seed=seed,
                set=SAMPLES[preset],
                workers=1,
                out=Path(folder) / f"{preset}-{seed}",
            ) as search:
                for _ in search:
                    pass
        files = (one for one in Path(folder).rglob("*") if one.is_file())
        return {str(one.relative_to(folder)): one.read_bytes() for one in files}
