"""Actions on runs in a list: delete, restore, rename, tag, annotate and stop them."""

import asyncio
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from rich.text import Text
from textual import work

from gaitsim.errors import GaitsimError
from gaitsim.render.terminal.text import ago
from gaitsim.tui.formatting import clip
from gaitsim.tui.screens.base import GaitScreen

if TYPE_CHECKING:
    from gaitsim.storage.manage import TrashedRun
    from gaitsim.storage.overview import Overview

T = TypeVar("T")
LISTED = 12  # maximum number of runs that a question names
UNDOABLE = 50  # maximum number of changes that can be undone


class RunActions(GaitScreen):
    """A screen with a list of runs.

    Attributes:
        listed: all runs in the folder; during the first scan, those read so far.
        renaming: whether a run is being renamed.
    """

    def __init__(self) -> None:
        super().__init__()
        self.listed: list[Overview] = []
        self.renaming = False
        self._done: list[tuple[str, Callable[[], object]]] = []  # how to undo each change

    def current(self) -> "Overview | None":
        """Return the run under the cursor."""
        raise NotImplementedError

    def chosen(self) -> "list[Overview]":
        """Return the runs to act on."""
        raise NotImplementedError

    def run_changed(self, old: Path, new: Path) -> None:
        """Refresh the runs after one was changed or moved."""
        raise NotImplementedError

    def _remember(self, what: str, undo: Callable[[], object]) -> None:
        self._done = [*self._done[1 - UNDOABLE :], (what, undo)]
        self.refresh_bindings()

    @work(group="undo", exclusive=True)
    async def action_undo(self) -> None:
        """Undo the last deletion, name, note or tags."""
        if self._done:
            what, undo = self._done.pop()
            if await self._try(_call, undo):
                self.notify(what, title="Undone", markup=False)
            self.run_changed(self.gaitsim.folder, self.gaitsim.folder)
            self.refresh_bindings()

    @work(group="ask")
    async def action_delete(self) -> None:
        """Move runs to the trash after a question that names them; keep live runs."""
        from gaitsim.storage.manage import trash_run
        from gaitsim.tui.screens.questions import Confirm

        deleted = [run for run in self.chosen() if not run.evolves]
        kept = [run.name for run in self.chosen() if run.evolves]
        if not deleted:
            return
        one = len(deleted) == 1
        names = _join_names([run.name for run in deleted])
        about = str(deleted[0].path) if one else names
        about += "\nIt moves" if one else "\nThey move"
        about += " to the trash for 30 days: z restores the last deletion, Z lists the trash."
        if kept:
            about += (
                f"\n\nNot deleted, because they evolve: {_join_names(kept)}. Press x to stop them."
            )
        what = f"the run {deleted[0].name}" if one else f"{len(deleted)} runs"
        if not await self.app.push_screen_wait(Confirm(f"Delete {what}?", "Delete", about)):
            return
        moved = [await self._try(trash_run, run.path) for run in deleted]
        trashed = [run for run in moved if run is not None]
        if trashed:
            self._remember(f"deletion of {names}", partial(_restore, trashed))
            self.notify(names, title="Deleted; press z to undo", markup=False)
        self.run_changed(deleted[0].path, deleted[0].path)

    @work(group="ask")
    async def action_trash(self) -> None:
        """Show deleted runs, restore them, or delete them permanently."""
        from gaitsim.storage.manage import empty_trash, list_trash, restore_run
        from gaitsim.tui.screens.questions import Confirm, PickTrashed

        folder, now = self.gaitsim.folder, self.gaitsim.clock()
        while (runs := await self._try(list_trash, folder)) is not None:
            if not runs:
                self.notify(f"{folder}/", title="The trash is empty", markup=False)
                return
            items = {
                str(run.path): Text(f"{clip(run.name, 40)}  deleted {ago(now - run.deleted)}")
                for run in runs
            }
            match await self.app.push_screen_wait(PickTrashed(f"Trash of {folder}/", items)):
                case ("choose", key):
                    run = next(run for run in runs if str(run.path) == key)
                    if await self._try(restore_run, run) is None:
                        return
                case ("empty", _):
                    what = "1 run" if len(runs) == 1 else f"{len(runs)} runs"
                    about = "This cannot be undone."
                    ask = Confirm(f"Delete {what} permanently?", "Delete", about, danger=True)
                    if await self.app.push_screen_wait(ask):
                        await self._try(empty_trash, folder)
                        self._done = []
                case _:
                    return
            self.run_changed(folder, folder)

    @work(group="ask")
    async def action_rename(self) -> None:
        from gaitsim.storage.manage import check_name, rename_run
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
                self._remember(f"new name of {path.name}", partial(rename_run, new, path.name))
                self.run_changed(path, new)

    @work(group="ask")
    async def action_note(self) -> None:
        from gaitsim.storage.manage import read_note, write_note
        from gaitsim.tui.screens.questions import AskText

        run = self.current()
        if run is None:
            return
        before = await self._try(read_note, run.path)
        dialog = AskText(f"Note on the run {run.name}", before or "")
        text = await self.app.push_screen_wait(dialog)
        if text is not None:
            if await self._try(_call, partial(write_note, run.path, text)):
                undo = partial(write_note, run.path, before or "")
                self._remember(f"note on {run.name}", undo)
            self.run_changed(run.path, run.path)

    @work(group="ask")
    async def action_tag(self) -> None:
        """Edit the tags of the chosen runs."""
        from gaitsim.storage.manage import write_tags
        from gaitsim.tui.screens.questions import Ask

        runs = self.chosen()
        if not runs:
            return
        used = Counter(tag for run in self.listed for tag in run.tags)
        one = len(runs) == 1
        what = f"the run {runs[0].name}" if one else f"{len(runs)} runs"
        about = "+new adds a tag, -old removes one; words without a sign replace all tags."
        if used:
            about += f"\nTags in use: {_join_names([f'{tag} ({used[tag]})' for tag in used])}"
        now = " ".join(runs[0].tags) if one else ""
        check = partial(edited_tags, ())
        ask = Ask(f"Tags of {what}", now, check, about, words=[*used], empty=one)
        answer = await self.app.push_screen_wait(ask)
        if answer is None or answer == now:
            return
        tags = {run.path: edited_tags(run.tags, answer) for run in runs}
        results = [await self._try(write_tags, path, found) for path, found in tags.items()]
        changed = [run for run, done in zip(runs, results, strict=True) if done is not None]
        if changed:
            names = _join_names([run.name for run in changed])
            self._remember(f"tags of {names}", partial(_tag, changed))
        self.run_changed(runs[0].path, runs[0].path)

    @work(group="stop")
    async def action_stop(self) -> None:
        from gaitsim.live.process import stop

        runs = [run for run in self.chosen() if run.evolves]
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


