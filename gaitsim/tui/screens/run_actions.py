"""Actions on runs: open, replay, compare, export, delete, rename, annotate and stop."""

import asyncio
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from textual import on, work
from textual.widgets import DataTable

from gaitsim.errors import GaitsimError
from gaitsim.tui.actions import bindings
from gaitsim.tui.screens.base import GaitScreen, RunChoice

if TYPE_CHECKING:
    from gaitsim.runs.overview import Overview

T = TypeVar("T")
LISTED = 12  # maximum number of runs that a question names


class RunActions(GaitScreen):
    """A screen with a list of runs, one under the cursor and some marked.

    Attributes:
        renaming: whether a run is being renamed.
    """

    renaming = False

    BINDINGS = bindings("home")

    def current(self) -> "Overview | None":
        """Return the run under the cursor."""
        raise NotImplementedError

    def marked(self) -> "list[Overview]":
        """Return the marked runs, in the order of the list."""
        raise NotImplementedError

    def run_changed(self, old: Path, new: Path) -> None:
        """Refresh the runs after one was changed or moved."""
        raise NotImplementedError

    def _chosen(self) -> "list[Overview]":
        """Return the marked runs, or the one under the cursor if none is marked."""
        run = self.current()
        return self.marked() or ([run] if run is not None else [])

    @property
    def choice(self) -> RunChoice | None:
        run = self.current()
        others = [one.path for one in self.marked() if one is not run]
        return None if run is None else RunChoice(run.path, others=others)

    def obstacle(self, action: str) -> str:
        run, chosen = self.current(), self._chosen()
        needs_run = (
            *("select_cursor", "mark", "replay", "why", "export", "laboratory"),
            *("map", "note", "rename", "files"),
        )
        if action in (*needs_run, "delete", "stop") and not chosen:
            return "There is no run here; press n to create one."
        match action:
            case "delete" if all(one.evolves for one in chosen):
                return "The run is evolving; press x to stop it first."
            case "stop" if not any(one.evolves for one in chosen):
                return "The run is not evolving."
            case "rename" if run is not None and run.evolves:
                return "The run is evolving; press x to stop it first."
            case "replay" | "why" | "export" | "map" | "laboratory" if (
                run and run.problem is not None
            ):
                return "The run cannot be read; see the reason below the list."
            case "replay" | "why" | "export" | "map" | "laboratory" if run and run.generation == 0:
                return "The run has no finished generation yet; open it and let it evolve."
            case "compare" if len(self.marked()) < 2:
                return "Mark two or more runs with space first."
        return super().obstacle(action)

    @on(DataTable.RowSelected)
    def action_open(self) -> None:
        self.open_listed(self.current())

    def action_new(self) -> None:
        self.show_screen("new.New")

    def action_plugins(self) -> None:
        self.show_screen("plugins.Plugins")

    def action_replay(self) -> None:
        """Replay the champion, or those of two marked runs side by side."""
        marked = self.marked()
        if len(marked) == 2:
            self.show_screen("replay.Replay", marked[0].path, beside=marked[1].path)
        else:
            super().action_replay()

    def action_compare(self) -> None:
        self.show_screen("compare.Compare", [run.path for run in self.marked()])

    @work(group="ask")
    async def action_delete(self) -> None:
        """Delete runs after a question that names them; keep live runs."""
        from gaitsim.runs.manage import delete_run
        from gaitsim.tui.screens.questions import Confirm

        deleted = [run for run in self._chosen() if not run.evolves]
        kept = [run.name for run in self._chosen() if run.evolves]
        if not deleted:
            return
        one = len(deleted) == 1
        about = str(deleted[0].path) if one else _join_names([run.name for run in deleted])
        about += "\nTheir champions, exports and notes are deleted too. This cannot be undone."
        if kept:
            about += (
                f"\n\nNot deleted, because they evolve: {_join_names(kept)}. Press x to stop them."
            )
        what = f"the run {deleted[0].name}" if one else f"{len(deleted)} runs"
        question = Confirm(f"Delete {what}?", "Delete", about, danger=True)
        if await self.app.push_screen_wait(question):
            for run in deleted:
                await self._try(delete_run, run.path)
                self.run_changed(run.path, run.path)

    @work(group="ask")
    async def action_rename(self) -> None:
        from gaitsim.runs.manage import check_name, rename_run
        from gaitsim.tui.screens.questions import Ask

        run = self.current()
        if run is None:
            return
        path = run.path

        def check(name: str) -> None:
            if name != path.name:
                check_name(path, name)

        about = f"This renames its folder in {path.parent}."
        question = Ask(f"New name of the run {path.name}", path.name, check, about)
        name = await self.app.push_screen_wait(question)
        if name is not None and name != path.name:
            self.renaming = True
            new = await self._try(rename_run, path, name)
            self.renaming = False
            if new is not None:
                self.run_changed(path, new)

    @work(group="ask")
    async def action_note(self) -> None:
        from gaitsim.runs.manage import read_note, write_note
        from gaitsim.tui.screens.note_dialog import NoteDialog

        run = self.current()
        if run is None:
            return
        before = await self._try(read_note, run.path)
        text = await self.app.push_screen_wait(NoteDialog(run.name, before or ""))
        if text is not None:
            await self._try(write_note, run.path, text)
            self.run_changed(run.path, run.path)

    @work(group="ask")
    async def action_gallery(self) -> None:
        """Write a web site of all runs in the folder."""
        from gaitsim.tui.screens.questions import Ask

        about = "A card for each run, and a page that plays it. An existing gallery is replaced."
        question = Ask("Folder of the gallery", "site", about=about)
        out = await self.app.push_screen_wait(question)
        if out is not None:
            folder = str(self.gaitsim.folder)
            self.gaitsim.start_task(("gallery", folder, "--out", out), opens=not self.app.is_web)

    @work(group="stop")
    async def action_stop(self) -> None:
        from gaitsim.live.process import stop

        runs = [run for run in self._chosen() if run.evolves]
        names = _join_names([run.name for run in runs])
        self.notify(names, title="Stopping after the current generation", markup=False)
        await asyncio.gather(*(self._try(stop, run.path) for run in runs))
        for run in runs:
            self.run_changed(run.path, run.path)

    async def _try(self, do: Callable[..., T], *arguments: object) -> T | None:
        """Call a function in a thread; if it fails, show its error and return None."""
        try:
            return await asyncio.to_thread(do, *arguments)
        except GaitsimError as error:
            self.gaitsim.show_error(error)
        return None


def _join_names(names: Sequence[str]) -> str:
    """Join names with commas; beyond `LISTED`, add the number of the others."""
    shown = ", ".join(names[:LISTED])
    return shown if len(names) <= LISTED else f"{shown} and {len(names) - LISTED} more"
