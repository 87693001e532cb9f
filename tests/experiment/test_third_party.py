"""Plugins of other packages, which may be broken, incompatible or old."""

import pytest


def test_an_operator_that_does_not_work_on_the_genomes_is_refused_with_those_that_do(
    parsed, problem, custom, install, working
):
    install("fake", working, {"organism": {"bits": "BitBody"}, "fitness": {"far": "Distance"}})
    found = problem("mutation.plugin=bit-flip")
    assert (
        "'bit-flip' does not support the genomes of the body 'spider', which are of the kind 'real'"
        in found.what
    )
    assert "gaussian" in found.allowed.split(", ")
    assert "bit-flip" not in found.allowed.split(", ")
    found = problem(text=custom(organism="bits", fitness="far"))
    assert found.where == "x.toml, key mutation.plugin"
    assert (
        "'gaussian' does not support the genomes of the body 'bits', which are of the kind 'bit'"
        in found.what
    )
    assert "bit-flip" in found.allowed.split(", ")
    for name in found.allowed.split(", "):
        assert parsed(f"mutation.plugin={name}", text=custom(organism="bits", fitness="far"))


def test_a_fitness_without_its_channels_is_refused_with_those_that_have_them(
    problem, custom, install, working
):
    install("fake", working, {"organism": {"point": "Body"}, "fitness": {"far": "Distance"}})
    found = problem(text=custom(organism="point"))
    assert "'spider-walk' reads the channels" in found.what
    assert found.allowed == "far"
    found = problem("fitness.plugin=far")
    assert "reads the channels 'distance', which the body 'spider' does not have" in found.what
    assert "spider-walk" in found.allowed


@pytest.mark.parametrize(
    ("source", "reason"),
    [
        ("def genome_space(self): 1 / 0", "failed while returning its genome space: ZeroDivision"),
        ("def model_post_init(self, _): raise SystemExit(0)", "SystemExit"),
        ("needed: int", "organism.needed is required"),
    ],
)
def test_a_body_that_fails_is_reported_with_the_other_problems(
    problems, custom, install, working, source, reason
):
    install(
        "fake",
        f"{working}\nclass X(Body):\n    {source}\n",
        {"organism": {"x": "X"}, "fitness": {"far": "Distance"}},
    )
    text = custom(organism="x", fitness="far")
    found = problems("seed=x", "mutation.rate=7", text=text)
    assert len(found) == 3
    (one,) = (one for one in found if "organism" in one.where)
    assert one.where.startswith("x.toml, key organism")
    assert reason in one.what
    if "required" not in reason:
        assert "package fake 1.0" in one.what
        assert "fake:X" in one.where


def test_a_validators_message_is_reported(problem, custom, install, working):
    source = """
from pydantic import field_validator, model_validator
from gaitsim.errors import GaitsimError

class X(Body):
    legs: int = option(4, "legs")
    arms: int = option(0, "arms")

    @field_validator("legs")
    @classmethod
    def _even(cls, legs):
        if legs == 1:
            raise GaitsimError("one leg is too few")
        assert legs % 2 == 0, "legs come in pairs"
        return legs

    @model_validator(mode="after")
    def _together(self):
        if self.legs + self.arms > 8:
            raise ValueError("at most 8 limbs")
        return self
"""
    install("fake", working + source, {"organism": {"x": "X"}, "fitness": {"far": "Distance"}})
    text = custom(organism="x", fitness="far")
    found = problem("organism.legs=3", text=text)
    assert found.what == "invalid organism.legs: 3 (legs come in pairs)"
    found = problem("organism.arms=8", text=text)
    assert found.what == "at most 8 limbs"
    assert found.where == "x.toml, section organism, with organism.arms from the command line"
    found = problem("organism.legs=1", text=text)
    assert found.what == "one leg is too few"
    assert "package fake 1.0" in found.where
