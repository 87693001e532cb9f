"""Pages: single HTML files with their scripts and data, which make no network requests."""

import base64
import gzip
import hashlib
import html
import json
from collections.abc import Iterable, Mapping
from functools import cache
from importlib.metadata import version
from importlib.resources import files
from typing import Any

from gaitsim.plugin.pictures import visible
from gaitsim_page import assets

POLICY = "default-src 'none'; base-uri 'none'; form-action 'none'; style-src 'unsafe-inline'"
"""The content security policy of every page: no scripts and no requests unless added to it."""

_HEAD = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<meta name="referrer" content="no-referrer">
<meta name="generator" content="{made}">
<title>{title}</title>
<style>
{style}
</style>
</head>
"""

_ESCAPED = {ord(char): f"\\u{ord(char):04x}" for char in "<>&\u2028\u2029"}

_PAGE = """{head}<body>
<main id="gaitsim">
<h1>{title}</h1>
<p>{description}</p>
<noscript><p>This page requires JavaScript, which is disabled.</p></noscript>
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
    computes: bool = False,
) -> bytes:
    """Return a page of the viewer, in UTF-8.

    The policy of the page allows only the scripts in it, and no requests. The same arguments give
    the same bytes.

    Args:
        title: title of the page.
        kind: kind of page, which selects the script that shows the data.
        data: data of the page: finite numbers, strings, lists and mappings.
        scripts: additional scripts, such as the script of the kind of page.
        description: description of the page, shown without JavaScript.
        computes: whether its scripts start a worker, from a text in them, and run WebAssembly.
    """
    boot = asset(assets.BOOT)
    texts = [_viewer(), *map(_in_function, scripts)]
    hashes = " ".join(f"'sha256-{_digest(text)}'" for text in [*texts, boot])
    style = "\n".join(asset(name) for name in assets.STYLES)
    computing = " 'wasm-unsafe-eval'; worker-src blob:" if computes else ""
    page = _PAGE.format(
        head=head(title, f"img-src data: blob:; script-src {hashes}{computing}", style),
        title=escaped(title),
        description=escaped(description),
        data=_json({"kind": kind, **data}),
        packed="\n".join(
            f'<script type="text/plain" class="packed">{_compress(text)}</script>' for text in texts
        ),
        boot=boot,
    )
    return page.encode()


@cache
def asset(name: str) -> str:
    """Return the text of a script or style sheet of the viewer, by its file name."""
    return (files(assets) / name).read_text(encoding="utf-8").replace("\r\n", "\n")


@cache
def _viewer() -> str:
    """Return the library and the viewer as one script."""
    own = "\n".join(asset(name) for name in assets.VIEWER)
    return f"{asset(assets.LIBRARY)}\n{_in_function(own)}"


def _in_function(text: str) -> str:
    """Return a script with a scope of its own."""
    return f'(function () {{\n"use strict";\n{text}\n}})();\n'


@cache
def _compress(text: str) -> str:
    # gzip would write the current time, which would change the bytes.
    return base64.b64encode(gzip.compress(text.encode(), 9, mtime=0)).decode()


def _digest(text: str) -> str:
    return base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()


def _json(data: Mapping[str, Any]) -> str:
    """Return JSON that cannot end a script element; characters beyond ASCII are escaped."""
    return json.dumps(data, allow_nan=False, separators=(",", ":")).translate(_ESCAPED)


def head(title: str, allowed: str, style: str) -> str:
    """Return the beginning of an HTML file, up to its body.

    Args:
        title: title of the page.
        allowed: directives added to `POLICY`, such as "img-src data:".
        style: style sheet of the page.
    """
    policy = f"{POLICY}; {allowed}"
    return _HEAD.format(
        policy=policy, made=escaped(program_version()), title=escaped(title), style=style
    )


def escaped(text: str) -> str:
    """Return text as HTML, with control characters and direction marks shown as escapes."""
    return html.escape(visible(text))


def program_version() -> str:
    """Return the name and version of this program."""
    return f"gaitsim {version('gaitsim')}"
