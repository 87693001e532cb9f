"""`gaitsim show`, `fork`, `note`, `tag` and `rename`."""

from pathlib import Path

from gaitsim.actions.action import SET, OneRun, argument
from gaitsim.console.printing import echo, notice, print_json
from gaitsim.contracts.plugin import option
from gaitsim.contracts.product import Names
from gaitsim.storage.files.folder import command, find_run
from gaitsim.storage.manage import read_note, read_tags, rename_run, write_note, write_tags


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


class EditTags(OneRun):
    """Show, add or remove tags of a run.

    Tags are words to find and group runs, stored in the run's folder. Use 'gaitsim runs --where
    QUERY --tag TAG' to tag several runs at once.

    [bold]Examples[/bold]

    gaitsim tag spider good straight

    gaitsim tag spider --remove good

    gaitsim tag spider
    """

    tags: Names | None = argument(
        "tags to add", "TAG", None, unset="print the tags", completion="tag_names"
    )
    remove: Names | None = option(None, "remove a tag", placeholder="TAG", completion="tag_names")

    def do(self) -> None:
        """Print the tags, or store new ones."""
        path = find_run(self.run)
        found = read_tags(path)
        changed = bool(self.tags or self.remove)
        if changed:
            found = write_tags(path, {*found, *(self.tags or ())} - {*(self.remove or ())})
        if self.json_lines:
            print_json({"run": str(path), "tags": found})
        elif changed:
            echo(f"{path}: {', '.join(found) or 'no tags'}")
        elif found:
            echo("\n".join(found))
        else:
            notice(f"{path} has no tags.")


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
