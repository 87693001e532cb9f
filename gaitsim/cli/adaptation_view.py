"""Print an adaptation: its trials, the gait to try, and the result."""

from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path

from gaitsim.adaptation.adaptation import Adaptation
from gaitsim.adaptation.trials import Proposal, Trial
from gaitsim.console.printing import echo, output, print_json, report_files
from gaitsim.gait import analyse_individual
from gaitsim.legged.damage import damage_options
from gaitsim.runs.files.folder import command


class AdaptationView:
    """Print an adaptation as lines for people, or as JSON lines for programs.

    Args:
        adaptation: adaptation to print.
        json: whether to print JSON lines.
    """

    def __init__(self, adaptation: Adaptation, json: bool) -> None:
        self._adaptation, self._json = adaptation, json
        prior, session = adaptation.prior, adaptation.session
        self._unit = f" {prior.unit}".rstrip()
        if json:
            return
        damage = ", ".join(session.damage) or "no damage"
        where = {
            "simulation": f"a body with {damage}",
            "physics": f"the twin in physics with {damage}",
            "robot": "your robot",
        }
        output().print(
            f"{prior.source}: {len(prior.performance):,} gaits to try on {where[session.place]}; "
            f"best {prior.measure} in the atlas: {prior.best:.3g}{self._unit}",
            style="bold",
        )

    def print_all(self, trials: Iterable[Trial]) -> None:
        """Print the earlier trials, and new trials as they finish."""
        self.print_earlier()
        for trial in trials:
            self.print_trial(trial)

    def print_earlier(self) -> None:
        """Print the trials so far."""
        for trial in self._adaptation.trials:
            self.print_trial(trial)

    def print_trial(self, trial: Trial) -> None:
        """Print a trial."""
        if self._json:
            print_json({"trial": trial.number, **_without_number(trial)})
            return
        echo(f"{self._prediction(trial)}, measured {trial.measured:.3f}{self._unit}")

    def print_proposal(self, proposal: Proposal, file: Path) -> None:
        """Print a gait to try, and its file."""
        if self._json:
            print_json(
                {"proposal": proposal.number, **_without_number(proposal), "file": str(file)}
            )
            return
        echo(f"{self._prediction(proposal)}\n  play {file}")

    def print_result(self) -> None:
        """Print why the adaptation has ended, its best gait, and commands to use it."""
        adaptation = self._adaptation
        best, gait, prior = adaptation.best, adaptation.gait, adaptation.prior
        if best is None or gait is None:
            raise ValueError("an adaptation cannot end without a trial")
        name = analyse_individual(gait).name.name
        share = best.measured / prior.best
        if self._json:
            values = {"member": best.member, "gait": name, "measured": best.measured}
            path = str(adaptation.path) if adaptation.path else None
            ended = {"ended": adaptation.ending, "trials": len(adaptation.trials)}
            print_json({**ended, **values, "share": share, "adaptation": path})
            return
        echo(f"Ended: {adaptation.ending}.")
        gait_words = "an unnamed gait" if name == "none" else f"{name} in the atlas"
        output().print(
            f"Best: member {best.member}, {gait_words}: {best.measured:.3f}{self._unit}, "
            f"{share:.0%} of the best in the atlas",
            style="bold",
        )
        damage = damage_options(adaptation.session.damage)
        chosen = (prior.source, "--member", best.member)
        commands = {
            "watch it": command("play", *chosen, *damage),
            "export it": command("export", *chosen),
            "make a video": command("video", *chosen, *damage),
        }
        if adaptation.session.place == "physics":
            commands["analyse it in physics"] = command("analyse", *chosen, *damage, "--physics")
        for meaning, line in commands.items():
            output().print(f"  {line}  # {meaning}", style="dim")

    def print_figure(self, file: Path) -> None:
        """Report the file of a plot."""
        report_files(file)
        if not self._json:
            echo(file)

    def _prediction(self, one: Proposal) -> str:
        return (
            f"trial {one.number:>2}  member {one.member:>6}  expected {one.expected:6.3f} ± "
            f"{one.deviation:.3f}{self._unit}"
        )


def _without_number(proposal: Proposal) -> dict[str, float]:
    return {name: value for name, value in asdict(proposal).items() if name != "number"}
