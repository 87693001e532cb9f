"""The performance of an atlas on the intact body, kept in its folder: a robot takes minutes."""

import hashlib
import re
from contextlib import suppress
from pathlib import Path

import numpy as np

from gaitsim.adaptation.performance import Floats
from gaitsim.errors import RunError
from gaitsim.opening import read_regular
from gaitsim.runs.files.atomic import write_bytes
from gaitsim.runs.files.folder import ADAPTATIONS, own_folder

_DIGEST = hashlib.sha256().digest_size


def read_intact(run: Path, measure: str, key: str, members: int) -> Floats | None:
    """Return the performance of each member, (members,); None where it is not known.

    Args:
        run: the folder of the atlas.
        measure: that is the performance.
        key: of all that the performance depends on.
        members: their number.
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
    """Keep the performance of each member, unless the folder cannot be written."""
    content = performance.astype("<f8").tobytes()
    with suppress(RunError):
        own_folder(run, ADAPTATIONS)
        write_bytes(_file(run, measure), _digest(key, content) + content, follow=False)


def _file(run: Path, measure: str) -> Path:
    return run / ADAPTATIONS / f"intact-{re.sub(r'[^a-zA-Z0-9]+', '-', measure)[:80]}.bin"


def _digest(key: str, content: bytes) -> bytes:
    return hashlib.sha256(key.encode() + content).digest()
