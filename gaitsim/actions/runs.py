"""`gaitsim runs`, `show`, `fork`, `note` and `rename`."""

import sys
from pathlib import Path
from typing import Any

from gaitsim.actions.action import JSON, SET, Action, OneRun, argument
from gaitsim.console.printing import confirm, echo, notice, output, print_json, print_table
from gaitsim.contracts.plugin import option
from gaitsim.contracts.product import Names
from gaitsim.errors import GaitsimError
from gaitsim.registry.entry_points import PYTHON, is_outside
from gaitsim.render.terminal.text import number
from gaitsim.storage.files.folder import check_root, command, find_run, holds_run
from gaitsim.storage.manage import delete_run, read_note, rename_run, write_note
from gaitsim.storage.overview import Overview, list_overviews


class ListRuns(Action):
    """List the runs in a folder, oldest first, or delete some of them.

    [bold]Examples[/bold]

    gaitsim runs

    gaitsim runs experiments/spring --json

    gaitsim runs --delete spider-2 --delete spider-3
    """

    root: Path = argument("folder that holds the runs", "FOLDER", Path("runs"), completion="")
    delete: Names | None = option(
        None, "delete a run with all its files", placeholder="RUN", completion="run_names"
    )
    yes: bool = option(False, "delete without asking")
    json_lines: bool = JSON

    def do(self) -> None:
        """Print the list, or delete runs."""
        check_root(self.root)
        if self.delete:
            _delete(self.root, self.delete, yes=self.yes, json=self.json_lines)
            return
        found = [_row(run) for run in list_overviews(self.root, _read_in_full)]
        if self.json_lines:
            for row in found:
                print_json(row)
        elif not found:
            output().print(f"No runs in {self.root}. Start one: gaitsim run spider")
        else:
            _print(self.root, found)


def _print(root: Path, found: list[dict[str, Any]]) -> None:
    rows = []
    for row in found:
        best = "" if row["best"] is None else number(row["best"], 4)
        done = f"{row['generation']}/{row['generations']}"
        rows.append([row["run"], row["organism"], row["fitness"], done, best, row["state"]])
    columns = "run", "body", "fitness", "generation", "best", "state"
    print_table(columns, rows, numbers=["generation", "best"])
    if any(row["outside"] for row in found):
        output().print(
            f"{PYTHON} is Python code outside the run, so the run cannot be reproduced from "
            "its files alone"
        )
    for row in found:
        if row["failure"]:
            notice(f"{root / row['run']} failed: {row['failure']}")


def _delete(root: Path, references: tuple[str, ...], *, yes: bool, json: bool) -> None:
    """Delete runs after confirmation; all of them must exist."""
    paths = [root / name if holds_run(root / name) else find_run(name) for name in references]
    named = ", ".join(map(str, dict.fromkeys(paths)))
    if not yes:
        if not sys.stdin.isatty():
            raise GaitsimError(
                f"{named} cannot be deleted: there is no terminal to confirm it",
                remedy="add --yes to delete without asking",
            )
        if not confirm(f"Delete {named}, including all exports?"):
            notice("Nothing was deleted.")
            return
    for path in dict.fromkeys(paths):
        delete_run(path)
        if json:
            print_json({"deleted": str(path)})
        else:
            echo(f"{path}: deleted")


def _read_in_full(path: Path) -> Overview | None:
    from gaitsim.storage.growing import overview

    return overview(path)


def _row(run: Overview) -> dict[str, Any]:
    """Return the row of a run, without loading plugins, which may be missing."""
    return {
        "run": run.name,
        "organism": run.plugins.get("organism", ""),
        "fitness": run.plugins.get("fitness", ""),
        "generation": run.generation,
        "generations": run.generations,
        "best": run.best,
        "state": run.state,
        "failure": run.failure.what if run.failure else None,
        "outside": [name for name in run.plugins.values() if is_outside(name)],
    }


