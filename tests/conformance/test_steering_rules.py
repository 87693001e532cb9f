"""The rules for steered bodies, and bodies that break them."""

import numpy as np
import pytest
from cart import Cart, SteeredCart, motion
from gaitsim.testing.rules.steering import check_steering

from gaitsim.experiment import load_experiment
from gaitsim_robot.organism import Robot


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fly-steer-hover", "hexapod"])
def test_bundled_bodies_conform(name):
    assert not [*check_steering(load_experiment(name).organism)]


def test_a_body_without_commands_or_controllers_is_not_checked(monkeypatch):
    assert not [*check_steering(load_experiment("walker").organism)]
    assert not [*check_steering(Cart())]
    assert not [*check_steering(Robot(engine="bullet"))]
    monkeypatch.setattr(Cart, "controllers", lambda self: {})
    monkeypatch.setattr(Cart, "steer", None)
    assert not [*check_steering(Cart())]


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
    ("name", "broken", "message"),
    [
        ("advance", lazy, "however frames are split"),
        ("advance", late, "without the frame before"),
        ("drive", lambda cart: {"duration": 1.2}, "with the options of drive"),
    ],
)
def test_broken_bodies_are_found(monkeypatch, name, broken, message):
    monkeypatch.setattr(SteeredCart, name, broken)
    [found] = check_steering(Cart())
    assert message in str(found)


def test_another_type_is_found(monkeypatch):
    monkeypatch.setattr(Cart, "steer", lambda self, controllers: None)
    [found] = check_steering(Cart())
    assert "a NoneType" in str(found)
