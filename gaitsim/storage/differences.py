"""The options in which runs differ, with the value in each stage."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from gaitsim.experiment import ExperimentOutline
from gaitsim.registry.options import PLUGIN
from gaitsim.storage.stages import SCORING
from gaitsim.toml import brief

Stages = Sequence[tuple[int, ExperimentOutline]]
"""The stages of a run: the first generation of each, and its experiment."""

ABSENT = "–"
NAMED = 3  # options that a warning names


@dataclass(frozen=True)
class Difference:
    """An option that differs between runs, or changed during a run.

    Attributes:
        key: key for `--set`, such as `mutation.rate`.
        values: value in each run, as text; `ABSENT` if a run does not have the option. A value
            that changed during the run is followed by the later values, each with its first
            generation.
    """

    key: str
    values: tuple[str, ...]


def differences(runs: Sequence[Stages]) -> tuple[Difference, ...]:
    """Return the options in which runs differ, in the order of their files.

    Args:
        runs: stages of each run in order; () for a run that cannot be read.
    """
    values_of = [[(first, outline.options()) for first, outline in stages] for stages in runs]
    keys = dict.fromkeys(key for stages in values_of for _, values in stages for key in values)
    found = []
    for key in keys:
        each = {_text(values.get(key)) for stages in values_of for _, values in stages if values}
        if len(each) > 1:
            found.append(
                Difference(key, tuple(_values_by_stage(key, stages) for stages in values_of))
            )
    return tuple(found)


def scoring_warning(found: Sequence[Difference]) -> str:
    """Return a warning if options that affect scores differ, else ''."""
    keys: list[str] = []
    for section in SCORING:
        own = [one.key for one in found if one.key.startswith(f"{section}.")]
        plugin = f"{section}.{PLUGIN}"
        keys += [plugin] if plugin in own else own  # different plugins have different options
    if not keys:
        return ""
    body, *others = SCORING
    scored = tuple(f"{section}." for section in others)
    certain = any(key == f"{body}.{PLUGIN}" or key.startswith(scored) for key in keys)
    named = " and ".join(keys) if len(keys) <= 2 else ", ".join(keys[:NAMED])
    more = f" and {len(keys) - NAMED} more" if len(keys) > NAMED else ""
    verb = "are not" if certain else "may not be"
    return f"The scores {verb} comparable: {named}{more} differ{'s' * (len(keys) == 1)}."


def _values_by_stage(key: str, stages: Sequence[tuple[int, Mapping[str, Any]]]) -> str:
    """Return the values of an option over the stages, such as '0.1, from 151: 0.2'."""
    texts: list[str] = []
    last = ""
    for first, values in stages:
        text = _text(values.get(key))
        if not texts:
            texts.append(text)
        elif text != last:
            texts.append(f"from {first}: {text}")
        last = text
    return ", ".join(texts) or ABSENT


def _text(value: Any) -> str:
    return ABSENT if value is None else brief(value)
