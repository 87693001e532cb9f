"""`provenance.json`: the versions and the processor that a run was made with.

Another processor may round the last bit of a number differently. An entry holds from its
generation on; another one follows where other versions resume the run.
"""

import platform
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from pydantic import ConfigDict, TypeAdapter, ValidationError

from gaitsim.errors import RunError
from gaitsim.experiment import Experiment
from gaitsim.opening import read_regular
from gaitsim.registry import options
from gaitsim.runs.compatibility import versions
from gaitsim.runs.files.atomic import write_bytes
from gaitsim.runs.files.folder import PROVENANCE
from gaitsim.runs.files.schema import EXACT_KEYS
from gaitsim.toml import checksum, is_long

# Settings of Numba that decide which machine code runs; interpreted kernels round differently.
_SETTINGS = ("DISABLE_JIT", "CPU_NAME", "CPU_FEATURES")
LARGEST = 10_000_000  # bytes


@dataclass(frozen=True)
class Provenance:
    """Versions and processor that generations were made with.

    Attributes:
        first: the first of these generations.
        parts: names and versions: of gaitsim, its plugins' packages, Python, the numerical
            libraries that were used, their settings, and the processor; the checksums of long
            texts among the options, such as a robot.
    """

    __pydantic_config__: ClassVar[ConfigDict] = EXACT_KEYS

    first: int
    parts: dict[str, str]


_ENTRIES = TypeAdapter(list[Provenance])


def current_versions(experiment: Experiment) -> dict[str, str]:
    """Return what is used now; complete after the first evaluation, when all is loaded."""
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

        settings: Any = sys.modules["numba"].config
        found |= {f"NUMBA_{name}": str(getattr(settings, name, None)) for name in _SETTINGS}
        found["numba"] = version("numba")
        # What compiled code is made for.
        found["processor"] = f"{get_host_cpu_name()}, {found['processor']}"
    for kind in experiment.kinds:
        for name, value in options.values(experiment.plugin(kind)).items():
            if is_long(value):  # in the key: another text is another stage, not another version
                found[f"{kind}.{name} {checksum(value)}"] = "SHA-256"
    return found


def write_provenance(folder: Path, first: int, parts: Mapping[str, str]) -> None:
    """Add an entry, unless the one before is equal; drop entries from `first` on.

    Raises:
        RunError: it cannot be written.
    """
    try:
        kept = [origin for origin in read_provenance(folder) if origin.first < first]
    except RunError:  # a damaged file must not prevent resuming
        kept = []
    if kept and kept[-1].parts == parts:
        return
    entries = [*kept, Provenance(first, dict(parts))]
    write_bytes(folder / PROVENANCE, provenance_bytes(entries), follow=False)


def provenance_bytes(entries: Sequence[Provenance]) -> bytes:
    """Return the content of the file of these entries."""
    return _ENTRIES.dump_json([*entries], indent=1) + b"\n"


def read_provenance(folder: Path) -> list[Provenance]:
    """Return the entries of a run, in order; [] without a file.

    Raises:
        RunError: they are damaged, or cannot be read.
    """
    path = folder / PROVENANCE
    try:
        return _ENTRIES.validate_json(read_regular(path, LARGEST), strict=True)
    except FileNotFoundError:
        return []
    except OSError as error:
        raise RunError(f"cannot read {path}: {error.strerror}", remedy="remove it") from None
    except ValidationError:
        raise RunError(f"{path.name} is damaged", where=str(path), remedy="remove it") from None


def differences(origins: Sequence[Provenance], now: Mapping[str, str]) -> list[str]:
    """Return the differences between the entries of a run and the versions here."""
    found = []
    for at, origin in enumerate(origins):
        since = f" (from generation {origin.first} on)" if at or len(origins) > 1 else ""
        found += [
            f"{name}: {then} then, {now[name]} now{since}"
            for name, then in origin.parts.items()
            if now.get(name, then) != then
        ]
    return found
