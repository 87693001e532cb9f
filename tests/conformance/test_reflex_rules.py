"""Each rule for reflexes reports its kind of error, and a correct reflex passes."""

import pytest
from gaitsim.testing.examine import examine

from gaitsim.registry import find

SOURCE = '''
from typing import ClassVar

import numpy as np

from gaitsim.contracts import Reflex, option


class Lean(Reflex):
    """Longer legs on the side to which the body rolls, with a little memory."""

    gain: float = option(0.1, "metres per rad", ge=0, le=1)
    needs: ClassVar = ("orientation",)

    def weights(self, legs):
        return 2

    def start(self, legs, weights):
        return {"last": np.zeros(len(weights)), "genes": weights.copy()}

    def step(self, state, seen, inputs, interval):
        roll = seen.orientation[:, 0]
        inputs.reach[:] += (self.gain * (roll + state["last"] * state["genes"][:, 0]))[:, None]
        state["last"][:] = roll

    def c99(self):
        return "inputs->reach[0] += o->gain * s->last;"


class X(Lean):
    """A reflex."""
'''


@pytest.fixture
def examined(install):
    """Examines a reflex that is a working one but for what is given."""

    def run(body="pass"):
        lines = "\n    ".join(body.strip("\n").splitlines())
        install("fake", f"{SOURCE}    {lines}\n", {"reflex": {"x": "X"}})
        return examine(find("reflex", "x"), {})

    return run


def test_a_correct_reflex_passes(examined):
    report = examined()
    assert report.findings == ()
    assert len(report.digest) == 64


STEP = "def step(self, state, seen, inputs, interval):\n    "
START = "def start(self, legs, weights):\n    return "
WRONG = {
    "a number of weights": ("def weights(self, legs):\n    return 2.0", "weights", "2.0"),
    "a state without names": (START + "[]", "state", "a list"),
    "a state without population": (START + "{'last': np.zeros(3)}", "shapes", "(3,)"),
    "a state of whole numbers": (START + "{'last': np.zeros(len(weights), int)}", "dtypes", "int"),
    "a state by chance": (
        START + "{'last': np.random.default_rng().random(len(weights))}",
        "determinism",
        "another",
    ),
    "changed observations": (STEP + "seen.orientation[:] = 0", "inputs", "orientation"),
    "a new array of inputs": (
        STEP + "inputs.reach = inputs.reach + 1",
        "in place",
        "reach",
    ),
    "a new array of the state": (
        STEP + "state['last'] = state['last'] + 1",
        "in place",
        "last",
    ),
    "a state that grows": (STEP + "state['more'] = state['last'].copy()", "in place", "the state"),
    "an observation that it does not declare": (
        STEP + "inputs.reach += seen.load",
        "finite values",
        "reach is not finite after 1 steps",
    ),
    "a mean over the population": (
        STEP + "inputs.command[:, 1] += seen.orientation[:, 2].mean()",
        "population",
        "command of step 0",
    ),
    "a choice by the value of an option": (
        STEP + "inputs.command[:, 1] += 1.0 if self.gain > 0 else 0.0",
        "genes",
        "ambiguous",
    ),
    "a number for each leg": (
        STEP + "inputs.rate *= self.gain",
        "genes",
        "broadcast",
    ),
    "an option that C does not have": ("def c99(self):\n    return 'o->force;'", "c99", "force"),
    "no C": ("def c99(self):\n    return None", "c99", "a NoneType"),
}


@pytest.mark.parametrize(("body", "rule", "actual"), WRONG.values(), ids=WRONG)
def test_what_is_wrong_is_found(examined, body, rule, actual):
    report = examined(body)
    found = {finding.rule: finding for finding in report.errors}
    assert rule in found, report
    assert actual in found[rule].actual
