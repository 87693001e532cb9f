"""How to build a creature: an assembly drawing, and a list of its parts."""

import csv
from io import StringIO
from typing import TYPE_CHECKING, Any, ClassVar

from gaitsim.plugin import Exported, Exporter, NothingToPlotError, Plot, Subject

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from gaitsim.plugin.pictures import Theme
    from gaitsim.plugin.runs import Individual

ISOMETRIC = ((-0.71, 0.71, 0.0), (-0.41, -0.41, 0.82))
"""Directions to the right and up in a view from the front, left and above."""

VIEWS = {
    "from the front, left and above": ISOMETRIC,
    "from above": ((1, 0, 0), (0, 1, 0)),
    "from the left": ((-1, 0, 0), (0, 0, 1)),
}
ROWS = 14  # parts in a column of the table
COLUMNS = ("place", "part", "on", "face", "turn")


class AssemblyPlot(Plot):
    """The modules of a creature from three sides, and on which face each belongs."""

    title: ClassVar[str] = "Assembly drawing"
    group: ClassVar[str] = "of the motion"

    def check(self, individual: "Individual") -> None:
        """Check that the individual is a creature."""
        _rows(individual)

    def draw(self, subject: Subject) -> "Figure":
        """Return the figure."""
        from gaitsim.plugin.pictures import PLOT_THEMES

        return assembly_figure(subject.individual, PLOT_THEMES[self.theme])


class Parts(Exporter):
    """The parts of a creature, as CSV: each module, its place, its turn and its mass."""

    title: ClassVar[str] = "List of parts"
    group: ClassVar[str] = "Files for robots"
    note: ClassVar[str] = "CSV with a row for each module"
    suffix: ClassVar[str] = ".csv"
    stem: ClassVar[str] = "parts"

    def check(self, individual: "Individual") -> None:
        """Check that the individual is a creature."""
        _rows(individual)

    def write(self, subject: Subject, path: "Path") -> Exported:
        """Write the list."""
        from gaitsim.plugin.runs import write_bytes

        rows = _rows(subject.individual)
        text = StringIO()
        table = csv.writer(text, lineterminator="\n")
        table.writerow([*COLUMNS[:4], "turn (deg)", "mass (kg)"])
        table.writerows([*row[:5], f"{row[5]:g}"] for row in rows)
        write_bytes(path, text.getvalue().encode(), follow=False)
        return Exported(f"{len(rows)} parts, {sum(row[5] for row in rows):.3g} kg")


def _rows(individual: "Individual") -> list[tuple[Any, ...]]:
    """Return place, part, carrier, face, turn in degrees and mass of each module.

    Raises:
        NothingToPlotError: the individual is not a creature, or has no modules.
    """
    from gaitsim_creatures.modules import load_modules
    from gaitsim_creatures.organism import EVOLVE, Creature
    from gaitsim_creatures.plans import parse_plan
    from gaitsim_creatures.trees import BRICK, FACES

    body = individual.body
    if not isinstance(body, Creature) or body.body == EVOLVE:
        raise NothingToPlotError(
            f"{individual.experiment.entries['organism']} is not a creature with modules",
            where=str(individual.source),
        )
    table = load_modules(body.modules)
    letters = {face[0].upper(): face for face in FACES}
    rows: list[tuple[Any, ...]] = [("core", "core", "", "", 0, table.core.mass)]
    for module in parse_plan(body.body):
        brick = module.kind == BRICK
        mass = table.brick.mass if brick else table.hinge.base_mass + table.hinge.arm_mass
        place, part = module.place, "brick" if brick else "hinge"
        rows.append((place, part, place[:-1] or "core", letters[place[-1]], 45 * module.turn, mass))
    return rows


