"""A body's tables of reflexes become plugins, in order; what is wrong in them is named."""

import pytest

from gaitsim.errors import GaitsimError
from gaitsim.registry import load_reflexes
from gaitsim_reflexes.heading import Heading

MIRROR = """
from typing import ClassVar

from gaitsim.contracts import Reflex, option


class Mirror(Reflex):
    needs: ClassVar[object] = NEEDS
    gain: float = option(1.0, "gain", ge=0, le=2)

    def step(self, state, seen, inputs, interval):
        inputs.command[:, 1] -= self.gain * seen.orientation[:, 2]
"""


def test_reflexes_are_in_the_order_of_the_tables(install):
    install("fake", MIRROR.replace("NEEDS", '("orientation",)'), {"reflex": {"mirror": "Mirror"}})
    found = load_reflexes({"mirror": {}, "heading": {"gain": 3}})
    assert list(found) == ["mirror", "heading"]
    assert found["mirror"].gain == 1.0
    assert found["heading"] == Heading(gain=3.0)
    assert load_reflexes({}) == {}


WRONG = {
    "an unknown name": ({"hedding": {}}, "reflexes.hedding", "did you mean 'heading'?", "heading"),
    "a value out of bounds": (
        {"heading": {"gain": 99.0}},
        "reflexes.heading.gain",
        "",
        "a number ≥ 0 and ≤ 50, in 1/s",
    ),
    "no table": ({"heading": 4}, "reflexes.heading", "", "a table of options: gain"),
}


@pytest.mark.parametrize(("tables", "key", "remedy", "allowed"), WRONG.values(), ids=WRONG)
def test_what_is_wrong_is_named(tables, key, remedy, allowed):
    with pytest.raises(GaitsimError) as raised:
        load_reflexes(tables)
    error = raised.value
    assert (error.key, error.remedy) == (key, remedy)
    assert allowed in error.allowed
    assert key.rpartition(".")[2] in error.what


@pytest.mark.parametrize("needs", ['("orientation", "nose")', '"load"', "None"])
def test_a_reflex_needs_known_observations(install, needs):
    install("fake", MIRROR.replace("NEEDS", needs), {"reflex": {"mirror": "Mirror"}})
    with pytest.raises(
        GaitsimError, match=r"fake 1\.0 .* names among orientation, rates"
    ) as raised:
        load_reflexes({"mirror": {}})
    assert raised.value.key == "reflexes.mirror"
