"""`gaitsim trash list`, `restore` and `empty`."""

import time
from pathlib import Path

from gaitsim.actions.action import JSON, Action, argument
from gaitsim.console.printing import agrees, echo, print_json, print_table
from gaitsim.contracts.plugin import option
from gaitsim.errors import unknown
from gaitsim.render.terminal.text import age, ago
from gaitsim.storage.files.folder import RUNS, check_root
from gaitsim.storage.manage import KEPT, empty_trash, list_trash, restore_run

DAY = 86400  # seconds


class ListTrash(Action):
    """List the deleted runs of a folder, latest first.

    They are deleted permanently when another run is deleted after 30 days.

    [bold]Example[/bold]

    gaitsim trash list
    """

    root: Path = argument("folder that held the runs", "FOLDER", RUNS, completion="")
    json_lines: bool = JSON

    def do(self) -> None:
        """Print the list."""
        check_root(self.root)
        found = list_trash(self.root)
        if self.json_lines:
            for run in found:
                print_json({"run": run.name, "path": str(run.path), "deleted": run.deleted})
        elif found:
            now = time.time()
            rows = [
                [run.name, ago(now - run.deleted), age(max(run.deleted + KEPT - now, 0.0))]
                for run in found
            ]
            print_table(["run", "deleted", "kept for"], rows)
        else:
            echo(f"The trash of {self.root} is empty.")


class RestoreRun(Action):
    """Restore a deleted run from the trash; the latest, if several have the name.

    [bold]Examples[/bold]

    gaitsim trash restore spider-2

    gaitsim trash restore spider-2 --name bold
    """

    run: str = argument("name of the run", "RUN", completion="trash_names")
    root: Path = argument("folder that held the run", "FOLDER", RUNS, completion="")
    name: str = option("", "new name of the run", unset="its old name", placeholder="NAME")
    json_lines: bool = JSON

    def do(self) -> None:
        """Move the run back."""
        check_root(self.root)
        found = {run.name: run for run in reversed(list_trash(self.root))}
        if self.run not in found:
            error = unknown("run in the trash", self.run, found, where=str(self.root))
            error.allowed = error.allowed or "none; the trash is empty"
            raise error
        path = restore_run(found[self.run], self.name)
        if self.json_lines:
            print_json({"run": str(path)})
        else:
            echo(f"{path}: restored")


class EmptyTrash(Action):
    """Delete the runs in the trash permanently.

    [bold]Examples[/bold]

    gaitsim trash empty

    gaitsim trash empty --older-than 7 --yes
    """

    root: Path = argument("folder that held the runs", "FOLDER", RUNS, completion="")
    older_than: float = option(
        0.0,
        "delete only runs that were deleted more than this number of days ago",
        ge=0,
        le=36500,
        placeholder="DAYS",
    )
    yes: bool = option(False, "delete without asking")
    json_lines: bool = JSON

    def do(self) -> None:
        """Delete the runs after confirmation."""
        check_root(self.root)
        oldest = time.time() - self.older_than * DAY
        count = sum(run.deleted <= oldest for run in list_trash(self.root))
        runs = "1 run" if count == 1 else f"{count} runs"
        if not agrees(f"delete {runs} permanently", yes=self.yes or not count):
            return
        deleted = empty_trash(self.root, self.older_than * DAY)
        if self.json_lines:
            for run in deleted:
                print_json({"deleted": run.name})
        else:
            runs = "1 run" if len(deleted) == 1 else f"{len(deleted)} runs"
            echo(f"{runs} deleted permanently")
