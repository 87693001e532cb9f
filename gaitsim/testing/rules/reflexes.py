"""Rules for reflexes, which are tried on random observations."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from gaitsim.contracts.reflex import (
    OBSERVATIONS,
    Floats,
    Inputs,
    Legs,
    Observation,
    Reflex,
)
from gaitsim.testing.report import Finding, any_error, error
from gaitsim.testing.rules.common import STATELESS, check_array, first_difference, same

POPULATION = 5
STEPS = 50
INTERVAL = 0.02  # s
BODIES = {
    "four legs": Legs(
        ("FL", "FR", "HL", "HR"),
        np.array([[0.1, 0.08], [0.1, -0.08], [-0.1, 0.08], [-0.1, -0.08]]),
        0.15,
        12,
    ),
    "two legs": Legs(("L", "R"), np.array([[0.0, 0.05], [0.0, -0.05]]), 0.4, 10),
}
"""The legs on which reflexes are tried."""


def observe(legs: Legs, needs: tuple[str, ...], step: int) -> Observation:
    """Return random observations of a population; those that the reflex does not need are NaN."""
    rng = np.random.default_rng([3, step])
    shape = (POPULATION, len(legs.names))
    walking = np.where(rng.random((POPULATION, 1)) < 0.8, 1.0, 0.0)
    seen = Observation(
        orientation=rng.normal(size=(POPULATION, 3)),
        rates=rng.normal(size=(POPULATION, 3)),
        contacts=rng.integers(2, size=shape).astype(np.float64),
        load=rng.random(shape),
        joints=rng.normal(size=(POPULATION, legs.joints)),
        command=walking * rng.normal(size=(POPULATION, 4)),
        heading=rng.normal(size=POPULATION),
        phase=rng.random(shape),
        duty=0.3 + 0.5 * rng.random((POPULATION, 1)),
    )
    for name in {*OBSERVATIONS} - {*needs}:
        getattr(seen, name)[:] = np.nan
    return seen


@dataclass
class Trial:
    """A reflex on random observations.

    Attributes:
        reflex: reflex to try.
        legs: legs of the body.
        rows: individuals of the population that take part.
    """

    reflex: Reflex
    legs: Legs
    rows: range = range(POPULATION)

    def start(self) -> Any:
        """Return the state at the start."""
        rng = np.random.default_rng(1)
        genes: Floats = 2 * rng.random((POPULATION, self.reflex.weights(self.legs))) - 1
        return self.reflex.start(self.legs, genes[self.rows].copy())

    def observe(self, step: int) -> Observation:
        """Return the observations of a step."""
        seen = observe(self.legs, self.reflex.needs, step)
        return Observation(**{name: values[self.rows] for name, values in arrays(seen).items()})

    def run(self, steps: int = STEPS) -> dict[str, Any]:
        """Return the inputs after each step, and the state at the end, by name."""
        state = self.start()
        found: dict[str, Any] = {}
        for step in range(steps):
            seen = self.observe(step)
            inputs = Inputs.unchanged(seen.command, len(self.legs.names))
            self.reflex.step(state, seen, inputs, INTERVAL)
            found |= {f"{name} of step {step}": value for name, value in arrays(inputs).items()}
        return found | {f"state {name!r}": values for name, values in state.items()}


def arrays(values: Observation | Inputs) -> dict[str, Floats]:
    """Return the arrays of observations or inputs, by name."""
    return {field.name: getattr(values, field.name) for field in fields(values)}


def reflex_rules(reflex: Reflex) -> Iterator[Finding]:
    """Check all rules for a reflex with its current options."""
    for what, legs in BODIES.items():
        trial = Trial(reflex, legs)
        if (yield from any_error(_check_start(trial, what))):
            return
        if (yield from any_error(_check_step(trial))):
            return
        yield from _check_individuals(trial)
        yield from _check_genes(trial)
        yield from _check_c99(trial)


def _check_start(trial: Trial, what: str) -> Iterator[Finding]:
    count: object = trial.reflex.weights(trial.legs)
    if not isinstance(count, int) or count < 0:
        yield error("weights", "weights() returns a number of genes", f"{count!r:.60}", "")
        return
    state: object = trial.start()
    if not isinstance(state, dict) or not all(isinstance(name, str) for name in state):
        actual = f"a {type(state).__name__}"
        yield error("state", "start() returns a dict of named arrays", actual, "")
        return
    for name, values in state.items():
        shape = (POPULATION, *np.shape(values)[1:])
        which = f"state {name!r}, {what}"
        yield from check_array("start()", which, values, shape, np.dtype(np.float64))
    if not same(state, trial.start()):
        yield error("determinism", "the same state from the same weights", "another", STATELESS)


def _check_step(trial: Trial) -> Iterator[Finding]:
    state, fix = trial.start(), "assign to slices: inputs.reach[:] = …, or state['x'] += …"
    for step in range(STEPS):
        seen, kept = trial.observe(step), trial.observe(step)
        inputs = Inputs.unchanged(seen.command, len(trial.legs.names))
        before, places = dict(state), arrays(inputs)
        shapes = [values.shape for values in (*state.values(), *places.values())]
        trial.reflex.step(state, seen, inputs, INTERVAL)
        for name, values in arrays(kept).items():
            if not same(values, getattr(seen, name)):
                yield error("inputs", "unchanged observations", f"step() changes {name}", "")
        after = {**state, **arrays(inputs)}
        moved = [name for name, one in {**before, **places}.items() if after.get(name) is not one]
        if moved or len(after) != len(shapes):
            actual = f"new arrays: {', '.join(moved) or 'in the state'}"
            yield error("in place", "step() changes the state and the inputs in place", actual, fix)
            return
        wrong = [name for name, values in after.items() if not np.isfinite(values).all()]
        if wrong:
            missing = ", ".join(sorted({*OBSERVATIONS} - {*trial.reflex.needs}))
            yield error(
                "finite values",
                "finite numbers from the observations that 'needs' declares",
                f"{', '.join(wrong)} is not finite after {step + 1} steps",
                f"declare observations that it reads, such as {missing}, in 'needs'; divide by no 0"
                if missing
                else "prevent overflow and division by 0",
            )
            return


def _check_individuals(trial: Trial) -> Iterator[Finding]:
    whole, steps = trial.run(), "of the same individuals alone"
    for rows in (range(1), range(2, POPULATION)):
        alone = Trial(trial.reflex, trial.legs, rows).run()
        if name := first_difference({key: value[rows] for key, value in whole.items()}, alone):
            yield error(
                "population",
                f"the same results {steps}",
                f"another {name}",
                "compute along the other axes, and keep no state outside the arrays of start()",
            )
            return


def _check_genes(trial: Trial) -> Iterator[Finding]:
    """Check that each number may have a value for each individual, as genes do."""
    whole = trial.run()
    for name, field in type(trial.reflex).model_fields.items():
        if field.annotation is not float:
            continue
        genes = np.full(POPULATION, getattr(trial.reflex, name))
        evolved = trial.reflex.model_copy(update={name: genes})
        fix = f"use NumPy's functions instead of 'if', and self.{name}[..., None] for legs"
        try:
            found = Trial(evolved, trial.legs).run()
        except (ValueError, TypeError, IndexError) as problem:
            yield error("genes", f"{name} may be an array (population,)", f"{problem}", fix)
            return
        if key := first_difference(whole, found):
            expected = f"the same results if {name} is an array of equal numbers, (population,)"
            yield error("genes", expected, f"another {key}", fix)
            return


def _check_c99(trial: Trial) -> Iterator[Finding]:
    code: object = trial.reflex.c99()
    if not isinstance(code, str):
        yield error("c99", "c99() returns a string", f"a {type(code).__name__}", "")
        return
    known = {
        "o": {*type(trial.reflex).model_fields},
        "s": {*trial.start()},
        "seen": {field.name for field in fields(Observation)},
        "inputs": {field.name for field in fields(Inputs)},
    }
    for pointer, name in re.findall(r"\b(o|s|seen|inputs)->(\w+)", code):
        if name not in known[pointer]:
            allowed = ", ".join(sorted(known[pointer])) or "none"
            yield error("c99", f"names after {pointer}-> among: {allowed}", name, "")
            return
