"""A page: one HTML file with its scripts and data, that asks the network for nothing."""

import base64
import gzip
import hashlib
import json
from collections.abc import Iterable, Mapping
from functools import cache
from importlib.resources import files
from typing import Any

from gaitsim.render.html import escaped, head
from gaitsim.render.page import assets

_ESCAPED = {ord(char): f"\\u{ord(char):04x}" for char in "<>&\u2028\u2029"}

_PAGE = """{head}<body>
<main id="gaitsim">
<h1>{title}</h1>
<p>{description}</p>
<noscript><p>The motion and the numbers need JavaScript, which is switched off.</p></noscript>
</main>
<script type="application/json" id="data">{data}</script>
{packed}
<script>{boot}</script>
</body>
</html>
"""


def document(
    title: str,
    kind: str,
    data: Mapping[str, Any],
    scripts: Iterable[str] = (),
    *,
    description: str = "",
) -> bytes:
    """Return a page of the viewer, in UTF-8.

    The policy of the page allows the scripts in it and nothing else: no other script, and no
    request. The same arguments give the same bytes.

    Args:
        title: of the page.
        kind: of the page, by which its scripts show the data.
        data: numbers, texts, lists and mappings; numbers are finite.
        scripts: texts of further scripts, such as that of a kind of page.
        description: of the page, as a browser without JavaScript shows it.

    Raises:
        ValueError: a number is not finite.
    """
    boot = asset(assets.BOOT)
    texts = [_viewer(), *map(_enclosed, scripts)]
    hashes = " ".join(f"'sha256-{_digest(text)}'" for text in [*texts, boot])
    style = "\n".join(asset(name) for name in assets.STYLES)
    page = _PAGE.format(
        head=head(title, f"img-src data: blob:; script-src {hashes}", style),
        title=escaped(title),
        description=escaped(description),
        data=_json({"kind": kind, **data}),
        packed="\n".join(
            f'<script type="text/plain" class="packed">{_packed(text)}</script>' for text in texts
        ),
        boot=boot,
    )
    return page.encode()


@cache
def asset(name: str) -> str:
    """Return the text of a script or style of the viewer, by its file's name."""
    return (files(assets) / name).read_text(encoding="utf-8").replace("\r\n", "\n")


@cache
def _viewer() -> str:
    """Return the library and the viewer, as one script."""
    own = "\n".join(asset(name) for name in assets.VIEWER)
    return f"{asset(assets.LIBRARY)}\n{_enclosed(own)}"


def _enclosed(text: str) -> str:
    """Return a script whose names are its own."""
    return f'(function () {{\n"use strict";\n{text}\n}})();\n'


@cache
def _packed(text: str) -> str:
    # Without the time and the system, which gzip would write.
    return base64.b64encode(gzip.compress(text.encode(), 9, mtime=0)).decode()


def _digest(text: str) -> str:
    return base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()


def _json(data: Mapping[str, Any]) -> str:
    """Return JSON that ends no script element; characters beyond ASCII are escaped."""
    return json.dumps(data, allow_nan=False, separators=(",", ":")).translate(_ESCAPED)
