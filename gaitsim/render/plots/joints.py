"""Plot joint angles over time, a panel for each leg."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from gaitsim.individual import Individual
from gaitsim.render.plots.channels import read_signal
from gaitsim.render.plots.components import finite
from gaitsim.render.plots.labels import head, heading_of, shortened
from gaitsim.render.plots.panels import grid, intervals, shade
from gaitsim.render.plots.request import NothingToPlotError, Request, window_slice
from gaitsim.render.plots.style import WIDTH, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

USUAL = 2.0  # seconds: more would blur in a column's width
_TOGETHER = 6  # joints without legs that share a panel
_WIDTHS = 1.8, 1.2, 0.7  # points: the first lines are seen beside later ones that cover them


def joints_figure(request: Request) -> "Figure":
    """Plot angles from the pose at rest in degrees; shaded while the foot is on the ground.

    Raises:
        NothingToPlotError: the body has no joint angles.
        GaitsimError: the window holds none of the motion.
    """
    individual, theme = request.individual, request.theme
    require_joints(individual)
    signal = read_signal(individual, "joint_angles")
    part = window_slice(len(signal.values), signal.rate, request.window, USUAL)
    degrees = np.degrees(finite(signal.values[part]))
    times = np.arange(part.start, part.stop) / signal.rate
    names = signal.entries[-1]
    legs = legs_of(names)
    feet = dict(zip(individual.skeleton.contact_names, _touching(request, part), strict=False))
    with styled(theme):
        sides = _sides([*legs])
        figure, panels = grid(
            len(legs),
            WIDTH,
            columns=2 if sides else min(3, len(legs)),
            height=0.72 if len(legs) > 2 else 1.6,
            downwards=sides,
            share_y=True,
        )
        for axes, (leg, joints) in zip(panels, legs.items(), strict=True):
            for index, (joint, column) in enumerate(joints.items()):
                width = _WIDTHS[min(index, len(_WIDTHS) - 1)]
                line = {**theme.line(index), "linewidth": width}
                axes.plot(times, degrees[:, column], label=joint, **line)
            if leg in feet:
                shade(axes, intervals(feet[leg], times[0], signal.rate), theme)
            axes.axhline(0, color=theme.ink, linewidth=0.4, zorder=1)
            axes.set_title(shortened(leg, 24), fontsize=7, pad=2)
            axes.set_xlim(times[0], times[-1])
        figure.supxlabel("time (s)", fontsize=8)
        figure.supylabel("joint angle (°)", fontsize=8)
        handles, labels = panels[0].get_legend_handles_labels()
        if feet.keys() & legs.keys():
            from matplotlib.patches import Patch

            handles.append(Patch(facecolor=theme.faint, alpha=0.5))
            labels.append("stance")
        one = len(legs) == len(names) > 1 or labels == [""]
        head(figure, heading_of([individual]), *(() if one else (handles, labels)))
    return figure


def require_joints(individual: Individual) -> None:
    """Check that the body has joint angles.

    Raises:
        NothingToPlotError: it has none.
    """
    if "joint_angles" not in individual.experiment.organism.channels:
        raise NothingToPlotError(
            f"{individual.experiment.entries['organism']} has no joint angles to plot",
            where=str(individual.source),
            allowed="a body with the channel 'joint_angles'",
            remedy="--kind channel plots any of its channels",
        )


def legs_of(names: Sequence[str]) -> dict[str, dict[str, int]]:
    """Group joints by leg: 'L1 coxa', 'L1 femur' … as {'L1': {'coxa': 0, …}, …}.

    Joints without a leg share a panel where there are few, else have one each.
    """
    split = [name.rpartition(" ")[::2] for name in names]
    legs: dict[str, dict[str, int]] = {}
    for column, (leg, joint) in enumerate(split):
        legs.setdefault(leg, {})[joint] = column
    whole = sum(map(len, legs.values())) == len(names)
    if len({tuple(joints) for joints in legs.values()}) == 1 and "" not in legs and whole:
        return legs
    if len(names) <= _TOGETHER:
        return {"": {name: column for column, name in enumerate(names)}}
    return {name: {"": column} for column, name in enumerate(names)}


def _sides(legs: Sequence[str]) -> bool:
    """Whether the first half of the legs are left ones and the others right ones."""
    half = len(legs) // 2
    return [leg[:1] for leg in legs] == ["L"] * half + ["R"] * half and half > 0


def _touching(request: Request, part: slice) -> Sequence[np.ndarray]:
    skeleton = request.individual.skeleton
    return () if skeleton.touching is None else [*np.asarray(skeleton.touching[part], bool).T]