def assembly_figure(individual: "Individual", theme: "Theme") -> "Figure":
    """Draw the modules from three sides, with their places, and a table of the parts.

    Raises:
        NothingToPlotError: the individual is not a creature, or has no modules.
    """
    from matplotlib.figure import Figure

    from gaitsim.plugin.pictures import WIDTH, add_heading, heading_of, styled

    rows = _rows(individual)
    columns = -(-len(rows) // ROWS)
    with styled(theme):
        figure = Figure(figsize=(2 * WIDTH, 4.6 + 0.17 * min(len(rows), ROWS)))
        grid = figure.add_gridspec(2, 2, height_ratios=[4.0, 0.17 * min(len(rows), ROWS) + 0.3])
        views = grid[0, :].subgridspec(2, 2, width_ratios=[1.5, 1.0])
        places = (views[:, 0], views[0, 1], views[1, 1])
        for place, (title, view) in zip(places, VIEWS.items(), strict=True):
            axes = figure.add_subplot(place)
            _draw_view(axes, individual, view, theme)
            axes.set_title(title, fontsize=7, pad=2)
        tables = grid[1, :].subgridspec(1, columns)
        for column in range(columns):
            part = rows[ROWS * column : ROWS * (column + 1)]
            _write_parts(figure.add_subplot(tables[column]), part)
        add_heading(figure, heading_of([individual]))
    return figure


def _draw_view(axes: "Axes", individual: "Individual", view: Any, theme: "Theme") -> None:
    """Draw the visible faces of all boxes in mm, the farthest first, and the places."""
    import numpy as np
    from matplotlib.collections import PolyCollection

    from gaitsim_creatures.building import COLOURS
    from gaitsim_creatures.trees import BRICK, CORE, HINGE

    body: Any = individual.body
    model = body.simulation.model
    # All joints are at 0: the poses of the geoms follow from the frames of the bodies.
    import mujoco

    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    right, up = np.array(view, np.float64)
    toward = np.cross(right, up)
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    faces = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    drawn = []
    for geom in range(model.ngeom):
        name = model.geom(geom).name
        if model.geom_bodyid[geom] == 0:
            continue
        turn = data.geom_xmat[geom].reshape(3, 3)
        points = data.geom_xpos[geom] + (corners * model.geom_size[geom]) @ turn.T
        hinge = name.endswith(" base") or name in body.joint_names()
        kind = CORE if name == "core" else HINGE if hinge else BRICK
        for face in faces:
            quad = points[list(face)]
            normal = np.cross(quad[1] - quad[0], quad[3] - quad[0])
            light = float(normal @ toward) / float(np.linalg.norm(normal))
            if light > 1e-6:
                shade = np.array(COLOURS[kind][:3]) * (0.6 + 0.4 * light)
                drawn.append((float(quad.mean(axis=0) @ toward), quad, shade))
        if view == ISOMETRIC and not name.endswith(" base"):
            at = 1000 * data.geom_xpos[geom] @ np.stack([right, up], axis=1)
            outline = {
                "facecolor": theme.background,
                "edgecolor": "none",
                "alpha": 0.75,
                "pad": 0.6,
            }
            axes.annotate(name, at, ha="center", va="center", fontsize=5, bbox=outline, zorder=5)
    drawn.sort(key=lambda one: one[0])
    shapes = [1000 * quad @ np.stack([right, up], axis=1) for _, quad, _ in drawn]
    colours = [shade for *_, shade in drawn]
    axes.add_collection(PolyCollection(shapes, facecolors=colours, edgecolors="black", lw=0.4))
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.set_xlabel("mm")


def _write_parts(axes: "Axes", rows: list[tuple[Any, ...]]) -> None:
    axes.axis("off")
    cells = [[*map(str, row[:4]), f"{row[4]}°" if row[2] else ""] for row in rows]
    table = axes.table(
        cells,
        colLabels=[*COLUMNS],
        colWidths=[0.28, 0.14, 0.26, 0.14, 0.12],
        cellLoc="left",
        loc="upper center",
        edges="horizontal",
    )
    table.auto_set_font_size(False)
    table.set_fontsize(6)
    for cell in table.get_celld().values():
        cell.set_linewidth(0.4)
