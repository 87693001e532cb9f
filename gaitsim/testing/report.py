"""The findings of a check: what the contract expects, what the plugin did, and how to fix it."""

from collections.abc import Generator, Iterable, Mapping
from dataclasses import asdict, dataclass, field
from functools import partial
from typing import Any, Literal

from gaitsim.registry import Entry

Level = Literal["error", "advice"]


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong, or could be better.

    Attributes:
        level: an error breaks the contract; advice helps the users.
        rule: the name of the rule, such as 'chunks'.
        expected: what the contract requires.
        actual: what the plugin did instead.
        fix: what to change.
    """

    level: Level
    rule: str
    expected: str
    actual: str
    fix: str

    def __str__(self) -> str:
        parts = {"expected": self.expected, "actual": self.actual, "fix": self.fix}
        lines = [f"{self.level}: {self.rule}"]
        for title, text in parts.items():
            if text:
                lines.append(f"  {title + ':':<9} " + text.replace("\n", "\n" + 12 * " "))
        return "\n".join(lines)


error = partial(Finding, "error")
advice = partial(Finding, "advice")


def reported(findings: Iterable[Finding]) -> Generator[Finding, None, bool]:
    """Yield the findings; return whether an error is among them, on which later rules depend."""
    wrong = False
    for finding in findings:
        wrong |= finding.level == "error"
        yield finding
    return wrong


@dataclass(frozen=True)
class Report:
    """What the check of one plugin, or of one preset, found.

    Attributes:
        entry: the plugin, with its package.
        findings: in the order of the rules; empty if there are none.
        figures: measurements by name: `import_seconds`, `first_call_seconds`,
            `individuals_per_second`, as far as the check got.
        digest: SHA-256 of its results, to compare between processes; '' if there are none.
    """

    entry: Entry
    findings: tuple[Finding, ...] = ()
    figures: Mapping[str, float] = field(default_factory=dict)
    digest: str = ""

    @property
    def ok(self) -> bool:
        """Whether no finding is an error."""
        return not self.errors

    @property
    def errors(self) -> tuple[Finding, ...]:
        """The findings that break the contract."""
        return tuple(finding for finding in self.findings if finding.level == "error")

    @property
    def advice(self) -> tuple[Finding, ...]:
        """The findings that break nothing."""
        return tuple(finding for finding in self.findings if finding.level == "advice")

    def __str__(self) -> str:
        """The verdict on one line, then each finding."""
        errors = len(self.errors)
        verdict = f"fails: {errors} error{'s' * (errors > 1)}" if errors else "passes"
        if self.advice:
            verdict += f", {len(self.advice)} of advice"
        return "\n".join([f"{self.entry} {verdict}", *map(str, self.findings)])

    def to_json(self) -> dict[str, Any]:
        """Return the report for JSON."""
        return {
            **asdict(self.entry),
            "ok": self.ok,
            "findings": [asdict(finding) for finding in self.findings],
            "figures": dict(self.figures),
        }
