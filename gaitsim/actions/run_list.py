"""`gaitsim runs`: list, find, watch, tag and delete runs."""

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from gaitsim.actions.action import JSON, Action, argument, not_combinable
from gaitsim.console.printing import agrees, echo, notice, output, print_json, print_table
from gaitsim.contracts.plugin import option
from gaitsim.contracts.product import Names
from gaitsim.errors import GaitsimError
from gaitsim.registry.entry_points import PYTHON, is_outside
from gaitsim.render.terminal.run_cells import run_cell
from gaitsim.storage.files.folder import check_root, find_run, holds_run
from gaitsim.storage.manage import delete_run, trash_run, write_tags
from gaitsim.storage.overview import Overview, list_overviews
from gaitsim.storage.query import (
    check_keys,
    parse_query,
    sort_runs,
    value_of,
)

CHOICE, CHANGES = "Choose and arrange runs", "Change runs"
COLUMNS = ("name", "body", "fitness", "generation", "score", "state")
_HEADS = {"name": "run", "score": "best", "tag": "tags"}
MOST_NAMED = 10
"""Maximum number of runs that a question names."""
MANY = 1000
"""Number of runs that take a second to read."""


class ListRuns(Action):
    """List the runs in a folder, oldest first; find, watch, tag or delete some of them.

    A query is words that all must hold. A word is found in names, plugins, states, notes and tags.
    KEY:TEXT, KEY=VALUE, KEY!=VALUE, KEY>NUMBER and KEY<NUMBER compare a value, and '-' before a
    word negates it. Keys are name, body, fitness, search, selection, crossover, mutation, state,
    tag, note, seed, generation, generations, score, evaluations, stage, time (as in 'time>2min'),
    age (since the last change, as in 'age<2d'), options such as evolution.population, and terms of
    the best individual of the last generation.

    [bold]Examples[/bold]

    gaitsim runs

    gaitsim runs experiments/spring --json

    gaitsim runs --where 'spider score>2 -tag:bad' --sort -score

    gaitsim runs --columns name,score,search.step

    gaitsim runs --where 'age<1d state:finished' --tag new

    gaitsim runs --delete spider-2 --delete spider-3

    gaitsim runs --watch
    """

    root: Path = argument("folder that holds the runs", "FOLDER", Path("runs"), completion="")
    where: str | None = option(
        None, "choose the runs that match a query", placeholder="QUERY", panel=CHOICE
    )
    columns: str | None = option(
        None,
        "keys of the columns, separated by commas; with --json, of the values",
        placeholder="KEY,…",
        panel=CHOICE,
    )
    sort: str | None = option(
        None,
        "sort by a key, or in descending order by -KEY",
        placeholder="KEY",
        completion="query_keys",
        panel=CHOICE,
    )
    watch: bool = option(
        False,
        "show the evolving and queued runs with their speed and load every second, until Ctrl-C",
    )
    tag: Names | None = option(
        None,
        "add a tag to the runs that match --where",
        placeholder="TAG",
        completion="tag_names",
        panel=CHANGES,
    )
    untag: Names | None = option(
        None,
        "remove a tag from the runs that match --where",
        placeholder="TAG",
        completion="tag_names",
        panel=CHANGES,
    )
    delete: Names | None = option(
        None,
        "move a run to the trash, from which 'gaitsim trash restore' restores it for 30 days",
        placeholder="RUN",
        completion="run_names",
        panel=CHANGES,
    )
    delete_matching: bool = option(
        False, "move the runs that match --where to the trash", panel=CHANGES
    )
    permanently: bool = option(
        False, "delete runs with all their files instead of moving them to the trash", panel=CHANGES
    )
    yes: bool = option(False, "change runs without asking", panel=CHANGES)
    json_lines: bool = JSON

    def do(self) -> None:
        """Print the list, or change runs."""
        check_root(self.root)
        tag = "tag" if self.tag else "untag"
        exclusive = self.flags_of("watch", "delete", "delete_matching", tag)
        if self.delete:
            exclusive += self.flags_of("where")
        if len(exclusive) > 1:
            raise not_combinable(*exclusive[:2])
        if self.permanently and not (self.delete or self.delete_matching):
            raise GaitsimError(
                "--permanently is given without runs to delete",
                remedy="add --delete RUN, or --where QUERY --delete-matching",
            )
        if self.delete:
            names = self.delete
            paths = [
                self.root / one if holds_run(self.root / one) else find_run(one) for one in names
            ]
            self._delete([*dict.fromkeys(paths)])
        else:
            self._list()

    def _list(self) -> None:
        columns = tuple(filter(None, map(str.strip, (self.columns or "").split(","))))
        sort = self.sort or ""
        with _error_at("--where"):
            query = parse_query(self.where or "")
        changing = self.tag or self.untag or self.delete_matching
        if changing and not query.conditions:
            raise GaitsimError(
                "no query chooses the runs to change",
                where="--where",
                remedy="add --where, such as --where 'state:stopped age>30d'",
            )
        if self.watch:
            from gaitsim.console.watching import watch

            watch(self.root, query, json=self.json_lines)
            return
        keys = [*columns, sort.removeprefix("-")]
        keys += [condition.key for condition in query.conditions]
        times = self.json_lines or "time" in keys
        every = list_overviews(self.root, _read_in_full, times=times, each=_with_progress)
        with _error_at("--where"):
            found = query.select(every)
        for place, given in (("--columns", columns), ("--sort", (sort.removeprefix("-"),))):
            with _error_at(place):
                check_keys(filter(None, given), every)
        if self.delete_matching:
            for run in found:
                if run.evolves:
                    notice(f"{run.path} is kept, because it is {run.state}.")
            found = [run for run in found if not run.evolves]
        if changing and not found:
            notice("No run matches, so nothing was changed.")
        elif self.delete_matching:
            self._delete([run.path for run in found])
        elif changing:
            self._tag(found)
        else:
            if sort:
                found = sort_runs(found, sort)
            self._print(found, columns, bool(every))

    def _print(self, found: Sequence[Overview], columns: Sequence[str], any_runs: bool) -> None:
        """Print runs as lines of JSON or a table."""
        if self.json_lines:
            for run in found:
                chosen = {key: value_of(run, key) for key in columns}
                print_json({"run": run.name, **chosen} if chosen else _row(run))
        elif not any_runs:
            output().print(f"No runs in {self.root}. Start one: gaitsim run spider")
        elif not found:
            output().print(f"No run in {self.root} matches {self.where!r}.")
        else:
            tagged = any(run.tags for run in found)
            columns = columns or (*COLUMNS, *(["tag"] if tagged else []))
            heads = {key: _HEADS.get(key, key) for key in columns}
            numeric = [
                head
                for key, head in heads.items()
                if any(isinstance(value_of(run, key), int | float) for run in found)
            ]
            now = time.time()
            rows = [[run_cell(run, key, now) for key in columns] for run in found]
            print_table(heads.values(), rows, numbers=numeric)
            _print_remarks(found)

    def _tag(self, found: Sequence[Overview]) -> None:
        """Change the tags of runs after confirmation, if there are several."""
        added, removed = self.tag or (), self.untag or ()
        changed = {run.path: ({*run.tags} | {*added}) - {*removed} for run in found}
        words = " ".join([*(f"+{tag}" for tag in added), *(f"-{tag}" for tag in removed)])
        what = f"change the tags of {_names([*changed])}: {words}"
        if agrees(what, yes=self.yes or len(changed) == 1):
            for path, tags in changed.items():
                result = write_tags(path, tags)
                self._report(
                    {"run": str(path), "tags": result}, f"{path}: {', '.join(result) or 'no tags'}"
                )

    def _delete(self, paths: Sequence[Path]) -> None:
        """Delete runs after confirmation, and report the failures at the end."""
        named = _names(paths)
        what = f"delete {named} permanently" if self.permanently else f"move {named} to the trash"
        if not agrees(what, yes=self.yes):
            return
        problem: GaitsimError | None = None
        for path in paths:
            try:
                if self.permanently:
                    delete_run(path)
                    self._report({"deleted": str(path)}, f"{path}: deleted")
                else:
                    trash = str(trash_run(path).path)
                    self._report({"deleted": str(path), "trash": trash}, f"{path}: in the trash")
            except GaitsimError as error:
                problem = problem or error
        if problem is not None:
            raise problem

    def _report(self, values: dict[str, Any], text: str) -> None:
        if self.json_lines:
            print_json(values)
        else:
            echo(text)


