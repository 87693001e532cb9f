"""`gaitsim share`."""

from gaitsim.cli.console import echo, notice
from gaitsim.cli.options import BestOf, MemberOf, RunName
from gaitsim.cli.parsing import which
from gaitsim.runs.files.folder import find_run
from gaitsim.runs.snapshot import RunSnapshot
from gaitsim.sharing.challenge import code_of

LONG = 4000  # characters; chats cut longer messages


def share(run: RunName, generation: BestOf = None, member: MemberOf = None) -> None:
    """Print the champion as a challenge code, a text that others can verify.

    The code holds the experiment, the genome, the score, and the versions and the processor that
    made it. It is alone on standard output, on one line.

    [bold]Examples[/bold]

    gaitsim share spider

    gaitsim share spider --generation 10

    gaitsim share spider-atlas --member 3

    gaitsim share fly > fly.txt

    gaitsim share spider | gaitsim verify -
    """
    individual = RunSnapshot(find_run(run)).individual(which(generation, member))
    code = code_of(individual)
    echo(code)
    size = f"{len(code):,} characters"
    if len(code) > LONG:
        size += ", too long for most chats: send it as a file"
    notice(
        f"{individual.title}, score {individual.score!r}: {size}. "
        "Anyone can check it with: gaitsim verify CODE"
    )
