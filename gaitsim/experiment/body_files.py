"""Files that describe a body, such as a robot's URDF, and the bodies that read them.

The name of an entry point of the group `gaitsim.files` is the suffix of such files. Its value is
the class of the body, as in the group `gaitsim.organism`, followed by the option that takes the
path: `urdf = "gaitsim_robot.organism:Robot.model"`. The lookup does not import any plugin.
"""

import os
from pathlib import Path

from gaitsim.errors import GaitsimError
from gaitsim.experiment.reader import LONGEST_NAME, NOT_IN_NAMES
from gaitsim.registry import FILES, Entry, contract_error, entries, find


def is_body_file(reference: str) -> bool:
    """Return whether a reference to an experiment ends with the suffix of a body's file."""
    return Path(reference).suffix[1:].lower() in entries(FILES)


def reader_of(path: Path) -> tuple[str, str]:
    """Return the name of the body that reads a file, and the option that takes its path."""
    if not is_body_file(str(path)):
        raise GaitsimError(
            f"{path} is not a file that describes a body",
            allowed=", ".join(f".{suffix}" for suffix in entries(FILES)),
        )
    entry = find(FILES, path.suffix[1:].lower())
    # Unlike pathlib, os.path does not raise an error for an invalid file name.
    if not os.path.isfile(path):  # noqa: PTH113
        found = "not a file" if os.path.lexists(path) else "file not found"
        raise GaitsimError(f"{found}: {path}", remedy="check the path")
    # The entry point must refer to a body of the same package.
    if body := _body_of(entry):
        return body, entry.target.rpartition(".")[2]
    raise contract_error(
        entry,
        "does not refer to a body of this package",
        "the class and the option of an organism, such as package.module:Robot.model",
    )


def _body_of(entry: Entry) -> str:
    """Return the name of the body to which an entry refers; '' if it does not exist."""
    body = entry.target.rpartition(".")[0], entry.package
    names = (
        name
        for name, claims in entries("organism").items()
        if any((one.target, one.package) == body for one in claims)
    )
    return next(names, "")


def experiment_name(path: Path) -> str:
    """Return a name for the experiment of a file: the file's name without invalid characters."""
    stem = "".join(c if c.isprintable() and c not in NOT_IN_NAMES else "-" for c in path.stem)
    short = stem.encode()[: LONGEST_NAME // 2].decode(errors="ignore")
    return short.strip(" .-") or "experiment"


def readers() -> dict[str, list[str]]:
    """Return the suffixes of the files that each body reads, by the name of the body."""
    found: dict[str, list[str]] = {}
    for suffix, claims in entries(FILES).items():
        for entry in claims:
            if body := _body_of(entry):
                found.setdefault(body, []).append(suffix)
    return found
