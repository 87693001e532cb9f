"""All actions of the terminal UI: their keys, labels, explanations and places in the palette.

`bindings` makes the keys of a screen or a widget from its rows. What an action does, and whether it
is available, is in the class that has the keys. Packages add actions to all screens by the entry
points `gaitsim.screen`, and rows for their own screens by `declare`.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, Literal, NamedTuple

from textual.binding import Binding, BindingType

from gaitsim.choices import STEERING_KEYS
from gaitsim.errors import GaitsimError
from gaitsim.registry import SCREENS, contract_error, entries, find
from gaitsim.registry.loading import load_object


class ScreenAction(NamedTuple):
    """An action of a screen or a widget.

    Attributes:
        name: name of the action; its ID, for the user's settings, is `group.name`.
        keys: default keys, separated by commas.
        label: label in the footer, and title in the palette.
        about: one line of help.
        do: Textual's name of the action, with arguments; '' if it is `name`.
        why: reason why it is unavailable, and how to enable it; a screen's `obstacle` overrides it.
        display: displayed key, if it is not the first one.
        priority: whether the key precedes those of the widget that has the focus.
        shown: whether the footer shows it.
        on: what an action of a package applies to: any screen, the individual of a screen, its runs
            (two or more), or its plugin.
        show: function that carries out the action of a package on a `GaitScreen`, such as showing
            another screen.
    """

    name: str
    keys: str
    label: str
    about: str
    do: str = ""
    why: str = ""
    display: str | None = None
    priority: bool = False
    shown: bool = True
    on: Literal["screen", "individual", "runs", "plugin"] = "screen"
    show: Callable[[Any], object] | None = None


PREFIX = "list."  # of the IDs of the keys of vi
Shown = partial(ScreenAction, shown=True)
Hidden = partial(ScreenAction, shown=False)

_SHOWN = "No champion is shown yet: it is loading, or the run has none."
_CHAMPION = "The run has no champion yet; let it evolve."
_ELSEWHERE = "Another process evolves the run, or the run is still being prepared."
_EXPORTS = "This run has no exports yet; press e to export files."
_HISTORY = "None of these runs has a finished generation yet."

_AXES = [
    Shown("axes-back", "left_square_bracket", "Axes", "Previous pair of axes", "pair(-1)"),
    Shown("axes-on", "right_square_bracket", "Axes", "Next pair of axes", "pair(1)"),
    Hidden("across", "x", "Horizontal axis", "Choose the next horizontal axis", "axis(0)"),
    Hidden("upwards", "z", "Vertical axis", "Choose the next vertical axis", "axis(1)"),
]  # fmt: skip
_MEMBER = [
    Shown("best", "b", "Best", "Select the best member"),
    Shown("go-to", "g,colon", "Go to", "A member by number", display="g"),
    Shown("replay", "r,enter", "Replay", "Replay this gait frame by frame", display="r"),
    Shown("why", "w", "Why", "Explain the score and name the gait"),
    Shown("export", "e", "Export", "Gait files, plots, videos, …"),
    Hidden("view", "v", "View", "From the corner, the side, above, or the front"),
]  # fmt: skip

_FORM = [
    Shown("search", "ctrl+f", "Find", "Search options", priority=True),
    Hidden("words", "slash", "Search", "Search options", "search"),
    Shown("reset", "ctrl+z", "Reset", "Undo all changes"),
    Hidden("next", "ctrl+right", "Next", "Next tab", "tab(1)"),
    Hidden("before", "ctrl+left", "Back", "Previous tab", "tab(-1)"),
    Hidden("copy", "ctrl+y", "Copy", "The command", "app.copy_command"),
]  # fmt: skip

ACTIONS: dict[str, list[ScreenAction]] = {
    "app": [
        Shown("help", "question_mark", "Help", "Show keys and their use"),
        Shown("quit", "q", "Quit", "Quit; asks whether active runs should continue"),
        Hidden("copy", "y", "Copy command", "Copy the equivalent command", "copy_command",
               why="This screen has no command."),
        Hidden("tasks", "t,ctrl+t", "Tasks", "Show exports and other tasks in the background",
               why="There are no tasks yet; press e on a run to export files.")],
    "list": [
        Hidden("down", "j", "Down", "Down in a list", "vi('down')"),
        Hidden("up", "k", "Up", "Up in a list", "vi('up')"),
        Hidden("first", "g", "First", "First in a list", "vi('first')"),
        Hidden("last", "G", "Last", "Last in a list", "vi('last')"),
        Hidden("page-down", "ctrl+d", "Page down", "Page down in a list", "vi('page_down')"),
        Hidden("page-up", "ctrl+u", "Page up", "Page up in a list", "vi('page_up')")],
    "screen": [
        Shown("back", "escape", "Back", "Previous screen"),
        Hidden("steer", "D", "Steer", "Steer the body of the champion yourself with the keyboard",
               why="Select a run with a champion."),
        Hidden("verify", "v", "Verify", "Repeat the run, study or trials and compare every bit",
               why="Nothing that is finished is selected.")],
    "home": [
        Shown("new", "n", "New", "Create a new run"),
        Shown("replay", "r", "Replay", "Watch champions move"),
        Shown("compare", "c", "Compare", "Compare the marked runs"),
        Shown("export", "e", "Export", "Gait files, plots, videos"),
        Shown("filter", "slash", "Filter", "Show only runs with these words"),
        Shown("delete", "d,delete", "Delete", "Move to the trash, after a question"),
        Shown("undo", "z,ctrl+z", "Undo", "Undo the last deletion, name, note or tags",
              why="Nothing has been deleted, renamed, tagged or annotated here.", display="z"),
        Shown("tag", "T", "Tag", "Edit the tags of the run, or of all marked runs"),
        Shown("stop", "x", "Stop", "Save the run and stop it"),
        Shown("note", "N", "Note", "Edit the note of the run"),
        Shown("rename", "R", "Rename", "Rename the run"),
        Shown("files", "f", "Files", "Files exported from the run"),
        Shown("why", "w", "Why", "Explain the champion's score"),
        Hidden("map", "M", "Map", "The archive as a map, or the front as a scatter plot"),
        Hidden("trash", "Z", "Trash", "List deleted runs, and restore them"),
        Hidden("preview", "P", "Preview", "Show or hide the champion of the run under the cursor",
               why="The terminal is too small: at least 110 × 30 or 150 × 20 characters are "
               "needed."),
        Hidden("columns", "C", "Columns", "Choose columns: any option or term of the score"),
        Shown("plugins", "p", "Plugins", "List installed plugins")],
    "home table": [
        Shown("open", "enter", "Open", "Watch or continue the run", "select_cursor"),
        Shown("mark", "space", "Mark", "Mark the run, to act on several"),
        Hidden("mark-range", "V,shift+space", "Mark range", "Mark all from the last mark to here",
               display="V"),
        Hidden("mark-all", "a,asterisk", "Mark all", "Mark all runs that are shown", display="a"),
        Hidden("invert", "i", "Invert marks", "Mark the runs that are not marked, and only these"),
        Hidden("unmark", "A", "Unmark all", "Clear all marks"),
        Hidden("sort", "s", "Sort", "Sort by the next column"),
        Hidden("turn", "S", "Reverse", "Reverse the order", "reverse")],
    "live": [
        Shown("pause", "space", "Pause", "Pause after this generation",
              why="The run is not evolving here."),
        Shown("go", "space", "Resume", "Continue the run",
              why="The run is already evolving, or finished; press g to plan more generations."),
        Shown("step", "n", "Step", "One generation, then pause",
              why="The run is finished; press g to plan more generations."),
        Shown("stop", "s", "Stop", "Stop and save", why="The run is not evolving here."),
        Shown("change", "c", "Change", "Change options for the next generations", why=_ELSEWHERE),
        Shown("fork", "f", "Fork", "Copy the run with other options",
              why="The run has no finished generation to copy."),
        Shown("replay", "r", "Replay", "Watch any generation move", why=_CHAMPION),
        Shown("map", "M", "Map", "The archive as a map, or the front as a scatter plot",
              why="The search keeps neither an archive nor a front."),
        Shown("goal", "g", "Generations", "Set the number of generations", why=_ELSEWHERE),
        Shown("why", "w", "Why", "Explain the champion's score", why=_CHAMPION),
        Shown("export", "e", "Export", "Gait files, plots, videos, …", why=_CHAMPION),
        Shown("log", "l", "Events", "Show the events, or the terms")],
    "replay": [
        Shown("play", "space", "Play", "Play the motion",
              why="The motion is already playing, or none is shown yet."),
        Shown("pause", "space", "Pause", "Pause the motion",
              why="The motion is already paused, or none is shown yet."),
        Shown("frame-back", "comma", "Frame", "One frame back", "frame(-1)", why=_SHOWN),
        Shown("frame-on", "full_stop", "Frame", "One frame forward", "frame(1)", why=_SHOWN),
        Shown("generation-back", "left_square_bracket", "Generation",
              "One generation or member back", "generation(-1)", why=_SHOWN),
        Shown("generation-on", "right_square_bracket", "Generation",
              "One generation or member forward", "generation(1)", why=_SHOWN),
        Shown("go-to", "g,colon", "Go to", "A generation or member by number", display="g",
              why=_SHOWN),
        Shown("best", "b", "Best", "The champion of the run, or the member with the best score",
              why=_SHOWN),
        Shown("members", "o", "Members", "Step through the front or archive, or the generations"),
        Hidden("slower", "less_than_sign", "Slower", "Halve the speed", "speed(-1)", why=_SHOWN),
        Hidden("faster", "greater_than_sign", "Faster", "Double the speed", "speed(1)",
               why=_SHOWN),
        Shown("view", "v", "View", "From the corner, the side, above, or the front",
              "camera('next_view')", why=_SHOWN),
        Shown("follow", "f", "Follow", "Follow the body, or show its whole path",
              "camera('follow')", why=_SHOWN),
        Hidden("closer", "plus,equals_sign", "Closer", "Zoom in", "camera('zoom', 1)", why=_SHOWN),
        Hidden("farther", "minus", "Farther", "Zoom out", "camera('zoom', -1)", why=_SHOWN),
        Hidden("reset", "0", "Reset view", "Reset the camera", "camera('reset')", why=_SHOWN),
        Shown("measures", "m", "Measures", "Show measures, terms and the curve of the best score",
              why=_SHOWN),
        Shown("split", "s", "Split", "Show a second body, or a single one"),
        Shown("map", "M", "Map", "Show the archive as a map, or the front, at this member",
              why="The search keeps neither an archive nor a front."),
        Shown("why", "w", "Why", "Explain the score and name the gait", why=_SHOWN),
        Shown("browser", "B", "3D", "Write a web page that plays the motion in 3D, and open it"),
        Shown("code", "C", "Code", "Copy a challenge code of this individual for others to verify",
              why=_SHOWN),
        Shown("export", "e", "Export", "Plots, videos, gait files, … of the individual shown",
              why=_SHOWN)],
    "map": [
        *_AXES, *_MEMBER,
        Shown("play", "space", "Pause", "Pause or play the motion")],
    "front": [
        *_AXES,
        Hidden("along-back", "comma", "Previous", "Previous member along the front", "along(-1)"),
        Hidden("along-on", "full_stop", "Next", "Next member along the front", "along(1)"),
        Shown("mark", "space", "Mark", "Mark two members to compare them or replay both"),
        *_MEMBER,
        Shown("others", "o", "Others",
              "Show or hide the other individuals of the last generation"),
        Hidden("colour", "c", "Colour", "Show another objective by colour"),
        Hidden("play", "P", "Pause", "Pause or play the motion")],
    "map cursor": [
        Hidden("left", "left,h", "Left", "Move to the next gait on the left", "move(-1, 0)"),
        Hidden("right", "right,l", "Right", "Move to the next gait on the right", "move(1, 0)"),
        Hidden("up", "up,k", "Up", "Move to the next gait above", "move(0, 1)"),
        Hidden("down", "down,j", "Down", "Move to the next gait below", "move(0, -1)")],
    "compare": [
        Shown("quantity", "o", "Quantity", "Best, mean or median score, or diversity",
              why=_HISTORY),
        Shown("by", "x", "Axis", "Generations, evaluations or seconds", why=_HISTORY),
        Shown("replay", "r", "Replay", "Watch the champion; with two runs, both champions",
              why="The chosen run has no champion yet.")],
    "steering": [
        *(Hidden(key, key, f"Command {key}", "Give the command of this key", f"command({key!r})")
          for key in STEERING_KEYS),
        Shown("restart", "r", "Restart", "Return to the start"),
        Shown("pause", "p", "Pause", "Pause or resume"),
        Shown("save", "ctrl+s", "Save", "Save the drive as a run, to replay, export and film it",
              why="The drive has been saved, or has no command."),
        Shown("view", "v", "View", "From behind, the side, or above"),
        Hidden("closer", "plus,equals_sign", "Closer", "Zoom in", "zoom(1)"),
        Hidden("farther", "minus", "Farther", "Zoom out", "zoom(-1)"),
        Hidden("help", "h", "Help", "Help on this screen", "app.help")],
    "why": [
        Shown("physics", "p", "Physics", "Play the gait on the body's twin in rigid-body physics"),
        Shown("worlds", "w", "Worlds", "Evaluate the gait in 100 unseen worlds")],
    "new": [
        Shown("run", "ctrl+r", "Run", "Start the run"),
        Shown("save", "ctrl+s", "Save", "Save the experiment file"),
        Shown("preset", "ctrl+g", "Preset", "Choose a different preset", priority=True),
        Shown("load", "ctrl+l", "Load", "Load the file of an experiment or a robot"),
        *_FORM],
    "change": [
        Shown("accept", "ctrl+r", "Apply", "Apply the changes, or fork the run with them"),
        *_FORM],
    "plugins": [
        Shown("new", "n", "New run", "Create a run with this body or preset",
              why="Select a body or a preset that can be loaded."),
        Shown("filter", "slash", "Filter", "Show only plugins with these words")],
    "tasks": [
        Shown("copy", "p", "Copy path", "Copy the paths of the task's files", "copy_result",
              why="The task has not written a file."),
        Shown("stop", "x", "Stop", "Stop the task; partial files are removed",
              why="The task has ended."),
        Shown("again", "r", "Again", "Run the task's command again",
              why="The task is still running."),
        Shown("clear", "c", "Clear", "Remove finished tasks from the list",
              why="No task has ended.")],
    "files": [
        Shown("copy", "p", "Copy path", "Copy the path of the file", "copy_path", why=_EXPORTS),
        Shown("make", "e", "Export", "Export files from this run", "export")],
    "files table": [
        Shown("open", "enter", "Open", "Open the file", "select_cursor", why=_EXPORTS)],
    "canvas": [
        Hidden("left", "left", "Turn left", "Turn the body to the left", "turn(1, 0)"),
        Hidden("right", "right", "Turn right", "Turn the body to the right", "turn(-1, 0)"),
        Hidden("up", "up", "Higher", "Raise the camera", "turn(0, 1)"),
        Hidden("down", "down", "Lower", "Lower the camera", "turn(0, -1)"),
        Hidden("closer", "plus,equals_sign", "Closer", "Zoom in", "zoom(1)"),
        Hidden("farther", "minus", "Farther", "Zoom out", "zoom(-1)"),
        Shown("follow", "f", "Follow", "Follow the body, or show its whole path"),
        Shown("view", "v", "View", "View from the corner, the side, above or the front",
              "next_view"),
        Hidden("reset", "0", "Reset view", "Reset the camera")],
    "curves": [
        Hidden("back", "left", "Cursor back", "Move the cursor one point back", "step(-1)"),
        Hidden("on", "right", "Cursor forward", "Move the cursor one point forward", "step(1)"),
        Hidden("far-back", "shift+left,pageup", "Far back", "Move the cursor ten points back",
               "step(-10)"),
        Hidden("far-on", "shift+right,pagedown", "Far forward",
               "Move the cursor ten points forward", "step(10)"),
        Hidden("first", "home", "First", "Move the cursor to the first point", "end(0)"),
        Hidden("last", "end", "Last", "Move the cursor to the last point", "end(-1)")],
    "scrubber": [
        Hidden("back", "left", "Back", "One step back", "step(-1)"),
        Hidden("on", "right", "Forward", "One step forward", "step(1)"),
        Hidden("far-back", "shift+left,pageup", "Far back", "Ten steps back", "step(-10)"),
        Hidden("far-on", "shift+right,pagedown", "Far forward", "Ten steps forward", "step(10)"),
        Hidden("first", "home", "First", "Go to the first", "end(False)"),
        Hidden("last", "end", "Last", "Go to the last", "end(True)")],
    "confirm": [
        Shown("yes", "y", "Yes", "Confirm", "dismiss(True)"),
        Shown("no", "n,escape", "No", "Change nothing", "dismiss(False)")],
    "choose": [Shown("cancel", "escape", "Cancel", "Change nothing", "dismiss")],
    "trash": [
        Shown("empty", "x", "Empty", "Delete all runs in the trash permanently", "do('empty')"),
        Shown("close", "escape", "Close", "Close the list", "dismiss")],
    "ask": [Shown("cancel", "escape", "Cancel", "Change nothing", "dismiss")],
    "export": [
        Shown("cancel", "escape", "Cancel", "Export nothing", "dismiss"),
        Shown("make", "ctrl+r", "Export", "Export, from any field"),
        Shown("files", "f", "Files", "Files exported from this run")],
    "presets": [
        Shown("file", "ctrl+l", "A file", "Choose the file of a robot or an experiment",
              priority=True),
        Hidden("up", "up", "Up", "Choose the preset above", "move(-1)", priority=True),
        Hidden("down", "down", "Down", "Choose the preset below", "move(1)", priority=True),
        Shown("cancel", "escape", "Cancel", "Change nothing", "dismiss")],
    "choose-file": [
        Shown("complete", "tab", "Complete", "Complete the typed path", priority=True),
        Hidden("up", "up", "Up", "Choose the entry above", "move(-1)", priority=True),
        Hidden("down", "down", "Down", "Choose the entry below", "move(1)", priority=True),
        Shown("cancel", "escape", "Cancel", "Choose no file", "dismiss")],
    "note": [
        Shown("save", "ctrl+s", "Save", "Accept the text", priority=True),
        Shown("cancel", "escape", "Cancel", "Discard the changes")],
    "help": [Shown("close", "escape,question_mark,q", "Close", "Go back", "dismiss")],
}  # fmt: skip
"""The actions of each class by group; the first word of a group begins the IDs of its actions."""


def declare(group: str, actions: Sequence[ScreenAction]) -> None:
    """Add the actions of a package's own screen or widget, for `bindings`."""
    ACTIONS[group] = [*actions]
    NAMED.update(_named(group))


