"""Scenes, videos, plots and pictures in the terminal."""

from gaitsim.render.archive_view import (
    ArchiveView as ArchiveView,
    colour_scale_low as colour_scale_low,
)
from gaitsim.render.colours import (
    LEFT as LEFT,
    MIDDLE as MIDDLE,
    RIGHT as RIGHT,
    is_damaged as is_damaged,
    sides as sides,
)
from gaitsim.render.encoder import (
    default_speed as default_speed,
    encode as encode,
    fastest_movement as fastest_movement,
    format_speed as format_speed,
    movement_frequency as movement_frequency,
)
from gaitsim.render.film import (
    FORMATS as VIDEO_FORMATS,
    Film as Film,
    RenderSettings as RenderSettings,
    write_still as write_still,
)
from gaitsim.render.front_view import FrontView as FrontView
from gaitsim.render.meshes import (
    Mesh as Mesh,
    mesh_of as mesh_of,
    polyhedron as polyhedron,
    rod as rod,
    slab as slab,
)
from gaitsim.render.notebook import enable_notebook_display as enable_notebook_display
from gaitsim.render.parallel_view import ParallelAxis as ParallelAxis, ParallelView as ParallelView
from gaitsim.render.plots.components import (
    Line as Line,
    Signal as Signal,
    finite_or_nan as finite_or_nan,
    limit_constant as limit_constant,
    lines_of as lines_of,
    read_signal as read_signal,
    shown_unit as shown_unit,
)
from gaitsim.render.plots.data import (
    require_archive as require_archive,
    require_front as require_front,
    window_slice as window_slice,
)
from gaitsim.render.plots.fitness import (
    draw_curve as draw_curve,
    mark_stages as mark_stages,
    set_generations as set_generations,
    stages as stages,
)
from gaitsim.render.plots.labels import (
    STEPS as STEPS,
    add_heading as add_heading,
    format_number as format_number,
    format_score as format_score,
    heading_of as heading_of,
    heading_of_run as heading_of_run,
    shorten as shorten,
)
from gaitsim.render.plots.panels import (
    BAR as BAR,
    draw_bars as draw_bars,
    grid as grid,
    intervals as intervals,
    limit_time as limit_time,
    rows_of_panels as rows_of_panels,
    shade_spans as shade_spans,
)
from gaitsim.render.plots.parallel import MAX_AXES as MAX_AXES, parallel_figure as parallel_figure
from gaitsim.render.plots.style import (
    DARK as DARK,
    LIGHT as LIGHT,
    THEMES as PLOT_THEMES,
    WIDTH as WIDTH,
    Theme as Theme,
    check_target as check_target,
    picture as picture,
    replace_figure as replace_figure,
    save as save,
    styled as styled,
)
from gaitsim.render.scene import THEMES as THEMES, Clip as Clip, Scene as Scene
from gaitsim.render.scene.camera import Points as Points
from gaitsim.render.scene.clip import clip_of as clip_of
from gaitsim.render.scene.ground import steps as steps
from gaitsim.render.scene.pixels import TINT as TINT
from gaitsim.render.scene.themes import Colour as Colour, mix as mix, rgb as rgb
from gaitsim.render.terminal import plan as plan
from gaitsim.render.terminal.member_picture import VIRIDIS as VIRIDIS
from gaitsim.render.terminal.plan import Plan as Plan, plan_of as plan_of
from gaitsim.render.terminal.text import (
    ago as ago,
    number as number,
    visible as visible,
    visible_lines as visible_lines,
)
from gaitsim.render.ticks import round_step as round_step
from gaitsim.render.video import Video as Video

__all__ = [
    "BAR",
    "DARK",
    "LEFT",
    "LIGHT",
    "MAX_AXES",
    "MIDDLE",
    "PLOT_THEMES",
    "RIGHT",
    "STEPS",
    "THEMES",
    "TINT",
    "VIDEO_FORMATS",
    "VIRIDIS",
    "WIDTH",
    "ArchiveView",
    "Clip",
    "Colour",
    "Film",
    "FrontView",
    "Line",
    "Mesh",
    "ParallelAxis",
    "ParallelView",
    "Plan",
    "Points",
    "RenderSettings",
    "Scene",
    "Signal",
    "Theme",
    "Video",
    "add_heading",
    "ago",
    "check_target",
    "clip_of",
    "colour_scale_low",
    "default_speed",
    "draw_bars",
    "draw_curve",
    "enable_notebook_display",
    "encode",
    "fastest_movement",
    "finite_or_nan",
    "format_number",
    "format_score",
    "format_speed",
    "grid",
    "heading_of",
    "heading_of_run",
    "intervals",
    "is_damaged",
    "limit_constant",
    "limit_time",
    "lines_of",
    "mark_stages",
    "mesh_of",
    "mix",
    "movement_frequency",
    "number",
    "parallel_figure",
    "picture",
    "plan",
    "plan_of",
    "polyhedron",
    "read_signal",
    "replace_figure",
    "require_archive",
    "require_front",
    "rgb",
    "rod",
    "round_step",
    "rows_of_panels",
    "save",
    "set_generations",
    "shade_spans",
    "shorten",
    "shown_unit",
    "sides",
    "slab",
    "stages",
    "steps",
    "styled",
    "visible",
    "visible_lines",
    "window_slice",
    "write_still",
]
