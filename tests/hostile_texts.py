"""Texts that would control a terminal, and a plugin package that uses them everywhere."""

import re

# Unescaped, the text would write to the clipboard, change colours, reverse the text after it, and
# be interpreted as markup, a link, an emoji and an equation.
HOSTILE = "é\x1b]52;c;ZXZpbA==\x07\x9b31m\u202e[bold]b[/nope][link=http://evil]:boom:$\\frac{"
MARKUP = "[bold]b[/nope][link=http://evil]:boom:$\\frac{"  # the printable part
NAME = HOSTILE.replace("/", "")  # a valid name of a folder

_STYLES = re.compile(r"\x1b\[[0-9;?]*[a-zA-Z]")  # gaitsim's own colours and cursor movements
_RAW = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")


def raw(text, styled=False):
    """Return the characters of a text that a terminal would interpret as commands."""
    return _RAW.findall(_STYLES.sub("", text).replace("\r", "") if styled else text)


PACKAGE = f"""
from typing import ClassVar
import numpy as np
from gaitsim.contracts import Channel, Fitness, Measure, Motion, RealSpace, Skeleton, option
from gaitsim_puppets import Best, Puppet, Reach

EVIL, MARKUP = {HOSTILE!r}, {MARKUP!r}

class Body(Puppet):
    __doc__ = EVIL
    length: float = option(1.0, EVIL, unit=EVIL, ge=0)
    text: str = option(EVIL, EVIL)
    channels: ClassVar = {{**Puppet.channels, EVIL: Channel(("frames", EVIL), EVIL, EVIL)}}

    def genome_space(self):
        return RealSpace(np.full(3, -1.0), np.full(3, 2.0), (EVIL + "1", EVIL + "2", EVIL + "3"))

    def move(self, genomes):
        motion = super().move(genomes)
        channels = {{name: motion[name] for name in Puppet.channels}}
        return Motion(4.0, channels | {{EVIL: channels["joint_angles"]}}, failures={{0: EVIL}})

    def skeleton(self, motion, individual):
        names = (EVIL, EVIL + "b", EVIL + "c")
        return Skeleton(np.zeros((5, 3, 2, 3)), names, motion.frame_rate)

    def measures(self, motion):
        return {{EVIL: Measure(motion["reach"], EVIL, EVIL)}}

    def joint_names(self):
        return (EVIL + "1", EVIL + "2", EVIL + "3")

class Score(Reach):
    __doc__ = EVIL
    needs: ClassVar = ("reach", EVIL)

    def terms(self, motion):
        return {{MARKUP: motion["reach"], MARKUP + "2": motion[EVIL][:, -1].sum(axis=1)}}

class Broken(Best):
    __doc__ = EVIL

    def parents(self, scores, pairs, rng):
        raise ValueError(EVIL)
"""
ENTRIES = {
    "organism": {"wicked": "Body"},
    "fitness": {"wicked-score": "Score"},
    "selection": {"wicked-broken": "Broken"},
}
CHANGES = ("organism.plugin=wicked", "fitness.plugin=wicked-score", f"description={MARKUP}")
