"""The findings of a check: what the contract expects, what the plugin did, and how to fix it."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
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


def error(rule: str, expected: str, actual: str, fix: str) -> Finding:
    """Return a finding that breaks the contract."""
    return Finding("error", rule, expected, actual, fix)


def advice(rule: str, expected: str, actual: str, fix: str) -> Finding:
    """Return a finding that breaks nothing."""
    return Finding("advice", rule, expected, actual, fix)


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
        verdict = "passes" if self.ok else f"fails: {_count(len(self.errors), 'error')}"
        if self.advice:
            verdict += f", {len(self.advice)} of advice"
        return "\n".join([f"{self.entry} {verdict}", *map(str, self.findings)])

    def to_json(self) -> dict[str, Any]:
        """Return the report for JSON."""
        return {
            "kind": self.entry.kind,
            "name": self.entry.name,
            "package": self.entry.package,
            "version": self.entry.version,
            "target": self.entry.target,
            "ok": self.ok,
            "findings": [asdict(finding) for finding in self.findings],
            "figures": dict(self.figures),
        }


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" + ("s" if number != 1 else "")
