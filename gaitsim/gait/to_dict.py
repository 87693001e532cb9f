"""Analyses as plain values, for JSON: SI units, angles in radians, phases in cycles."""

from dataclasses import asdict
from typing import Any

import numpy as np

from gaitsim.errors import GaitsimError
from gaitsim.gait import Footfalls, Gait
from gaitsim.gait.robustness import Robustness
from gaitsim.gait.score_breakdown import Change, Course


def gait(found: Gait) -> dict[str, Any]:
    """A gait; `feet`, `stride`, `stability` and `slip` are null for a body without feet."""
    named = asdict(found.name)
    pattern = named.pop("pattern")
    return {
        "name": named.pop("name"),
        **{f"name_{key}": value for key, value in named.items()},
        "distances": dict(found.distances),
        "flags": [asdict(flag) for flag in found.flags],
        "missing": list(found.missing),
        "frame_rate": found.frame_rate,
        "travel": asdict(found.travel),
        **(
            _footfalls(found.footfalls, pattern)
            if found.footfalls
            else dict.fromkeys(("stride", "feet", "stability", "slip"))
        ),
    }


def _footfalls(found: Footfalls, pattern: tuple[float | None, ...]) -> dict[str, Any]:
    margin = found.margin
    return {
        "stride": asdict(found.stride) if found.stride else None,
        "feet": [
            {
                **asdict(foot),
                "phase": float(found.phases[index]),
                "consistency": float(found.consistency[index]),
                "reference_phase": pattern[index] if pattern else None,
                "touching": found.touching[:, index].astype(int).tolist(),
            }
            for index, foot in enumerate(found.feet)
        ],
        "stability": {
            "least": float(margin.min()),
            "median": float(np.median(margin)),
            "unsupported": float(np.mean(margin < 0)),
            "airborne": float(np.mean(~found.touching.any(axis=1))),
            "lying": found.lying,
            "margin": margin.tolist(),
        },
        "slip": asdict(found.slip),
    }


def course(found: Course | GaitsimError) -> dict[str, Any]:
    """Terms over time, or why there are none."""
    if isinstance(found, GaitsimError):
        return {"error": found.what}
    return {
        "seconds": found.seconds.tolist(),
        "terms": {name: values.tolist() for name, values in found.terms.items()},
        "unmoved": list(found.unmoved),
    }


def changes(first: int, found: tuple[Change, ...]) -> dict[str, Any]:
    """Terms over the generations."""
    return {"first_generation": first, "terms": [asdict(change) for change in found]}


def robustness(found: Robustness) -> dict[str, Any]:
    """How a score bears perturbations."""
    return asdict(found)
