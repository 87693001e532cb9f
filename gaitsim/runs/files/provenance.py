"""`provenance.json`: the versions and the processor that a run was made with.

Another processor may round the last bit of a number differently. An entry holds from its
generation on; another one follows where other versions resume the run.
"""

import json
import platform
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from gaitsim.errors import RunError
from gaitsim.experiment import Experiment
from gaitsim.runs.compatibility import versions
from gaitsim.runs.files.atomic import write_bytes
from gaitsim.runs.files.folder import PROVENANCE

LARGEST = 10_000_000  # bytes


@dataclass(frozen=True)
class Provenance:
    """What generations were made with.

    Attributes:
        first: the generation from which on this holds.
        parts: names and versions: of gaitsim, its plugins' packages, Python, the numerical
            libraries that were used, and the processor.
    """

    first: int
    parts: Mapping[str, str]


def current_versions(experiment: Experiment) -> dict[str, str]:
    """What is used now; ask after the first evaluation, when all that is used is loaded."""
    config: Any = np.show_config(mode="dicts")
    blas = config.get("Build Dependencies", {}).get("blas", {})
    found = {
        **versions(experiment),
        "python": platform.python_version(),
        "blas": f"{blas.get('name', '?')} {blas.get('version', '')}".strip(),
        "system": f"{platform.system()} {platform.machine()}",
        "processor": " ".join(config.get("SIMD Extensions", {}).get("found", [])) or "plain",
    }
    if "numba" in sys.modules:
        from llvmlite.binding import get_host_cpu_name  # comes with Numba

        found["numba"] = version("numba")
        # What compiled code is made for.
        found["processor"] = f"{get_host_cpu_name()}, {found['processor']}"
    if "pymunk" in sys.modules:
        found["pymunk"] = version("pymunk")
    return found


def write_provenance(folder: Path, first: int, parts: Mapping[str, str]) -> None:
    """Add an entry, unless the one before says the same; those from `first` on are dropped.

    Raises:
        RunError: it cannot be written.
    """
    try:
        kept = [origin for origin in read_provenance(folder) if origin.first < first]
    except RunError:  # damaged, it hinders nobody from going on
        kept = []
    if kept and kept[-1].parts == parts:
        return
    entries = [{"first": one.first, "parts": dict(one.parts)} for one in kept]
    entries.append({"first": first, "parts": dict(parts)})
    write_bytes(folder / PROVENANCE, (json.dumps(entries, indent=1) + "\n").encode())


def read_provenance(folder: Path) -> list[Provenance]:
    """The entries of a run, in order; [] where there are none.

    Raises:
        RunError: they are damaged, or cannot be read.
    """
    path = folder / PROVENANCE
    try:
        with path.open("rb") as file:
            found = json.loads(file.read(LARGEST + 1)[:LARGEST])
        if not isinstance(found, list):
            raise TypeError
        return [_origin(**entry) for entry in found]
    except FileNotFoundError:
        return []
    except OSError as error:
        raise RunError(f"cannot read {path}: {error.strerror}") from None
    except (ValueError, TypeError, RecursionError):
        raise RunError(f"{path.name} is damaged", where=str(path), remedy="remove it") from None


def _origin(first: int, parts: Mapping[str, str]) -> Provenance:
    if type(first) is not int or not all(isinstance(text, str) for text in parts.values()):
        raise TypeError
    return Provenance(first, parts)


def differences(origins: Sequence[Provenance], now: Mapping[str, str]) -> list[str]:
    """Where what a run was made with differs from what is here."""
    found = []
    for at, origin in enumerate(origins):
        since = f" (from generation {origin.first} on)" if at or len(origins) > 1 else ""
        found += [
            f"{name}: {then} then, {now[name]} now{since}"
            for name, then in origin.parts.items()
            if now.get(name, then) != then
        ]
    return found
