"""Analyses as plain values for JSON: SI units, angles in radians, phases in cycles."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.effort import Effort
from gaitsim.errors import GaitsimError
from gaitsim.gait.changed import QuantityPair, compare_bodies, engine_of
from gaitsim.gait.report import Footfalls, GaitAnalysis
from gaitsim.gait.robustness import Robustness
from gaitsim.gait.score_breakdown import summarise, term_changes, terms_over_time
from gaitsim.individual import Individual, Member


def analysis_to_dict(
    individual: Individual,
    gait: GaitAnalysis,
    history: Mapping[str, NDArray[np.float64]],
    robustness: Robustness | None,
    twin: Individual | None,
    elsewhere: Individual | None = None,
) -> dict[str, Any]:
    """Return the gait, score breakdown and robustness of an individual, with comparisons.

    The comparisons are with the same gait on the body's twin, and in another physics engine.
    """
    generation = individual.best_of
    recorded = individual.generation and not individual.changes
    changes = None
    if generation is not None:
        first, found = term_changes(history, generation)
        changes = {"first_generation": first, "terms": [asdict(change) for change in found]}
    return {
        "subject": individual.title,
        "generation": individual.generation or None,
        "member": individual.member.number if isinstance(individual.member, Member) else None,
        "score": individual.replayed_score,
        "failure": individual.replayed_failure or None,
        "recorded_score": individual.score if recorded else None,
        "worlds": individual.worlds or None,
        "terms": individual.replayed_terms,
        **gait_to_dict(gait),
        "terms_over_time": _terms_over_time(individual),
        "terms_over_generations": changes,
        "summary": list(
            summarise(
                individual.scored_terms, history, generation, individual.experiment.fitness.unit
            )
        ),
        "robustness": asdict(robustness) if robustness else None,
        "physics": _compare_bodies(individual, twin, "kinematic", "physical"),
        "engine": _compare_bodies(
            individual, elsewhere, engine_of(individual), engine_of(elsewhere) if elsewhere else ""
        ),
    }


def _compare_bodies(
    individual: Individual, other: Individual | None, *names: str
) -> list[dict[str, Any]] | None:
    """Return the quantities of a gait on two bodies, with the values under the given names."""
    if other is None:
        return None
    return [_pair(one, *names) for one in compare_bodies(individual, other)]


def _pair(one: QuantityPair, *names: str) -> dict[str, Any]:
    return {
        "name": one.name,
        **dict(zip(names, (one.own, one.other), strict=True)),
        "unit": one.unit,
        "help": one.help,
    }


def _terms_over_time(individual: Individual) -> dict[str, Any]:
    try:
        found = terms_over_time(individual)
    except GaitsimError as error:
        return {"error": error.what}
    return {
        "seconds": found.seconds.tolist(),
        "terms": {name: values.tolist() for name, values in found.terms.items()},
        "timed": found.timed,
    }


def gait_to_dict(found: GaitAnalysis) -> dict[str, Any]:
    """Return a gait; `feet`, `stride`, `stability` and `slip` are null for a body without feet."""
    named = asdict(found.name)
    pattern = named.pop("pattern")
    return {
        "name": named.pop("name"),
        **{f"name_{key}": value for key, value in named.items()},
        "distances": dict(found.distances),
        "flags": [asdict(flag) for flag in found.flags],
        "warnings": list(found.warnings),
        "missing": list(found.missing),
        "frame_rate": found.frame_rate,
        "trials": found.trials,
        "travel": asdict(found.travel),
        "effort": _effort(found.effort) if found.effort else None,
        **(
            _footfalls(found.footfalls, pattern)
            if found.footfalls
            else dict.fromkeys(("stride", "feet", "stability", "slip"))
        ),
    }


def _effort(found: Effort) -> dict[str, dict[str, float]]:
    """Return the peak, RMS and continuous torque by joint, as shares of the stall torque."""
    values = zip(found.joints, found.peak, found.rms, found.continuous, strict=True)
    return {
        joint: {"peak": float(peak), "rms": float(rms), "continuous": float(continuous)}
        for joint, peak, rms, continuous in values
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
