"""Files that describe a body, such as a robot's URDF, and the bodies that read them.

An entry point of the group `gaitsim.files` has the suffix of such files as its name. Its value is
the class of the body, as in the group `gaitsim.organism`, with the option that takes the path:
`urdf = "gaitsim_robot.organism:Robot.model"`. No plugin is imported to find it.
"""

import os
from pathlib import Path

from gaitsim.errors import GaitsimError
from gaitsim.experiment.reader import LONGEST_NAME, NOT_IN_NAMES
from gaitsim.registry import FILES, Entry, contract_error, entries, find


def is_body_file(reference: str) -> bool:
    """Return whether a reference to an experiment has the suffix of a body's file."""
    return Path(reference).suffix[1:].lower() in entries(FILES)


def reader_of(path: Path) -> tuple[str, str]:
    """Return the name of the body that reads a file, and its option that takes the path.

    Raises:
        GaitsimError: there is no such file, or no body reads it.
        PluginError: the packages contradict one another.
    """
    if not is_body_file(str(path)):
        raise GaitsimError(
            f"{path} is not a file that describes a body",
            allowed=", ".join(f".{suffix}" for suffix in entries(FILES)),
        )
    entry = find(FILES, path.suffix[1:].lower())
    # os.path, unlike pathlib, answers for names that no file can have, too.
    if not os.path.isfile(path):  # noqa: PTH113
        found = "it is not a file" if os.path.lexists(path) else "file not found"
        raise GaitsimError(f"{found}: {path}", remedy="check the path")
    if body := _body_of(entry):
        return body, entry.target.rpartition(".")[2]
    raise contract_error(
        entry,
        "names no body of this package",
        "the class and the option of an organism, such as package.module:Robot.model",
    )


def _body_of(entry: Entry) -> str:
    """Return the name of the body whose option an entry names; '' where there is none."""
    of = entry.target.rpartition(".")[0], entry.package
    named = (
        name
        for name, claims in entries("organism").items()
        if any((one.target, one.package) == of for one in claims)
    )
    return next(named, "")


def experiment_name(path: Path) -> str:
    """Return the name of a file's experiment: the file's, with '-' for what names cannot have."""
    stem = "".join(c if c.isprintable() and c not in NOT_IN_NAMES else "-" for c in path.stem)
    short = stem.encode()[: LONGEST_NAME // 2].decode(errors="ignore")
    return short.strip(" .-") or "experiment"


def readers() -> dict[str, list[str]]:
    """Return the suffixes that each body reads, by its name; without formats that no body reads."""
    found: dict[str, list[str]] = {}
    for suffix, claims in entries(FILES).items():
        for entry in claims:
            if body := _body_of(entry):
                found.setdefault(body, []).append(suffix)
    return found
