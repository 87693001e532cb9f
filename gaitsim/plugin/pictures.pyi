"""Scenes, videos, plots and pictures in the terminal."""

from gaitsim.render.archive_view import ArchiveView as ArchiveView
from gaitsim.render.archive_view import colour_scale_low as colour_scale_low
from gaitsim.render.colours import is_damaged as is_damaged
from gaitsim.render.colours import LEFT as LEFT
from gaitsim.render.colours import MIDDLE as MIDDLE
from gaitsim.render.colours import RIGHT as RIGHT
from gaitsim.render.colours import sides as sides
from gaitsim.render.encoder import default_speed as default_speed
from gaitsim.render.encoder import encode as encode
from gaitsim.render.encoder import fastest_movement as fastest_movement
from gaitsim.render.encoder import format_speed as format_speed
from gaitsim.render.encoder import movement_frequency as movement_frequency
from gaitsim.render.film import Film as Film
from gaitsim.render.film import RenderSettings as RenderSettings
from gaitsim.render.film import write_still as write_still
from gaitsim.render.front_view import FrontView as FrontView
from gaitsim.render.meshes import Mesh as Mesh
from gaitsim.render.meshes import mesh_of as mesh_of
from gaitsim.render.meshes import polyhedron as polyhedron
from gaitsim.render.meshes import rod as rod
from gaitsim.render.meshes import slab as slab
from gaitsim.render.notebook import enable_notebook_display as enable_notebook_display
from gaitsim.render.parallel_view import ParallelAxis as ParallelAxis
from gaitsim.render.parallel_view import ParallelView as ParallelView
from gaitsim.render.plots.components import finite_or_nan as finite_or_nan
from gaitsim.render.plots.components import limit_constant as limit_constant
from gaitsim.render.plots.components import Line as Line
from gaitsim.render.plots.components import lines_of as lines_of
from gaitsim.render.plots.components import read_signal as read_signal
from gaitsim.render.plots.components import shown_unit as shown_unit
from gaitsim.render.plots.components import Signal as Signal
from gaitsim.render.plots.data import require_archive as require_archive
from gaitsim.render.plots.data import require_front as require_front
from gaitsim.render.plots.data import window_slice as window_slice
from gaitsim.render.plots.fitness import draw_curve as draw_curve
from gaitsim.render.plots.fitness import mark_stages as mark_stages
from gaitsim.render.plots.fitness import set_generations as set_generations
from gaitsim.render.plots.fitness import stages as stages
from gaitsim.render.plots.labels import add_heading as add_heading
from gaitsim.render.plots.labels import format_number as format_number
from gaitsim.render.plots.labels import format_score as format_score
from gaitsim.render.plots.labels import heading_of as heading_of
from gaitsim.render.plots.labels import heading_of_run as heading_of_run
from gaitsim.render.plots.labels import shorten as shorten
from gaitsim.render.plots.labels import STEPS as STEPS
from gaitsim.render.plots.panels import BAR as BAR
from gaitsim.render.plots.panels import draw_bars as draw_bars
from gaitsim.render.plots.panels import grid as grid
from gaitsim.render.plots.panels import intervals as intervals
from gaitsim.render.plots.panels import limit_time as limit_time
from gaitsim.render.plots.panels import shade_spans as shade_spans
from gaitsim.render.plots.parallel import MAX_AXES as MAX_AXES
from gaitsim.render.plots.parallel import parallel_figure as parallel_figure
from gaitsim.render.plots.style import check_target as check_target
from gaitsim.render.plots.style import DARK as DARK
from gaitsim.render.plots.style import LIGHT as LIGHT
from gaitsim.render.plots.style import THEMES as PLOT_THEMES
from gaitsim.render.plots.style import replace_figure as replace_figure
from gaitsim.render.plots.style import save as save
from gaitsim.render.plots.style import styled as styled
from gaitsim.render.plots.style import Theme as Theme
from gaitsim.render.plots.style import WIDTH as WIDTH
from gaitsim.render.scene import Clip as Clip
from gaitsim.render.scene import Scene as Scene
from gaitsim.render.scene import THEMES as THEMES
from gaitsim.render.scene.camera import Points as Points
from gaitsim.render.scene.clip import clip_of as clip_of
from gaitsim.render.scene.ground import steps as steps
from gaitsim.render.scene.pixels import TINT as TINT
from gaitsim.render.scene.themes import Colour as Colour
from gaitsim.render.scene.themes import mix as mix
from gaitsim.render.scene.themes import rgb as rgb
from gaitsim.render.terminal import plan as plan
from gaitsim.render.terminal.member_picture import VIRIDIS as VIRIDIS
from gaitsim.render.terminal.plan import Plan as Plan
from gaitsim.render.terminal.plan import plan_of as plan_of
from gaitsim.render.terminal.text import ago as ago
from gaitsim.render.terminal.text import number as number
from gaitsim.render.terminal.text import visible as visible
from gaitsim.render.terminal.text import visible_lines as visible_lines
from gaitsim.render.ticks import round_step as round_step

__all__ = [
    "add_heading",
    "ago",
    "ArchiveView",
    "BAR",
    "check_target",
    "Clip",
    "clip_of",
    "Colour",
    "colour_scale_low",
    "DARK",
    "default_speed",
    "draw_bars",
    "draw_curve",
    "enable_notebook_display",
    "encode",
    "fastest_movement",
    "Film",
    "finite_or_nan",
    "format_number",
    "format_score",
    "format_speed",
    "FrontView",
    "grid",
    "heading_of",
    "heading_of_run",
    "intervals",
    "is_damaged",
    "LEFT",
    "LIGHT",
    "limit_constant",
    "limit_time",
    "Line",
    "lines_of",
    "mark_stages",
    "MAX_AXES",
    "Mesh",
    "mesh_of",
    "MIDDLE",
    "mix",
    "movement_frequency",
    "number",
    "parallel_figure",
    "ParallelAxis",
    "ParallelView",
    "Plan",
    "plan",
    "plan_of",
    "PLOT_THEMES",
    "Points",
    "polyhedron",
    "read_signal",
    "RenderSettings",
    "replace_figure",
    "require_archive",
    "require_front",
    "rgb",
    "RIGHT",
    "rod",
    "round_step",
    "save",
    "Scene",
    "set_generations",
    "shade_spans",
    "shorten",
    "shown_unit",
    "sides",
    "Signal",
    "slab",
    "stages",
    "steps",
    "STEPS",
    "styled",
    "Theme",
    "THEMES",
    "TINT",
    "VIRIDIS",
    "visible",
    "visible_lines",
    "WIDTH",
    "window_slice",
    "write_still",
]
