"""`gaitsim experiments`."""

from gaitsim.cli.help import group

app = group(
    __name__,
    {
        "list": "List the presets of all installed packages.",
        "show": "Print an experiment as TOML with all its options, to edit and run.",
    },
    add_completion=False,
)


@app.callback()
def experiments() -> None:
    """List and show presets: the experiments that packages provide."""
