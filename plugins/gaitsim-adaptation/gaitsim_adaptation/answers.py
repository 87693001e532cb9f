"""Results of a robot as people type them: '62cm', '0,62', 'fell 0.3', 'could not play'."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

from gaitsim.plugin import GaitsimError
from gaitsim.plugin.runs import LARGEST_SCORE
from gaitsim_adaptation.trials import Outcome

_LENGTHS = {"mm": 0.001, "cm": 0.01, "m": 1.0, "km": 1000.0, "in": 0.0254, "ft": 0.3048}
_ANGLES = {"°": 1.0, "deg": 1.0, "rad": math.degrees(1)}
_TIMES = {"ms": 0.001, "s": 1.0, "min": 60.0}
_FELL = re.compile(r"\b(fell|fallen|fall)\b")
_NOT_PLAYED = re.compile(r"\b(could not play|cannot play|not played)\b")
_VALUE = re.compile(r"([+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:e[+-]?\d+)?)\s*([a-z°]*)(?:[\s;]+|$)")
ALLOWED = (
    "a finite number, with or without a unit, such as 1.3 or 62cm; several for several attempts; "
    "'fell' with the distance up to the fall, or 'could not play'"
)


ANSWERS = (
    "Answer with a result such as 1.3 or 62cm, several attempts, 'fell 0.3' or 'could not play'; "
    "or 'undo', 'correct N RESULT', 'repeat N RESULT'."
)


@dataclass(frozen=True)
class Answer:
    """The result of a trial on a robot.

    Attributes:
        values: measured performance of each attempt, in the unit of the map.
        outcome: outcome of the trial.
        text: the answer as it was typed.
    """

    values: tuple[float, ...]
    outcome: Outcome = "walked"
    text: str = ""


@dataclass(frozen=True)
class AnswerReader:
    """The meaning of the numbers that are typed.

    Attributes:
        measure_unit: unit of the performance measure.
        unit: unit of numbers without a unit; '' for that of the measure.
        course: distance for which the robot's time is measured, m; None for results that are the
            performance itself. Shorter times are better.
        seconds: duration of a gait, s.
    """

    measure_unit: str
    unit: str = ""
    course: float | None = None
    seconds: float = math.nan

    def __post_init__(self) -> None:
        if self.unit:
            _factor(self._units if self.course is None else _TIMES, self.unit)
        if self.course is not None and self.measure_unit != "m":
            raise GaitsimError(
                "times need a measure in metres", where="--course", allowed="--measure forward"
            )

    def read(self, text: str) -> Answer:
        """Return the answer in a text.

        Raises:
            GaitsimError: the text has no number, an unknown unit, or an impossible value.
        """
        words = " ".join(text.lower().split())
        rest, fell = _FELL.subn(" ", words)
        rest, not_played = _NOT_PLAYED.subn(" ", rest)
        outcome: Outcome = "could not play" if not_played else "fell" if fell else "walked"
        values, at = [], 0
        rest = rest.strip()
        while at < len(rest) and (found := _VALUE.match(rest, at)):
            values.append(self._value(float(found[1].replace(",", ".")), found[2], outcome))
            at = found.end()
        if at < len(rest) or not (values or fell or not_played) or (values and not_played):
            raise GaitsimError(f"invalid measured value: {text.strip()!r:.60}", allowed=ALLOWED)
        if not all(abs(value) < LARGEST_SCORE for value in values):
            raise GaitsimError(f"invalid measured value: {text.strip()!r:.60}", allowed=ALLOWED)
        return Answer(tuple(values) or (0.0,), outcome, words)

    def _value(self, number: float, unit: str, outcome: Outcome) -> float:
        """Return a number as performance in the unit of the map."""
        if self.course is None:
            units = self._units
            return (
                number
                * _factor(units, unit or self.unit or self.measure_unit)
                / (units[self.measure_unit])
            )
        if outcome == "fell":
            return number * _factor(_LENGTHS, unit or "m")
        seconds = number * _factor(_TIMES, unit or self.unit or "s")
        if seconds <= 0:
            raise GaitsimError(f"invalid time: {number:g}", allowed="a time above 0")
        return self.course / seconds * self.seconds

    @property
    def _units(self) -> Mapping[str, float]:
        """The units that numbers may have, as multiples of a common unit."""
        groups = (_LENGTHS, _ANGLES, _TIMES)
        return next((one for one in groups if self.measure_unit in one), {self.measure_unit: 1.0})


def _factor(units: Mapping[str, float], unit: str) -> float:
    if unit not in units:
        allowed = ", ".join(filter(None, units))
        raise GaitsimError(f"unknown unit: {unit!r:.40}", allowed=allowed or "no unit")
    return units[unit]