@contextmanager
def _error_at(place: str) -> Iterator[None]:
    """Name the place of an error that the block raises."""
    try:
        yield
    except GaitsimError as error:
        error.where = error.where or place
        raise


def _names(paths: Sequence[Path]) -> str:
    """Return the names of a few runs, or the number of many."""
    if len(paths) <= MOST_NAMED:
        return ", ".join(map(str, paths))
    return f"{len(paths)} runs ({', '.join(map(str, paths[:3]))}, …)"


def _print_remarks(found: Sequence[Overview]) -> None:
    """Explain Python code outside a run, and failures of background processes."""
    if any(is_outside(name) for run in found for name in run.plugins.values()):
        output().print(
            f"{PYTHON} is Python code outside the run, so the run cannot be reproduced from "
            "its files alone"
        )
    for run in found:
        if run.failure:
            notice(f"{run.path} failed: {run.failure.what}")


def _with_progress(runs: Sequence[Path]) -> Iterator[Path]:
    """Yield runs to read, and show the progress if there are many."""
    if len(runs) < MANY:
        yield from runs
        return
    from gaitsim.console.progress_bar import Progress

    with Progress("Reading", "runs", len(runs)) as progress:
        for run in runs:
            yield run
            progress.advance()


def _read_in_full(path: Path) -> Overview | None:
    from gaitsim.storage.growing import overview

    return overview(path)


def _row(run: Overview) -> dict[str, Any]:
    """Return the values of a run for JSON, without loading plugins, which may be missing."""
    return {
        "run": run.name,
        "organism": run.plugins.get("organism", ""),
        "fitness": run.plugins.get("fitness", ""),
        "search": run.plugins.get("search", ""),
        "seed": run.seed,
        "generation": run.generation,
        "generations": run.generations,
        "stage": run.stage,
        "evaluations": run.evaluations,
        "seconds": run.seconds,
        "changed": run.changed,
        "best": run.best,
        "state": run.state,
        "tags": run.tags,
        "note": run.note,
        "failure": run.failure.what if run.failure else None,
        "outside": [name for name in run.plugins.values() if is_outside(name)],
    }
