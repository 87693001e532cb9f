"""The checks of steered bodies, and bodies that break them."""

import numpy as np
import pytest
from cart import Cart, SteeredCart, motion

from gaitsim.errors import GaitsimError
from gaitsim.experiment import load_experiment
from gaitsim_testing.checks.test_bodies import check_steering


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fly-steer-hover", "hexapod"])
def test_bundled_bodies_conform(name):
    check_steering(load_experiment(name).organism)


def test_a_body_without_commands_or_controllers_is_not_checked(monkeypatch):
    check_steering(load_experiment("walker").organism)
    check_steering(Cart())
    monkeypatch.setattr(Cart, "controllers", lambda self: {})
    monkeypatch.setattr(Cart, "steer", None)
    check_steering(Cart())


def lazy(cart, frames):
    """Advance by the commands of the last frame alone."""
    for _ in range(frames):
        cart.step()
    cart.wish = (0.0, 0.0)
    return motion(np.array(cart.places[-frames:])[None], {})


def late(cart, frames):
    """Return one frame too many."""
    for _ in range(frames):
        cart.step()
    return motion(np.array([cart.places[0], *cart.places[-frames:]])[None], {})


@pytest.mark.parametrize(
    ("owner", "name", "broken", "message"),
    [
        (SteeredCart, "advance", lazy, "however frames are split"),
        (SteeredCart, "advance", late, "without the frame before"),
        (SteeredCart, "drive", lambda cart: {"duration": 1.2}, "with the options of drive"),
        (Cart, "steer", lambda self, controllers: None, "a NoneType"),
    ],
)
def test_broken_bodies_are_found(monkeypatch, owner, name, broken, message):
    monkeypatch.setattr(owner, name, broken)
    with pytest.raises(GaitsimError) as raised:
        check_steering(Cart())
    assert message in str(raised.value)
