"""The choices of options equal the available implementations."""

from typing import get_args

import pytest

from gaitsim import choices, network
from gaitsim.render import film, scene
from gaitsim.render.plots import style
from gaitsim.render.terminal.body import NAMED
from gaitsim_imitation import learning


@pytest.mark.parametrize(
    ("chosen", "there"),
    [
        (choices.Theme, style.THEMES),
        (choices.Theme, scene.THEMES),
        (choices.VideoView, scene.VIEWS),
        (choices.TerminalView, NAMED),
        (choices.VideoFormat, film.FPS),
        (choices.VideoFormat, film.SIZES),
        (choices.TrainingPreset, learning.SETTINGS),
    ],
)
def test_choices_equal_the_implementations(chosen, there):
    assert get_args(chosen) == tuple(there)


def test_networks_have_the_activations_of_imitators():
    assert set(get_args(choices.Activation)) <= set(network.ACTIVATIONS)
