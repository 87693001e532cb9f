"""A challenge code: what it holds, that damage is found, and that reading it is safe."""

import hashlib
import random
import string
import struct
from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import gaitsim as gs
from gaitsim.errors import GaitsimError
from gaitsim.individual import Individual
from gaitsim.sharing import code as codes
from gaitsim.sharing.challenge import Challenge, code_of

CHARACTERS = string.ascii_letters + string.digits + "-_"
DICTIONARY = "3fc9d0bfa417c4dfbd22781a7dd3183707a3a4395d186a26c4bdd933f6fd318d"
SPIDER = (
    "gaitsim1-AAAA-hNhgIAHoj-lPi5_a58mAeIxMzBcY2RgGETFnin6YN9omTda5o2WeaNlHull3qe-DzYnqxyslzL"
    "4mli0BUiGuTjd8MhYodCd7xKnE_4t9AZDg_bab7e9q9ITFnuc6ypd8M1xyY6AxjnODNkXfuSzcXJsY3qyqYH_f84"
    "apjn64qXc7xgOpc-fET9rJvt83r9Gc3b5ah2vPLTxc2Ymg85MYaObn47V3zDcuyOKe82UtLKnp5ZZJzK8MZu_W6_"
    "zo4y3gZ3mub4TAUcunF9z9uJWhlkn2Y-u_3D_xleWN-z3PtrDAIO9vcP-_fvt99s7ABn2AOqZJE--iA"
)


def challenge(name="millipede", score=0.1, generation=7, **changes):
    experiment = gs.load_experiment(name)
    genome = experiment.space().random(1, np.random.default_rng(4))[0]
    found = Challenge.of(Individual(experiment, score, {}, generation, genome))
    return replace(found, **changes)


@pytest.fixture(scope="module")
def millipede():
    return challenge()


@pytest.mark.parametrize("name", ["millipede", "spider", "walker-worlds"])
def test_a_code_holds_its_experiment_genome_and_score_to_the_bit(name):
    experiment = gs.load_experiment(name, {"seed": 3})
    genome = experiment.space().random(1, np.random.default_rng(1))[0]
    for score in (0.1 + 0.2, -0.0):
        made = Individual(experiment, score, {}, 123, genome, member=gs.Member(9))
        code = code_of(made)
        found = Challenge.read(code)
        assert set(code) <= set(CHARACTERS)
        assert struct.pack("d", found.score) == struct.pack("d", score)
        assert (found.generation, found.member) == (123, 9)
        assert found.genome.dtype == genome.dtype
        assert found.genome.tobytes() == genome.tobytes()
        assert found.experiment.to_toml() == experiment.to_toml()
        assert found.code == code


def test_codes_of_this_format_are_read_for_ever():
    dictionary = files("gaitsim.sharing").joinpath("dictionary-1.txt").read_bytes()
    assert hashlib.sha256(dictionary).hexdigest() == DICTIONARY
    found = Challenge.read(SPIDER)
    assert found.experiment.name == "spider"
    assert found.score == 0.926750710183736
    assert len(found.genome) == 24


def test_white_space_and_long_dashes_do_not_matter(millipede):
    code = millipede.code
    broken = " \n".join(code[at : at + 10] for at in range(0, len(code), 10)) + "\r\n"
    assert Challenge.read(f"\n {broken}").score == millipede.score
    assert codes.contains_code(f"`{code}`")
    assert Challenge.read(f"`{code}`\n").score == Challenge.read(f'"{code}"').score
    content = next(c for n in range(10_000) if "--" in codes.encode(c := str(n).encode()))
    assert codes.decode(codes.encode(content).replace("--", "—")) == content


@pytest.mark.parametrize(
    "text",
    [
        "\ufeff{}",
        "“{}”",
        "({}), my best so far",
        "Look at this: {} walks 3 m",
        "Look at this:\n{}\nSee you, Ada",
        "https://example.org/play?code={}&speed=2",
        "https://example.org/#{}",
    ],
)
def test_a_code_is_found_in_a_text(millipede, text):
    whole = text.format(millipede.code)
    assert codes.contains_code(whole)
    assert Challenge.read(whole).code == millipede.code


