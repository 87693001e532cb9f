"""`gaitsim robots list`."""

from gaitsim.cli.facts import print_facts
from gaitsim.cli.options import Json
from gaitsim.console.printing import output, print_json
from gaitsim.registry import find, load_class, plugin_errors


def list_(json: Json = False) -> None:
    """List the installed robots and servos.

    [bold]Examples[/bold]

    gaitsim robots list

    gaitsim run robot --set organism.model=hexapod
    """
    from gaitsim.contracts import Organism
    from gaitsim.experiment.loading import readers

    for body, formats in readers().items():
        model, entry = load_class("organism", body), find("organism", body)
        assert issubclass(model, Organism)
        with plugin_errors(entry, "listing its robots and servos"):
            facts = model.library()
        if json:
            print_json({"body": body, "formats": formats, **facts})
            continue
        print_facts(facts)
        listed = ", ".join(f".{suffix}" for suffix in formats)
        output().print(f"\nFile types that the body {body} reads: {listed}", style="dim")