def add_package_actions() -> list[ScreenAction]:
    """Add the actions of packages to all screens, once; return them.

    The module of an action is imported before the screens, so it imports `GaitScreen` only for type
    checkers. An action that cannot be loaded is left out, and the app shows its error.
    """
    if not _of_packages:
        for name in entries(SCREENS):
            try:
                found = load_object(find(SCREENS, name))
            except GaitsimError as error:
                broken.append(error)
                continue
            if not isinstance(found, ScreenAction) or found.show is None:
                what = f"is not an action with the function `show`, but a {type(found).__name__}"
                broken.append(contract_error(find(SCREENS, name), what, "gaitsim.screen.Shown(…)"))
            else:
                _of_packages.append(found._replace(do=f"on_{found.on}({name!r})", name=name))
        declare("screen", [*ACTIONS["screen"], *(one for one in _of_packages if one.keys)])
    return _of_packages


_of_packages: list[ScreenAction] = []
broken: list[GaitsimError] = []
"""The errors of packages' actions that could not be added."""


def bindings(group: str) -> list[BindingType]:
    """Return the keys of a group."""
    return [
        Binding(
            action.keys,
            action.do or action.name.replace("-", "_"),
            action.label,
            show=action.shown,
            key_display=action.display,
            priority=action.priority,
            tooltip=action.about,
            id=name,
        )
        for name, action in _named(group)
    ]


def _named(group: str) -> Iterator[tuple[str, ScreenAction]]:
    for action in ACTIONS[group]:
        yield f"{group.partition(' ')[0]}.{action.name}", action


NAMED = {name: action for group in ACTIONS for name, action in _named(group)}
"""The actions by ID."""
