"""`gaitsim serve`."""

import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer

from gaitsim.cli.console import notice
from gaitsim.cli.tui import Root, ThemeName
from gaitsim.errors import GaitsimError
from gaitsim.tui.themes import check_theme


def serve(
    root: Root = Path("runs"),
    host: Annotated[
        str, typer.Option(help="Address to listen on. Default: this machine alone.")
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=1, max=65535, help="Port to listen on.")] = 8000,
    theme: ThemeName = None,
) -> None:
    """Open the terminal UI in a browser, by default on this machine only.

    Each browser window runs its own app. There is no login.

    [bold]Examples[/bold]

    gaitsim serve

    gaitsim serve experiments/spring --port 8080

    ssh -L 8000:127.0.0.1:8000 lab gaitsim serve
    """
    try:
        from gaitsim.tui.web import WebServer, is_loopback, listening
    except ModuleNotFoundError as error:
        raise GaitsimError(
            f"'gaitsim serve' needs the package {error.name}, which is not installed",
            remedy="pip install 'gaitsim[serve]'",
        ) from None
    chosen = check_theme(theme, where="--theme") if theme else None
    with listening(host, port) as socket:
        if not is_loopback(host):
            notice(
                f"Warning: {host} can be reached from other machines, and there is no login: "
                "anyone who opens the page can start, change and delete runs as you. "
                "Without --host, only this machine can; by ssh -L, from another one, too."
            )
        words = [sys.executable, "-m", "gaitsim", "tui", str(root)]
        words += ["--theme", chosen] if chosen else []
        WebServer(shlex.join(words), host, port, title="gaitsim").serve_on(socket)
