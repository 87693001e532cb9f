"""Common parts of HTML files: a head whose policy forbids requests, and escaped text."""

import html
from importlib.metadata import version

from gaitsim.render.terminal.text import visible

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
