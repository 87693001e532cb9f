"""Conversion of every bit pattern to degrees and back, and repair of patterns beyond 20°."""

import numpy as np
import pytest
from bit_strings import encoded
from hypothesis import given, settings, strategies as st

from gaitsim_millipede.codec import CODECS

SIGNED, UNSIGNED = CODECS["sign-magnitude"], CODECS["unsigned"]
BOTH = pytest.mark.parametrize("codec", CODECS.values(), ids=CODECS)


def decoded(codec, genomes):
    return codec.degrees[codec.codes(genomes)].T


def every_pattern(codec):
    """Return all bit patterns of a leg, (patterns, bits)."""
    return np.array(list(np.ndindex((2,) * codec.bits)), dtype=np.uint8)


def genomes(codec):
    return st.integers(1, 9).flatmap(
        lambda legs: st.lists(
            st.lists(st.integers(0, 1), min_size=legs * codec.bits, max_size=legs * codec.bits),
            min_size=1,
            max_size=5,
        ).map(lambda rows: np.array(rows, dtype=np.uint8))
    )


@BOTH
def test_every_angle_survives_encoding(codec):
    angles = np.arange(-20 if codec.signed else 0, 21)
    np.testing.assert_array_equal(decoded(codec, encoded(codec, angles)), angles[None])


@BOTH
def test_every_pattern_decodes_to_sign_and_magnitude_up_to_20(codec):
    for bits in every_pattern(codec):
        text = "".join(map(str, bits))
        magnitude = min(int(text[-5:], 2), 20)
        backward = codec.signed and text[0] == "1"
        assert decoded(codec, bits[None]) == (-magnitude if backward else magnitude)


def test_the_source_writes_20_degrees_as_10100():
    np.testing.assert_array_equal(encoded(UNSIGNED, [20]), [[1, 0, 1, 0, 0]])
    np.testing.assert_array_equal(
        encoded(SIGNED, [20, -20])[0], [0, 1, 0, 1, 0, 0, 1, 1, 0, 1, 0, 0]
    )


@BOTH
def test_repair_is_the_encoding_of_what_was_decoded(codec):
    patterns = every_pattern(codec)
    for before, after in zip(patterns, codec.repair(patterns), strict=True):
        angle = int(decoded(codec, before[None])[0, 0])
        expected = encoded(codec, [angle])[0]
        if angle == 0:  # −0 keeps its sign bit
            expected = before
        np.testing.assert_array_equal(after, expected)


@BOTH
@settings(max_examples=60)
@given(data=st.data())
def test_repair_truncates_only_angles_beyond_20_degrees(codec, data):
    before = data.draw(genomes(codec))
    kept = before.copy()
    after = codec.repair(before)
    np.testing.assert_array_equal(before, kept)
    assert after.dtype == np.uint8
    np.testing.assert_array_equal(codec.repair(after), after)
    np.testing.assert_array_equal(decoded(codec, after), decoded(codec, before))
    old, new = (g.reshape(len(g), -1, codec.bits) for g in (before, after))
    weights = [16, 8, 4, 2, 1]
    beyond = old[..., -5:] @ weights > 20
    assert (new[..., -5:] @ weights <= 20).all()
    np.testing.assert_array_equal(new[~beyond], old[~beyond])
    if codec.signed:
        np.testing.assert_array_equal(new[..., 0], old[..., 0])


@BOTH
def test_codes_are_the_bits_read_as_one_number_leg_by_leg(codec):
    rng = np.random.default_rng(0)
    population = rng.integers(0, 2, (7, 4 * codec.bits), dtype=np.uint8)
    places = 2 ** np.arange(codec.bits)[::-1]
    expected = population.reshape(7, 4, codec.bits) @ places
    np.testing.assert_array_equal(codec.codes(population), expected.T)


def test_every_bit_has_a_label():
    assert SIGNED.labels(["L1", "R1"])[:7] == (
        *("L1 sign", "L1 16", "L1 8", "L1 4", "L1 2", "L1 1"),
        "R1 sign",
    )
    assert UNSIGNED.labels(["L1"]) == ("L1 16", "L1 8", "L1 4", "L1 2", "L1 1")


@BOTH
def test_reaches_are_sines_with_exact_sums(codec):
    sines = np.sin(np.radians(codec.degrees)) / np.sin(np.radians(20))
    np.testing.assert_allclose(codec.reaches, sines, atol=5e-13)
    assert codec.reaches.max() == 1
    legs = np.random.default_rng(1).choice(codec.reaches, 1000)
    assert legs.sum() == sum(legs.tolist()) == sum(sorted(legs.tolist()))
