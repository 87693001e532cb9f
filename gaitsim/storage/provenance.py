"""`provenance.json`: the versions and the processor that computed a run.

On another processor, a physics engine or a plugin that is not portable may round the last bit of a
number differently. Each entry is valid from its generation; resuming with other versions adds
another entry.
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
from gaitsim.experiment import PORTABLE, Experiment
from gaitsim.opening import read_regular
from gaitsim.registry import options
from gaitsim.storage.compatibility import versions
from gaitsim.storage.files.atomic import write_bytes
from gaitsim.storage.files.folder import PROVENANCE
from gaitsim.storage.files.schema import EXACT_KEYS
from gaitsim.toml import checksum, is_long

# Settings of Numba that decide which machine code runs; interpreted kernels round differently.
_SETTINGS = ("DISABLE_JIT", "CPU_NAME", "CPU_FEATURES")
LARGEST = 10_000_000  # bytes

RESULTS = "results"
"""Name of the part that holds the class of the results, such as 'portable'."""
MACHINE = (
    "blas",
    "system",
    "libc",
    "processor",
    "compiled for",
    *(f"NUMBA_{name}" for name in _SETTINGS[1:]),
)
"""Parts that do not affect portable results."""


@dataclass(frozen=True)
class Provenance:
    """Versions and processor that computed a range of generations.

    Attributes:
        first: first of these generations.
        parts: versions by name: gaitsim, the packages of plugins, Python, the numerical libraries
            in use, their settings, and the processor; also checksums of long texts among the
            options, such as a robot.
    """

    __pydantic_config__: ClassVar[ConfigDict] = EXACT_KEYS

    first: int
    parts: dict[str, str]


_ENTRIES = TypeAdapter(list[Provenance])


def current_versions(experiment: Experiment) -> dict[str, str]:
    """Return the versions in use, complete once the first evaluation has loaded all libraries."""
    config: Any = np.show_config(mode="dicts")
    blas = config.get("Build Dependencies", {}).get("blas", {})
    found = {
        **versions(experiment),
        RESULTS: experiment.portability.partition(":")[0],
        "numba": version("numba"),
        "python": platform.python_version(),
        "blas": f"{blas.get('name', '?')} {blas.get('version', '')}".strip(),
        "system": f"{platform.system()} {platform.machine()}",
        "libc": " ".join(platform.libc_ver()) or "?",
        "processor": " ".join(config.get("SIMD Extensions", {}).get("found", [])) or "plain",
    }
    if "numba" in sys.modules:
        from llvmlite.binding import get_host_cpu_name  # comes with Numba

        settings: Any = sys.modules["numba"].config
        found |= {f"NUMBA_{name}": str(getattr(settings, name, None)) for name in _SETTINGS}
        found["compiled for"] = get_host_cpu_name()
    for kind in experiment.kinds:
        for name, value in options.values(experiment.plugin(kind)).items():
            if is_long(value):  # the checksum is in the key, as another text starts a stage
                found[f"{kind}.{name} {checksum(value)}"] = "SHA-256"
    return found


def write_provenance(folder: Path, first: int, parts: Mapping[str, str]) -> None:
    """Add an entry unless it equals the last one, and drop entries from generation `first`."""
    try:
        kept = [origin for origin in read_provenance(folder) if origin.first < first]
    except RunError:  # a damaged file must not prevent resuming
        kept = []
    if kept and kept[-1].parts == parts:
        return
    entries = [*kept, Provenance(first, dict(parts))]
    write_bytes(folder / PROVENANCE, provenance_bytes(entries), follow=False)


def provenance_bytes(entries: Sequence[Provenance]) -> bytes:
    """Return the content of a file with these entries."""
    return _ENTRIES.dump_json([*entries], indent=1) + b"\n"


def read_provenance(folder: Path) -> list[Provenance]:
    """Return the entries of a run, in order; [] without a file."""
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
    """Return the differences between the entries of a run and the current versions.

    The machine is left out if the results are portable.
    """
    found = []
    for at, origin in enumerate(origins):
        since = f" (from generation {origin.first})" if at or len(origins) > 1 else ""
        found += [
            f"{name}: {then} then, {now[name]} now{since}"
            for name, then in origin.parts.items()
            if now.get(name, then) != then
            and not (origin.parts.get(RESULTS) == PORTABLE and name in MACHINE)
        ]
    return found
