"""Analyses as plain values, for JSON: SI units, angles in radians, phases in cycles."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import GaitsimError
from gaitsim.gait.report import Footfalls, GaitAnalysis
from gaitsim.gait.robustness import Robustness
from gaitsim.gait.score_breakdown import summarise, term_changes, terms_over_time
from gaitsim.gait.twin import compare_with_twin
from gaitsim.individual import Individual


def analysis_to_dict(
    individual: Individual,
    gait: GaitAnalysis,
    history: Mapping[str, NDArray[np.float64]],
    robustness: Robustness | None,
    twin: Individual | None,
) -> dict[str, Any]:
    """Return an individual's gait, its score's breakdown, robustness, and gait on the twin."""
    generation = individual.best_of
    changes = None
    if generation is not None:
        first, found = term_changes(history, generation)
        changes = {"first_generation": first, "terms": [asdict(change) for change in found]}
    return {
        "subject": individual.title,
        "generation": individual.generation or None,
        "member": individual.member.number if individual.member else None,
        "score": individual.replayed_score,
        "failure": individual.replayed_failure or None,
        "recorded_score": individual.score if individual.generation else None,
        "worlds": individual.worlds or None,
        "terms": individual.replayed_terms,
        **gait_to_dict(gait),
        "terms_over_time": _terms_over_time(individual),
        "terms_over_generations": changes,
        "summary": list(summarise(individual.scored_terms, history, generation)),
        "robustness": asdict(robustness) if robustness else None,
        "physics": [one._asdict() for one in compare_with_twin(individual, twin)] if twin else None,
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
