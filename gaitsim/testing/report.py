"""The findings of a check: expected and actual behaviour of the plugin, and how to fix it."""

from collections.abc import Generator, Iterable, Mapping
from dataclasses import asdict, dataclass, field
from functools import partial
from typing import Any, Literal

from gaitsim.registry import Entry

Level = Literal["error", "advice"]


@dataclass(frozen=True)
class Finding:
    """An error or an advice.

    Attributes:
        level: 'error' for a violation of the contract, 'advice' for a possible improvement.
        rule: name of the rule, such as 'chunks'.
        expected: behaviour that the contract requires.
        actual: behaviour of the plugin.
        fix: change that fixes the plugin.
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
    """Yield the findings; return whether any is an error, so that later rules can be skipped."""
    wrong = False
    for finding in findings:
        wrong |= finding.level == "error"
        yield finding
    return wrong


@dataclass(frozen=True)
class Report:
    """The result of the check of one plugin or preset.

    Attributes:
        entry: entry of the plugin, with its package.
        findings: findings in the order of the rules.
        figures: measurements by name: `import_seconds`, `first_call_seconds`,
            `individuals_per_second`; those that the check did not reach are missing.
        digest: SHA-256 of the plugin's results, for comparison between processes; '' for none.
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
        """The findings that are errors."""
        return tuple(finding for finding in self.findings if finding.level == "error")

    @property
    def advice(self) -> tuple[Finding, ...]:
        """The findings that are advice."""
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
