"""`gaitsim robots`."""

from gaitsim.cli.help import group

app = group(
    __name__,
    {
        "list": "List the robots and servos that are installed.",
        "check": "Check whether a robot's file can be used, and show what was found in it.",
    },
    add_completion=False,
)


@app.callback()
def robots() -> None:
    """Check the files of robots, and list the robots and servos that are installed."""