def edited_tags(tags: Iterable[str], words: str) -> list[str]:
    """Return tags after an edit: `+new -old`, or words without a sign for a new list."""
    from gaitsim.storage.manage import check_tag

    given = words.replace(",", " ").split()
    signed = [word for word in given if word[0] in "+-"]
    if signed and len(signed) < len(given):
        raise GaitsimError(
            "tags with and without a sign cannot be mixed",
            allowed="+new -old to change tags, or new words for all tags",
        )
    for word in given:
        check_tag(word[1:] if signed else word)
    if not signed:
        return given
    removed = {word[1:] for word in signed if word.startswith("-")}
    added = [word[1:] for word in signed if word.startswith("+")]
    return [*({*tags} - removed), *added]


def _call(do: Callable[[], object]) -> bool:
    do()
    return True


def _restore(runs: "Sequence[TrashedRun]") -> None:
    from gaitsim.storage.manage import restore_run

    for run in runs:
        restore_run(run)


def _tag(runs: "Sequence[Overview]") -> None:
    """Write the tags that runs had before."""
    from gaitsim.storage.manage import write_tags

    for run in runs:
        write_tags(run.path, run.tags)


def _join_names(names: Sequence[str]) -> str:
    """Join names with commas; beyond `LISTED`, add the number of the others."""
    shown = ", ".join(names[:LISTED])
    return shown if len(names) <= LISTED else f"{shown} and {len(names) - LISTED} more"
