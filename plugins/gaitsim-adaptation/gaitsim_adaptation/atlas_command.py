"""`gaitsim atlas`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BeforeValidator

from gaitsim.plugin import GaitsimError, option
from gaitsim.plugin.commands import EXPERIMENT, EvolveNew, argument, parse_pairs

if TYPE_CHECKING:
    from gaitsim.plugin.runs import Champion, Experiment


Axes = dict[str, tuple[float, float] | None]


def parse_axes(value: Any) -> Any:
    """Return the ends of each axis of 'NAME=LOW:HIGH,…'; None for a name without ends."""
    if not isinstance(value, str):
        return value
    allowed = "NAME=LOW:HIGH,… with LOW below HIGH, such as forward=0:2"
    found: Axes = {}
    for name, ends in parse_pairs(value, "--axes", allowed).items():
        try:
            low, high = (float(end) for end in ends.split(":")) if ends else (0.0, 1.0)
            if not -math.inf < low < high < math.inf:
                raise ValueError
        except ValueError:
            raise GaitsimError(
                f"invalid range for the axis {name!r}: {ends!r}", where="--axes", allowed=allowed
            ) from None
        found[name] = (low, high) if ends else None
    return found


def parse_cells(value: Any) -> Any:
    """Return the number of cells in '5000', or the counts per axis in '40x30'."""
    if not isinstance(value, str):
        return value
    parts = value.lower().replace("×", "x").split("x")
    if not all(part.isascii() and part.isdecimal() and len(part) < 10 for part in parts):
        raise GaitsimError(
            f"invalid number of cells: {value!r}",
            where="--cells",
            allowed="a number of Voronoi cells, such as 5000, or one count per axis of a grid, "
            "such as 40x30",
        )
    return int(value) if len(parts) == 1 else tuple(map(int, parts))


class EvolveAtlas(EvolveNew):
    """Evolve an atlas of a body's gaits: the best gait for each way of using the legs.

    An atlas is a run of the search map-elites. The command evolves the preset NAME-atlas if it
    exists, and otherwise the given experiment with map-elites as its search.

    [bold]Examples[/bold]

    gaitsim atlas spider

    gaitsim atlas my_robot.urdf --cells 5000

    gaitsim atlas hexapod --axes 'duty factor,yaw=-90:90' --cells 30x30
    """

    body: str = argument(EXPERIMENT, "NAME|FILE", completion="preset_names")
    axes: Annotated[Axes, BeforeValidator(parse_axes)] | None = option(
        None,
        "measures that distinguish gaits, each with its range; for duty factors (the share of the "
        "time that a foot is on the ground), the range defaults to 0:1",
        unset="the axes of the preset, or else the duty factor of each leg",
        placeholder="NAME=LOW:HIGH,…",
    )
    cells: Annotated[int | tuple[int, ...], BeforeValidator(parse_cells)] | None = option(
        None,
        "number of Voronoi cells, such as 5000, or of cells along each axis of a grid, such as "
        "40x30. Each cell keeps its best gait",
        placeholder="N|NxN…",
    )

    def chosen(self) -> tuple[Experiment, Champion | None]:
        """Return the experiment of the atlas."""
        from gaitsim.plugin.commands import starting_individual, status
        from gaitsim.plugin.pictures import visible
        from gaitsim_adaptation.atlas import load_atlas

        given = self.given
        with status(f"Reading {visible(self.body)} …"):
            loaded = load_atlas(self.body, axes=self.axes, cells=self.cells, set=given)
        return loaded, starting_individual(loaded, self.from_)
