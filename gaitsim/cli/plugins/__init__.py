"""`gaitsim plugins`."""

import typer

from gaitsim.cli.help import Command, Group
from gaitsim.cli.plugins import check, new, show

app = typer.Typer(
    name="plugins",
    cls=Group,
    help="Installed bodies and operators, and new ones.",
    no_args_is_help=True,
)

app.command("list", cls=Command)(show.list_)
app.command(cls=Command)(show.show)
app.command(cls=Command)(check.check)
app.command(cls=Command)(new.new)
