"""Screens of the terminal UI: their base, their keys and their widgets."""

from gaitsim.tui.app import GaitsimApp as GaitsimApp
from gaitsim.tui.builder import Option as Option
from gaitsim.tui.config import config_path as config_path, read_config as read_config
from gaitsim.tui.formatting import clip as clip, clip_name as clip_name
from gaitsim.tui.keys import (
    Hidden as Hidden,
    Shown as Shown,
    bindings as bindings,
    declare as declare,
)
from gaitsim.tui.opener import copy_paths as copy_paths
from gaitsim.tui.products import CommandForm as CommandForm, default as default
from gaitsim.tui.screens.base import (
    Dialog as Dialog,
    GaitScreen as GaitScreen,
    RunChoice as RunChoice,
)
from gaitsim.tui.screens.questions import Ask as Ask, Confirm as Confirm
from gaitsim.tui.screens.replay_loading import options_of as options_of
from gaitsim.tui.screens.tasks import BAR as BAR, progress_bar as progress_bar
from gaitsim.tui.tasks import Task as Task, TaskChanged as TaskChanged
from gaitsim.tui.themes import check_theme as check_theme
from gaitsim.tui.widgets.canvas import BodyCanvas as BodyCanvas
from gaitsim.tui.widgets.cells import Cells as Cells, Picture as Picture
from gaitsim.tui.widgets.form import Field as Field
from gaitsim.tui.widgets.lists import FileTable as FileTable, OpenTable as OpenTable
from gaitsim.tui.widgets.member_plot import ArchiveMap as ArchiveMap
