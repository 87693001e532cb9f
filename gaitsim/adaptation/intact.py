"""Cache of the performance of an atlas on the intact body, as computing it can take minutes."""

import hashlib
import re
from contextlib import suppress
from pathlib import Path

import numpy as np

from gaitsim.adaptation.performance import Floats
from gaitsim.errors import RunError
from gaitsim.opening import read_regular
from gaitsim.runs.files.atomic import write_bytes
from gaitsim.runs.files.folder import ADAPTATIONS, create_subfolder

_DIGEST = hashlib.sha256().digest_size


def read_intact(run: Path, measure: str, key: str, members: int) -> Floats | None:
    """Return the cached performance of each member, (members,); None if it is not cached.

    Args:
        run: folder of the atlas.
        measure: name of the performance measure.
        key: string that identifies everything on which the performance depends.
        members: number of members.
    """
    try:
        data = read_regular(_file(run, measure), _DIGEST + 8 * members)
    except OSError:
        return None
    digest, content = data[:_DIGEST], data[_DIGEST:]
    if len(content) != 8 * members or digest != _digest(key, content):
        return None
    found = np.frombuffer(content, "<f8").astype(np.float64)
    return found if np.isfinite(found).all() else None


def write_intact(run: Path, measure: str, key: str, performance: Floats) -> None:
    """Cache the performance of each member; do nothing if the folder cannot be written."""
    content = performance.astype("<f8").tobytes()
    with suppress(RunError):
        create_subfolder(run, ADAPTATIONS)
        write_bytes(_file(run, measure), _digest(key, content) + content, follow=False)


def _file(run: Path, measure: str) -> Path:
    return run / ADAPTATIONS / f"intact-{re.sub(r'[^a-zA-Z0-9]+', '-', measure)[:80]}.bin"


def _digest(key: str, content: bytes) -> bytes:
    return hashlib.sha256(key.encode() + content).digest()
