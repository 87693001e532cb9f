"""Checks of plots and exporters, which are tried on small runs."""

from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any, get_args

import pytest

from gaitsim.plugin import (
    EXPERIMENTS,
    PRODUCTS,
    Exporter,
    GaitsimError,
    Input,
    Plot,
    Product,
    Subject,
    entries,
)
from gaitsim.plugin.runs import RunSnapshot
from gaitsim_testing.finding import advise, require

KINDS = PRODUCTS
FEELING = {"organism.reflexes": {"heading": {}}, "organism.duration": 2.0}
SAMPLES: Mapping[str, Mapping[str, Any]] = {
    "spider": {},
    "spider-atlas": {},
    "spider-front": {},
    "hexapod": FEELING,
}
"""Presets, with options, of the runs on which products are tried, the first that has the data."""


@pytest.fixture(scope="session")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the small runs."""
    return tmp_path_factory.mktemp("runs")


def test_product(plugin: Any, runs: Path, tmp_path: Path) -> None:
    """The product is declared, and has the same bytes when it is made twice."""
    assert isinstance(plugin, Product)
    for name in ("title", "group", *(("suffix",) if isinstance(plugin, Exporter) else ())):
        require(
            isinstance(getattr(plugin, name, None), str),
            f"{type(plugin).__name__} has no {name}",
            f"a string {name}",
            f"{name}: ClassVar[str] = …",
        )
    allowed = ", ".join(map(repr, get_args(Input)))
    require(plugin.input in get_args(Input), f"input = {plugin.input!r}", f"one of {allowed}")
    subject = next(_subjects(plugin, runs), None)
    advise(
        subject,
        f"none of {', '.join(SAMPLES)} has the data",
        "a product that can be made from one of the bundled runs",
        "test the product in your package",
    )
    if subject is None:
        return
    first, second = (_output(plugin, subject, tmp_path / turn) for turn in "12")
    require(first, "nothing is written", "a file, or a folder with files")
    require(
        first == second,
        "two files that differ",
        "the same bytes each time",
        "write no time, no name of the machine, and no random numbers",
    )


def _output(product: Product, subject: Subject, folder: Path) -> object:
    from gaitsim.plugin.pictures import PLOT_THEMES as THEMES, picture

    if isinstance(product, Plot):
        return picture(product.draw(subject), "svg", THEMES[product.theme])
    assert isinstance(product, Exporter)
    folder.mkdir()
    product.write(subject, folder / product.file_name(subject))
    files = sorted(one for one in folder.rglob("*") if one.is_file())
    return [(str(one.relative_to(folder)), one.read_bytes()) for one in files]


def _subjects(product: Product, runs: Path) -> Iterator[Subject]:
    """Yield the small runs with the data that a product needs."""
    for preset in SAMPLES:
        if preset in entries(EXPERIMENTS):
            run = RunSnapshot(_evolve(preset, runs))
            individual = run.individual()
            try:
                product.check(individual)
            except GaitsimError:
                continue
            yield Subject(run, () if product.input == "run" else (individual,))


@cache
def _evolve(preset: str, runs: Path) -> Path:
    """Evolve two small runs, and return the folder of the second, which repeats the first."""
    from gaitsim.plugin.runs import evolve

    folder = runs
    for seed in (1, 0):
        folder = runs / f"{preset}-{seed}"
        with evolve(
            preset,
            generations=2,
            population=24,
            seed=seed,
            set=SAMPLES[preset],
            workers=1,
            out=folder,
        ) as search:
            for _ in search:
                pass
    return folder
