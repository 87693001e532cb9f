"""`gaitsim robots`."""

from gaitsim.cli.help import group

app = group(
    __name__,
    {
        "list": "List the installed robots and servos.",
        "check": "Check whether a robot file can be used, and show its contents.",
    },
    add_completion=False,
)


@app.callback()
def robots() -> None:
    """Check robot files, and list the installed robots and servos."""
