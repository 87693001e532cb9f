"""Checks of a reflex, which is tried on random observations."""

import re
from dataclasses import fields
from typing import Any

import numpy as np
import pytest

from gaitsim.plugin import OBSERVATIONS, REFLEX, Inputs, Observation, Reflex
from gaitsim_testing.finding import require, require_array, require_type, require_unchanged
from gaitsim_testing.samples import STATELESS, first_difference, same
from gaitsim_testing.trials import INDIVIDUALS, INTERVAL, LEGS, STEPS, ReflexTrial, fields_of

KINDS = (REFLEX,)


@pytest.fixture(params=LEGS)
def trial(plugin: Any, request: pytest.FixtureRequest) -> ReflexTrial:
    """The reflex on one of the bodies, with a valid state at the start."""
    assert isinstance(plugin, Reflex)
    trial = ReflexTrial(plugin, LEGS[request.param])
    count: object = plugin.weights(trial.legs)
    require(
        isinstance(count, int) and count >= 0,
        f"weights() returns {count!r:.60}",
        "a number of genes",
    )
    state: Any = trial.start()
    require_type("start()", state, dict)
    for name, values in state.items():
        require(isinstance(name, str), f"the state has the name {name!r:.60}", "named arrays")
        shape = (INDIVIDUALS, *np.shape(values)[1:])
        require_array("start()", f"state {name!r}", values, shape, np.dtype(np.float64))
    require(
        same(state, trial.start()),
        "start() returns another state for the same weights",
        "the same state from the same weights",
        STATELESS,
    )
    return trial


@pytest.fixture
def checked(trial: ReflexTrial) -> ReflexTrial:
    """A trial whose steps are valid: they change state and inputs in place, to finite numbers."""
    state = trial.start()
    for step in range(STEPS):
        seen, kept = trial.observe(step), trial.observe(step)
        inputs = Inputs.unchanged(seen.command, len(trial.legs.names))
        before = dict(state), fields_of(inputs)
        shapes = [{name: np.shape(one) for name, one in part.items()} for part in before]
        trial.reflex.step(state, seen, inputs, INTERVAL)
        for name, values in fields_of(kept).items():
            require_unchanged(
                same(values, getattr(seen, name)), "step()", f"the observation {name}"
            )
        after = dict(state), fields_of(inputs)
        # A state and an input may have the same name.
        moved = [
            name
            for part, old in zip(after, before, strict=True)
            for name in dict.fromkeys([*old, *part])
            if part.get(name) is not old.get(name)
        ]
        require(
            not moved and shapes == [{n: np.shape(one) for n, one in p.items()} for p in after],
            f"step() creates new arrays: {', '.join(moved)}",
            "state and inputs that change in place",
            "assign to slices: inputs.reach[:] = …, or state['x'] += …",
        )
        wrong = [name for p in after for name, one in p.items() if not np.isfinite(one).all()]
        missing = ", ".join(sorted({*OBSERVATIONS} - {*trial.reflex.needs}))
        require(
            not wrong,
            f"{', '.join(wrong)} is not finite after {step + 1} steps",
            "finite numbers from the observations that 'needs' declares",
            f"declare observations that it reads, such as {missing}, in 'needs'; divide by no 0"
            if missing
            else "prevent overflow and division by 0",
        )
    return trial


def test_individuals(checked: ReflexTrial) -> None:
    """Each individual is independent of the others."""
    whole = checked.run()
    for rows in (range(1), range(2, INDIVIDUALS)):
        alone = ReflexTrial(checked.reflex, checked.legs, rows).run()
        name = first_difference({key: value[rows] for key, value in whole.items()}, alone)
        require(
            not name,
            f"another {name} if some individuals are alone",
            "the same results for any population",
            "compute along the other axes, and keep no state outside the arrays of start()",
        )


def test_genes(checked: ReflexTrial) -> None:
    """Each number may have a value for each individual, as genes do."""
    reflex, whole = checked.reflex, checked.run()
    for name, field in type(reflex).model_fields.items():
        if field.annotation is not float:
            continue
        genes = np.full(INDIVIDUALS, getattr(reflex, name))
        evolved = reflex.model_copy(update={name: genes})
        try:
            other = first_difference(whole, ReflexTrial(evolved, checked.legs).run())
        except (ValueError, TypeError, IndexError) as problem:
            other = str(problem)
        require(
            not other,
            f"{other}, if {name} is an array of equal numbers",
            f"the same results for an array {name}, (population,)",
            f"use NumPy's functions instead of 'if', and self.{name}[..., None] for legs",
        )


def test_c99(checked: ReflexTrial) -> None:
    """The C code reads only options, state and observations that exist."""
    code: Any = checked.reflex.c99()
    require_type("c99()", code, str)
    known = {
        "o": {*type(checked.reflex).model_fields},
        "s": {*checked.start()},
        "seen": {field.name for field in fields(Observation)},
        "inputs": {field.name for field in fields(Inputs)},
    }
    for pointer, name in re.findall(r"\b(o|s|seen|inputs)->(\w+)", code):
        allowed = ", ".join(sorted(known[pointer])) or "none"
        require(name in known[pointer], f"c99() reads {pointer}->{name}", f"one of {allowed}")