class ShowRun(OneRun):
    """Show a run in full: its plugins, progress, stages and champion.

    A stage is a span of generations with the same options; changing an option of a run starts the
    next stage.

    [bold]Examples[/bold]

    gaitsim show spider

    gaitsim show spider --fingerprint
    """

    fingerprint: bool = option(
        False,
        "print only the fingerprint: a SHA-256 hash of all results except times, so that equal "
        "fingerprints mean equal runs",
    )

    def do(self) -> None:
        """Print the run, or its fingerprint."""
        from gaitsim.console.run_view import print_run, print_run_as_json
        from gaitsim.storage.snapshot import RunSnapshot

        run = RunSnapshot.find(self.run)
        if run.warning:
            notice(f"Warning: {run.warning}")
        if not self.fingerprint:
            for warning in run.experiment.warnings():
                notice(f"Warning: {warning}")
            (print_run_as_json if self.json_lines else print_run)(run)
        elif self.json_lines:
            print_json({"run": str(run.path), "fingerprint": run.fingerprint()})
        else:
            echo(run.fingerprint())


class Fork(OneRun):
    """Copy a run, for example to continue the copy with changed options.

    The copy has the run's last generation, history and champions, so it continues from the last
    generation. Use 'gaitsim run --from RUN@N' to start a new run from the best individual of an
    earlier generation, whose whole population is not stored. The original is not changed, and may
    be evolving during the copy.

    [bold]Examples[/bold]

    gaitsim fork spider

    gaitsim fork spider --set fitness.yaw_weight=8 --generations 300
    """

    out: Path | None = option(
        None,
        "folder of the copy",
        unset="the run's folder name with a number",
        placeholder="FOLDER",
    )
    set_: Names | None = SET
    generations: int | None = option(
        None, "continue the copy up to this generation", unset="the number originally planned"
    )
    any_version: bool = option(False, "copy even if a plugin's package has changed version")

    def do(self) -> None:
        """Copy the run."""
        from gaitsim.experiment import parse_assignments
        from gaitsim.storage.creation import fork_run
        from gaitsim.storage.snapshot import RunSnapshot

        source, changes = find_run(self.run), parse_assignments(self.set_ or ())
        path = fork_run(
            source,
            self.out,
            changes,
            generations=self.generations,
            any_version=self.any_version,
        )
        generation = RunSnapshot(path).generation
        if self.json_lines:
            print_json({"run": str(path), "of": str(source), "generation": generation})
            return
        echo(f"{path}: a copy of {source} at generation {generation}")
        notice(f"Continue with: {command('resume', path)}")


class EditNote(OneRun):
    """Show or write the note of a run.

    A note is free text, stored in the run's folder.

    [bold]Examples[/bold]

    gaitsim note spider "Straight, but it drags its left hind leg."

    gaitsim note spider
    """

    text: str | None = argument(
        "text of the new note; '' removes the note",
        "TEXT",
        None,
        unset="print the note",
        completion="",
    )

    def do(self) -> None:
        """Print the note, or store a new one."""
        path = find_run(self.run)
        if self.text is not None:
            write_note(path, self.text)
        found = read_note(path)
        if self.json_lines:
            print_json({"run": str(path), "note": found})
        elif self.text is not None:
            echo(f"{path}: note {'saved' if found else 'removed'}")
        elif found:
            echo(found)
        else:
            notice(f"{path} has no note.")


class Rename(OneRun):
    """Rename a run.

    The run's folder gets a new name in the same place. A run cannot be renamed while it is
    evolving.

    [bold]Examples[/bold]

    gaitsim rename spider-2 bold
    """

    name: str = argument("new name of the run's folder", "NAME", completion="")

    def do(self) -> None:
        """Rename the folder."""
        before = find_run(self.run)
        after = rename_run(before, self.name)
        if self.json_lines:
            print_json({"run": str(after), "was": str(before)})
        else:
            echo(f"{before} is now {after}")
