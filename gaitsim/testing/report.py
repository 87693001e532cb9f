"""The report of a check: a list of findings, each with a suggested fix."""

from collections.abc import Generator, Iterable, Mapping
from dataclasses import asdict, dataclass, field
from functools import partial
from typing import Any, Literal

from gaitsim.registry import Entry

Level = Literal["error", "advice"]


@dataclass(frozen=True)
class Finding:
    """An error, or a piece of advice.

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


def any_error(findings: Iterable[Finding]) -> Generator[Finding, None, bool]:
    """Yield the findings; return whether any is an error, so that later rules can be skipped."""
    found = False
    for finding in findings:
        found |= finding.level == "error"
        yield finding
    return found


@dataclass(frozen=True)
class Report:
    """The result of the check of one plugin or preset.

    Attributes:
        entry: entry of the plugin, with its package.
        findings: findings in the order of the rules.
        figures: measurements by name: `import_seconds`, `first_call_seconds`,
            `individuals_per_second`. Measurements that the check did not reach are missing.
        digest: SHA-256 of the plugin's results, for comparison between processes; '' if the
            plugin has errors.
    """

    entry: Entry
    findings: tuple[Finding, ...] = ()
    figures: Mapping[str, float] = field(default_factory=dict)
    digest: str = ""

    @property
    def ok(self) -> bool:
        """Whether the check found no errors."""
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
        """Return the verdict on one line, followed by the findings."""
        errors = len(self.errors)
        verdict = f"fails: {errors} error{'s' * (errors > 1)}" if errors else "passes"
        if self.advice:
            verdict += f", {len(self.advice)} piece{'s' * (len(self.advice) > 1)} of advice"
        return "\n".join([f"{self.entry} {verdict}", *map(str, self.findings)])

    def to_json(self) -> dict[str, Any]:
        """Return the report as a dict for JSON."""
        return {
            **asdict(self.entry),
            "ok": self.ok,
            "findings": [asdict(finding) for finding in self.findings],
            "figures": dict(self.figures),
        }
