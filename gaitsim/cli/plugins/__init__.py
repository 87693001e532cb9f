"""`gaitsim plugins`."""

from gaitsim.cli.help import group

app = group(
    __name__,
    {
        "list": "List all plugins by kind, with their packages, without importing them.",
        "show": "Show a plugin's options and, for a body, its channels and conditions.",
        "check": "Check whether plugins fulfil the contract of their kind, and report what to fix.",
        "new": "Create a ready-to-run package for a new plugin in the folder NAME.",
    },
    add_completion=False,
)


@app.callback()
def plugins() -> None:
    """List, show and check plugins, and create new ones."""
