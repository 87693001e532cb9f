"""Descriptions of options, and conversion of typed values."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any, Literal, Optional

import pytest
from annotated_types import Ge
from hypothesis import given, settings, strategies as st
from pydantic import BaseModel, Field

from gaitsim.contracts import option
from gaitsim.errors import GaitsimError
from gaitsim.registry import options
from gaitsim.toml import literal, parse


class Gait(StrEnum):
    trot = "trot"
    pace = "pace"


class Leg(BaseModel):
    length: float = 0.1
    joints: int = 3


class Many(BaseModel):
    count: int = option(3, "how\n  many", ge=1, le=1_000_000)
    mass: float = option(1.0, "weight", unit="kg", gt=0, lt=2.5)
    tiny: float = option(1e-7, "small", ge=1e-7)
    exact: float = option(1.0, "exact", ge=1234567.5)
    limit: int | None = option(None, "limit", ge=1)
    old: Optional[float] = option(None, "old style")  # noqa: UP045
    level: Annotated[int, Ge(2)] | None = None
    side: Literal["left", "right"] = option("left", "side")
    legs: Literal[4, 6] = option(4, "legs")
    gait: Gait = option(Gait.trot, "gait")
    both: Literal["none", "auto"] | float = option("auto", "both")
    label: str = Field("x", min_length=1, max_length=3)
    ratio: int = Field(2, multiple_of=2)
    pair: tuple[float, float] = option((0.0, 1.0), "pair")
    row: tuple[int, ...] = option((1,), "row")
    layers: tuple[Annotated[int, Field(ge=1, le=9)], ...] = option((1,), "layers")
    names: list[str] = Field(default_factory=list)
    leg: Leg = Leg()
    anything: Any = None
    file: Path | None = None
    needed: float
    flag: bool = option(False, "flag")
    mode: Literal["none"] | None = None


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("file", "a path"),
        ("count", "a whole number ≥ 1 and ≤ 1,000,000"),
        ("mass", "a number > 0 and < 2.5, in kg"),
        ("tiny", "a number ≥ 1e-07"),
        ("exact", "a number ≥ 1,234,567.5"),
        ("limit", "a whole number ≥ 1"),
        ("side", '"left" or "right"'),
        ("legs", "4 or 6"),
        ("gait", '"trot" or "pace"'),
        ("both", '"none" or "auto" or a number'),
        ("label", "a string of at least 1 character and of at most 3 characters"),
        ("pair", "a list of 2 values: a number, a number"),
        ("row", "a list of values, each a whole number"),
        ("layers", "a list of values, each a whole number ≥ 1 and ≤ 9"),
        ("leg", "a table with the keys length, joints"),
        ("anything", "anything"),
        ("needed", "a number"),
        ("flag", "true or false"),
    ],
)
def test_allowed_values_in_words(name, words):
    assert options.allowed(Many.model_fields[name]) == words


def test_unit_meaning_and_default_of_an_option():
    fields = Many.model_fields
    assert options.unit(fields["mass"]) == "kg"
    assert options.unit(fields["label"]) == ""
    assert options.meaning(fields["count"]) == "how many"
    assert options.meaning(fields["label"]) == ""
    defaults = {name: options.default(field) for name, field in fields.items()}
    assert defaults["gait"] == '"trot"'
    assert defaults["flag"] == "false"
    assert defaults["limit"] == "none"
    assert defaults["names"] == "[]"
    assert defaults["pair"] == "[0.0, 1.0]"
    assert defaults["needed"] == "required"
    assert defaults["leg"] == "{length = 0.1, joints = 3}"


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1", 1),
        ("-0.5", -0.5),
        ("true", True),
        ('"a b"', "a b"),
        ("[1, 2]", [1, 2]),
        ("1 # one", 1),
        ("sine", "sine"),
        ("[bold]", "[bold]"),
        ("1\nother = 2", "1\nother = 2"),
        ("9" * 5000, "9" * 5000),
        ("0x" + "f" * 5000, "0x" + "f" * 5000),
        ("\0", "\0"),
    ],
)
def test_a_value_is_toml_or_a_text(text, value):
    found = options.parse_value(text)
    assert found == value
    assert type(found) is type(value)


@pytest.mark.parametrize(
    ("name", "typed", "value"),
    [
        ("limit", "none", None),
        ("limit", "3", 3),
        ("count", "none", "none"),
        ("mode", "none", None),
        ("both", "none", "none"),
        ("label", "12", "12"),
        ("label", '"12"', "12"),
        ("mass", ".5", 0.5),
        ("mass", "5 kg", "5 kg"),
    ],
)
def test_typed_values_are_read_by_the_type_of_the_option(name, typed, value):
    field = Many.model_fields[name]
    found = options.convert_value(field, options.parse_value(typed), typed)
    assert found == value
    assert type(found) is type(value)


@settings(max_examples=50)
@given(st.text())
def test_any_text_is_a_value(text):
    options.parse_value(text)


plain = st.recursive(
    st.text() | st.booleans() | st.integers(-(2**63), 2**63 - 1) | st.floats(),
    lambda inner: st.lists(inner, max_size=3),
    max_leaves=5,
)


@given(plain)
def test_a_literal_is_one_short_line(value):
    text = literal(value)
    assert len(text) <= 60
    assert "\n" not in text


@given(st.integers(-(2**63), 2**63 - 1) | st.booleans() | st.floats(allow_nan=False))
def test_a_short_literal_is_toml(value):
    assert parse(f"value = {literal(value)}", "")["value"] == value


@pytest.mark.parametrize(
    ("text", "what", "where"),
    [
        ("a = 1\na = 2\n", "overwrite", "x.toml, line 2, column 6"),
        ("[a]\n[a]", "twice", "x.toml, line 2, column 3"),
        ("a = sine", "Invalid value", "x.toml, line 1, column 5"),
        ("a = 1\0", "not valid TOML", "x.toml, line 1"),
        ("a = " + "9" * 5000, "a whole number is too long", "x.toml"),
        ("a = 0x" + "f" * 5000, "a whole number is too long", "x.toml, key a"),
        ("a = " + "[" * 3000, "nested too deeply", "x.toml"),
        pytest.param("a." * 3000 + "a = 1", "nested too deeply", "x.toml", id="long key"),
    ],
)
def test_invalid_toml_is_reported_with_its_place(text, what, where):
    with pytest.raises(GaitsimError) as raised:
        parse(text, "x.toml")
    assert what in raised.value.what
    assert raised.value.where.startswith(where)
