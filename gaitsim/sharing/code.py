"""Challenge codes: bytes encoded as a text for chats and shells, with a checksum.

    gaitsim1-<base64url of: length, deflated content, checksum>

The number after 'gaitsim' is the version of the format. The length counts all bytes, so that it
reveals a truncated code, and where a code ends in a text. The checksum is the beginning of the
SHA-256 hash of all bytes before it. Decoding finds the first code in a text, ignores white space,
invisible characters and the marks of quoted lines in it, and reads the '—' of chats as '--'.
"""

import base64
import hashlib
import re
import unicodedata
import zlib
from bisect import bisect_left
from functools import cache
from importlib.resources import files
from itertools import accumulate

from gaitsim.errors import GaitsimError

FORMAT = 1
PREFIX = f"gaitsim{FORMAT}-"
LONGEST = 8_000_000  # characters in a code
LARGEST = 16_000_000  # bytes of content: an experiment of up to 2 MB, and a genome
_LENGTH, _CHECKSUM = 4, 6  # bytes
_HEAD = re.compile(r"(?<![A-Za-z0-9_-])gaitsim([0-9]{1,4})-", re.IGNORECASE)
_CHARACTERS = re.compile(r"[A-Za-z0-9_-]*")
_QUOTED = re.compile(r"^[\s>|]+", re.MULTILINE)  # marks that mail programs put before lines
_FEWEST = 8  # characters that hold the length
_RAW = -zlib.MAX_WBITS  # without zlib's header and checksum

WHERE = "the challenge code"
COPY = "copy the whole code again, from 'gaitsim' to its last character"


def contains_code(text: str) -> bool:
    """Return whether a text contains a challenge code of any format."""
    return _HEAD.search(_visible(text)) is not None


def _visible(text: str) -> str:
    """Return a text without byte order marks, zero-width spaces, soft hyphens and the like."""
    if text.isascii():
        return text
    return "".join(one for one in text if unicodedata.category(one) != "Cf")


def encode(content: bytes) -> str:
    """Return content as a code."""
    packer = zlib.compressobj(zlib.Z_BEST_COMPRESSION, zlib.DEFLATED, _RAW, zdict=dictionary())
    packed = packer.compress(content) + packer.flush()
    length = _LENGTH + len(packed) + _CHECKSUM
    if len(content) > LARGEST or _characters(length) > LONGEST:
        raise GaitsimError(
            f"the individual and its experiment ({len(content):,} bytes) are too large to share",
            allowed=f"at most {LARGEST:,} bytes, and {LONGEST:,} characters once compressed",
            remedy="share the folder of the run instead",
        )
    data = length.to_bytes(_LENGTH, "big") + packed
    return PREFIX + _text(data + _checksum(data))


def decode(text: str) -> bytes:
    """Return the content of the first code in a text."""
    if len(text) > 2 * LONGEST:
        raise _damaged(f"it has {len(text):,} characters, more than the maximum of {LONGEST:,}")
    text = _visible(text)
    head = _HEAD.search(text)
    if head is None:
        raise GaitsimError(
            "the text is not a challenge code",
            allowed=f"a text with a code, which begins with {PREFIX}, as 'gaitsim share' prints it",
            remedy=COPY,
        )
    if int(head[1]) != FORMAT:
        raise GaitsimError(
            f"the challenge code has format {head[1]}",
            allowed=f"format {FORMAT}: {PREFIX}…",
            remedy="if a newer gaitsim created the code, upgrade: pip install --upgrade gaitsim",
        )
    return _inflated(_bytes(_body(text[head.end() :], len(head[0]))))


def _body(text: str, before: int) -> str:
    """Return the characters of a code after its prefix of `before` characters.

    Args:
        text: all text after the prefix; a code may be split into lines, and more text may follow.
        before: number of characters of the prefix, for messages.
    """
    words = _QUOTED.sub("", text).replace("—", "--").split()
    joined = "".join(words)
    found = _CHARACTERS.match(joined)
    body = found[0] if found else ""
    if not joined:
        raise _damaged(f"nothing follows {PREFIX}")
    if len(body) < min(_FEWEST, len(joined)):
        raise _wrong_character(joined, len(body), before)
    head = base64.urlsafe_b64decode(body[:_FEWEST].ljust(_FEWEST, "A"))
    expected = _characters(int.from_bytes(head[:_LENGTH], "big"))
    if len(body) < _FEWEST or expected > LONGEST or expected < _FEWEST:
        raise _damaged("its first characters are missing or were changed")
    ends = [*accumulate(map(len, words))]  # more words may follow the code
    if len(body) > expected and expected == ends[bisect_left(ends, expected)]:
        return body[:expected]
    if len(body) < expected <= len(joined):
        raise _wrong_character(joined, len(body), before)
    if len(body) != expected:
        raise _damaged(
            f"it should have {before + expected:,} characters but has {before + len(body):,}"
        )
    return body


def _wrong_character(joined: str, at: int, before: int) -> GaitsimError:
    return _damaged(f"character {before + at + 1} is {joined[at]!r}, which is invalid in a code")


def _bytes(body: str) -> bytes:
    """Return the bytes between the length and the checksum of a code's body."""
    data = base64.urlsafe_b64decode(body + "=" * (-len(body) % 4))
    # The last character may hold bits beyond the last byte; encoding again reveals a change there.
    whole = len(data) > _LENGTH + _CHECKSUM and _text(data) == body
    if not whole or _checksum(data[:-_CHECKSUM]) != data[-_CHECKSUM:]:
        raise _damaged("its checksum does not match: at least one character was changed")
    return data[_LENGTH:-_CHECKSUM]


def _inflated(packed: bytes) -> bytes:
    """Return the decompressed content, at most `LARGEST` bytes."""
    unpacker = zlib.decompressobj(_RAW, zdict=dictionary())
    try:
        content = unpacker.decompress(packed, LARGEST)
    except zlib.error:
        raise invalid("its content cannot be decompressed") from None
    if not unpacker.eof or unpacker.unused_data:
        raise invalid(f"its content is incomplete or larger than {LARGEST:,} bytes")
    return content


def invalid(what: str) -> GaitsimError:
    """Return the error for a code that is undamaged but was not written by gaitsim."""
    return GaitsimError(
        f"the challenge code is invalid: {what}",
        allowed="a code printed by 'gaitsim share RUN'",
        remedy="ask its author for a new code",
    )


def _damaged(what: str) -> GaitsimError:
    return GaitsimError(f"the challenge code is damaged: {what}", remedy=COPY)


def _checksum(data: bytes) -> bytes:
    return hashlib.sha256(data).digest()[:_CHECKSUM]


def _text(data: bytes) -> str:
    return base64.urlsafe_b64encode(data).rstrip(b"=").decode()


def _characters(length: int) -> int:
    """Return the number of base64 characters that encode `length` bytes."""
    return -(-length * 4 // 3)


@cache
def dictionary() -> bytes:
    """Return the compression dictionary: texts found in most codes, the most frequent last.

    It holds the compact TOML of presets and the versions of a run, at most 32 kB. Reading any
    code of this format requires it, so it must never change.
    """
    return files("gaitsim.sharing").joinpath(f"dictionary-{FORMAT}.txt").read_bytes()
