"""`gaitsim serve`: the terminal UI in a browser."""

import os
import secrets
import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer

from gaitsim.plugin import GaitsimError, read_regular
from gaitsim.plugin.commands import Root, ThemeName, notice

LONGEST_TOKEN = 4096  # bytes


def serve(
    root: Root = Path("runs"),
    host: Annotated[
        str,
        typer.Option(
            metavar="ADDRESS", help="Address to listen on; the default admits only this machine."
        ),
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=1, max=65535, help="Port to listen on.")] = 8000,
    theme: ThemeName = None,
    token_file: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="File with the token that the address must contain; GAITSIM_TOKEN can also hold "
            "it. Default: a new random token at each start.",
        ),
    ] = None,
    windows: Annotated[
        int,
        typer.Option(min=1, max=1000, help="Maximum number of browser windows at the same time."),
    ] = 8,
) -> None:
    """Open the terminal UI in a browser, by default on this machine only.

    Each browser window runs its own app. The printed address contains a token, without which
    access is denied. A token of your own is read from a file or from GAITSIM_TOKEN, as other
    users of this machine can see the arguments of a command.

    [bold]Examples[/bold]

    gaitsim serve

    gaitsim serve experiments/spring --port 8080

    ssh -t -L 8000:127.0.0.1:8000 lab gaitsim serve
    """
    from gaitsim.screen import check_theme
    from gaitsim_serve.server import WebServer, is_loopback, listening_socket

    chosen = check_theme(theme, where="--theme") if theme else None
    token = _token(token_file)
    with listening_socket(host, port) as socket:
        if not is_loopback(host):
            notice(
                f"Warning: {host} can be reached from other machines, and nothing is encrypted: "
                "anyone who can read the network traffic can take the token and start, change "
                "and delete runs as you. Without --host, only this machine can connect; other "
                "machines can use ssh -L."
            )
        words = [sys.executable, "-m", "gaitsim", "tui", str(root)]
        words += ["--theme", chosen] if chosen else []
        WebServer(shlex.join(words), host, token, windows).serve_on(socket)


serve.keeps_stdout = True  # type: ignore[attr-defined]


def _token(file: Path | None) -> str:
    """Return the token in a file or in the environment, or a random one."""
    given, where = os.environ.get("GAITSIM_TOKEN"), "GAITSIM_TOKEN"
    if file is not None:
        where = str(file)
        try:
            given = read_regular(file, LONGEST_TOKEN, follow=True).decode().strip()
        except (OSError, UnicodeDecodeError) as error:
            reason = getattr(error, "strerror", None) or "it is not UTF-8 text"
            raise GaitsimError(
                f"cannot read the token: {reason}", where=where, allowed="a text file"
            ) from None
    if given is None:
        return secrets.token_urlsafe(24)
    if not given.strip():
        raise GaitsimError(
            "the token is empty",
            where=where,
            allowed="a string that is hard to guess",
            remedy="leave it out to get a random token at each start",
        )
    return given
