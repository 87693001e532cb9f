"""`gaitsim share`."""

from gaitsim.actions.action import RUN, ChosenIndividual, argument

LONG = 4000  # characters; chat programs truncate longer messages


class Share(ChosenIndividual):
    """Print the champion as a challenge code, which others can verify.

    The code contains the experiment, the genome and the score, and records the software versions
    and the processor with which the score was computed. Only the code is written to standard
    output, on one line.

    [bold]Examples[/bold]

    gaitsim share spider

    gaitsim share spider --generation 10

    gaitsim share spider-atlas --member 3

    gaitsim share fly > fly.txt

    gaitsim share spider | gaitsim verify -
    """

    run: str = argument(RUN, "RUN")

    def do(self) -> None:
        """Print the code."""
        from gaitsim.console.printing import echo, notice
        from gaitsim.sharing.challenge import code_of
        from gaitsim.storage.snapshot import RunSnapshot

        individual = RunSnapshot.find(self.run).individual(self.choice)
        code = code_of(individual)
        echo(code)
        size = f"{len(code):,} characters"
        if len(code) > LONG:
            size += ", too long for most chat programs: send it as a file"
        notice(
            f"{individual.title}, score {individual.score!r}: {size}. "
            "Anyone can check it with: gaitsim verify CODE"
        )
        notice(f"The score is {individual.experiment.portability}")
