"""A challenge code: bytes as a text that survives chats and shells, and shows any damage.

    gaitsim1-<base64url of: length, deflated content, checksum>

The number after 'gaitsim' is the format. The length is that of all bytes, so that a code that was
cut short says so. The checksum is the beginning of the SHA-256 of all bytes before it. White space
within a code is ignored, and so are quotes around it, and that chats write '—' for two hyphens.
"""

import base64
import hashlib
import re
import zlib
from functools import cache
from importlib.resources import files
from string import ascii_letters, digits

from gaitsim.errors import GaitsimError

FORMAT = 1
PREFIX = f"gaitsim{FORMAT}-"
LONGEST = 8_000_000  # characters of a code
LARGEST = 16_000_000  # bytes of its content: an experiment of 2 MB, and a genome
_LENGTH, _CHECKSUM = 4, 6  # bytes
_HEAD = re.compile(r"gaitsim([0-9]{1,4})-", re.IGNORECASE)
_CHARACTERS = frozenset(ascii_letters + digits + "-_")
_AROUND = "`'\"<>"  # marks that chats and mails put around a text
_RAW = -zlib.MAX_WBITS  # no header, no checksum of zlib's own

WHERE = "the challenge code"
COPY = "copy the whole code again, from 'gaitsim' to its last character"


def looks_like_code(text: str) -> bool:
    """Return whether a text begins as a challenge code does, of any format."""
    return _HEAD.match(text.lstrip().lstrip(_AROUND)) is not None


def encode(content: bytes) -> str:
    """Return the code of some content.

    Raises:
        GaitsimError: it is too large.
    """
    packer = zlib.compressobj(zlib.Z_BEST_COMPRESSION, zlib.DEFLATED, _RAW, zdict=_dictionary())
    packed = packer.compress(content) + packer.flush()
    length = _LENGTH + len(packed) + _CHECKSUM
    if len(content) > LARGEST or _characters(length) > LONGEST:
        raise GaitsimError(
            f"{len(content):,} bytes are too many for a challenge code",
            allowed=f"at most {LARGEST:,}, and {LONGEST:,} characters compressed",
            remedy="share the folder of the run instead",
        )
    data = length.to_bytes(_LENGTH, "big") + packed
    return PREFIX + _text(data + _checksum(data))


def decode(text: str) -> bytes:
    """Return the content of a code.

    Raises:
        GaitsimError: it is not a code, is of another format, or was damaged: characters were
            changed, added or lost.
    """
    if len(text) > 2 * LONGEST:
        raise _damaged(f"it is longer than any, {len(text):,} characters")
    code = "".join(text.split()).strip(_AROUND).replace("—", "--")
    head = _HEAD.match(code)
    if head is None:
        raise GaitsimError(
            "the text is not a challenge code",
            allowed=f"a text that begins with {PREFIX}, as 'gaitsim share RUN' prints it",
            remedy=COPY,
        )
    if int(head[1]) != FORMAT:
        raise GaitsimError(
            f"the challenge code is of format {head[1]}",
            allowed=f"format {FORMAT}: {PREFIX}…",
            remedy="update gaitsim if the code is of a newer one: pip install --upgrade gaitsim",
        )
    return _inflated(_bytes(code[head.end() :], head.end()))


def _bytes(body: str, before: int) -> bytes:
    """Return the bytes between length and checksum of what follows the `before` first characters.

    Raises:
        GaitsimError: they are damaged.
    """
    for at, character in enumerate(body, before + 1):
        if character not in _CHARACTERS:
            raise _damaged(f"character {at} is {character!r}, which no code contains")
    head = base64.urlsafe_b64decode(body[:8].ljust(8, "A"))
    expected = _characters(int.from_bytes(head[:_LENGTH], "big"))
    if len(body) != expected:
        raise _damaged(
            f"it should have {before + expected:,} characters, and has {before + len(body):,}"
        )
    data = base64.urlsafe_b64decode(body + "=" * (-len(body) % 4))
    # The last character may hold bits that no byte has.
    whole = len(data) > _LENGTH + _CHECKSUM and _text(data) == body
    if not whole or _checksum(data[:-_CHECKSUM]) != data[-_CHECKSUM:]:
        raise _damaged("its checksum does not match: at least one character was changed")
    return data[_LENGTH:-_CHECKSUM]


def _inflated(packed: bytes) -> bytes:
    """Return content of at most `LARGEST` bytes.

    Raises:
        GaitsimError: it is larger, or was not written by `encode`.
    """
    unpacker = zlib.decompressobj(_RAW, zdict=_dictionary())
    try:
        content = unpacker.decompress(packed, LARGEST)
    except zlib.error:
        raise invalid("its content cannot be decompressed") from None
    if not unpacker.eof or unpacker.unused_data:
        raise invalid(f"its content does not end, or is larger than {LARGEST:,} bytes")
    return content


def invalid(what: str) -> GaitsimError:
    """Return the error of a code that is undamaged, but not one that gaitsim writes."""
    return GaitsimError(
        f"the challenge code is invalid: {what}",
        allowed="a code as 'gaitsim share RUN' prints it",
        remedy="ask its author for another one",
    )


def _damaged(what: str) -> GaitsimError:
    return GaitsimError(f"the challenge code is damaged: {what}", remedy=COPY)


def _checksum(data: bytes) -> bytes:
    return hashlib.sha256(data).digest()[:_CHECKSUM]


def _text(data: bytes) -> str:
    return base64.urlsafe_b64encode(data).rstrip(b"=").decode()


def _characters(length: int) -> int:
    """Return the number of characters of so many bytes."""
    return -(-length * 4 // 3)


@cache
def _dictionary() -> bytes:
    """Return texts that are in most codes, the most frequent last.

    Every code of this format is read with it, so it never changes: 32 kB at most, the compact
    TOML of presets and the versions of a run.
    """
    return files("gaitsim.sharing").joinpath(f"dictionary-{FORMAT}.txt").read_bytes()