@pytest.mark.parametrize("mark", ["> ", ">> ", "\u200b", "> \u2060"])
def test_a_code_is_found_in_quoted_lines(millipede, mark):
    code = millipede.code
    lines = ["Ada wrote:", *(code[at : at + 40] for at in range(0, len(code), 40)), "See you"]
    assert Challenge.read("\r\n".join(f"{mark}{line}" for line in lines)).code == code


def test_a_name_that_contains_the_prefix_is_not_a_code():
    assert not codes.contains_code("runs/my-gaitsim1-run")
    assert not codes.contains_code("gaitsim 1-2")


def test_every_changed_missing_or_extra_character_is_damage(millipede):
    code, chance = millipede.code, random.Random(1)
    for at in range(len(codes.PREFIX), len(code)):
        other = chance.choice(CHARACTERS.replace(code[at], ""))
        for damaged in (
            code[:at] + other + code[at + 1 :],
            code[:at] + code[at + 1 :],
            code[:at] + other + code[at:],
            code[:at],
        ):
            with pytest.raises(GaitsimError, match="the challenge code is damaged"):
                Challenge.read(damaged)
    for last in set(CHARACTERS) - {code[-1]}:
        with pytest.raises(GaitsimError, match="is damaged"):
            Challenge.read(code[:-1] + last)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "not a challenge code"),
        ("spider", "not a challenge code"),
        ("gaitsim1-", "is damaged: nothing follows gaitsim1-"),
        ("gaitsim1-zzzzAAAA", "is damaged: its first characters are missing or were changed"),
        (SPIDER[:-5], "it should have 343 characters but has 338"),
        (SPIDER + "A", "it should have 343 characters but has 344"),
        ("gaitsim2-AAAAAAAA", "has format 2"),
        ("gaitsim1-AAA…AAAA", "character 13 is '…'"),
    ],
)
def test_other_texts_are_refused_with_the_reason(text, words):
    with pytest.raises(GaitsimError, match=words):
        Challenge.read(text)


def test_a_code_that_inflates_beyond_the_limit_is_refused(monkeypatch):
    monkeypatch.setattr(codes, "LARGEST", 100_000_000)
    code = codes.encode(bytes(20_000_000))
    monkeypatch.undo()
    assert len(code) < 100_000
    with pytest.raises(GaitsimError, match="larger than"):
        Challenge.read(code)


def sealed(packed):
    """Return the code of compressed bytes, whatever they are."""
    length = len(packed) + codes._LENGTH + codes._CHECKSUM
    data = length.to_bytes(codes._LENGTH, "big") + packed
    return codes.PREFIX + codes._text(data + codes._checksum(data))


@given(st.binary(max_size=200))
@settings(max_examples=30, deadline=None)
def test_any_sealed_bytes_are_refused(packed):
    with pytest.raises(GaitsimError):
        Challenge.read(sealed(packed))
    with pytest.raises(GaitsimError):
        Challenge.read(codes.encode(packed))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"score": float("nan")}, "score is nan, not a finite number"),
        ({"generation": 0}, "generation is 0, not from 1 to 100,000,000"),
        ({"generation": 4_000_000_000}, "generation is 4,000,000,000, not from 1 to"),
        ({"genome": np.array([np.nan])}, "not finite"),
        ({"versions": {"numpy": "\x1b[2J"}}, "not texts"),
        ({"versions": {"x": "1" * 6000}}, "not texts"),
        ({"text": "x" * 2_000_001}, "too long"),
    ],
)
def test_claims_that_cannot_be_are_refused(millipede, changes, words):
    with pytest.raises(GaitsimError, match=words):
        Challenge.read(replace(millipede, **changes).code)


def test_gaits_of_files_and_failures_have_no_code(millipede):
    made = millipede.individual
    with pytest.raises(GaitsimError, match="no genome"):
        code_of(replace(made, genome=None))
    with pytest.raises(GaitsimError, match="no score"):
        code_of(replace(made, score=-np.inf))


def test_a_text_of_millions_of_characters_is_refused_at_once():
    with pytest.raises(GaitsimError, match="more than the maximum"):
        Challenge.read("gaitsim1-" + "A" * 2 * codes.LONGEST)
