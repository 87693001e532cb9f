"""Mutated plugins: the checks reject each broken one, advise on others, and accept correct ones."""

import pytest

from conftest import WORKING
from gaitsim.registry import Entry
from gaitsim_testing.checking import Checked, check_plugins, run_pytest
from gaitsim_testing.packages import select_plugins

SOUND = {
    "organism": "Body",
    "fitness": "Distance",
    "search": "Fresh",
    "selection": "First",
    "crossover": "Solo",
    "mutation": "Still",
    "reflex": "Lean",
}
HEAD = """
import random, threading
from gaitsim.contracts import (
    PRESENT_CHANNEL, Channel, Dimension, EvolvingChannels, Measure, Members, Reflex, Skeleton,
    Solid, check_dimensions, check_world,
)
from gaitsim.encoding import GeneGroup, dimension_genes, genome_space
from pydantic import PrivateAttr, model_validator
calls = []
"""
REFLEX = '''
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
'''

MOVES = "def move(self, genomes):\n    return Motion(1.0, {'distance': %s})"
TERMS = "def terms(self, motion):\n    return %s"
CROSS = "def cross(self, mothers, fathers, space, rng):\n    %s"
MUTATE = "def mutate(self, genomes, space, rng):\n    %s"
PARENTS = "def parents(self, scores, pairs, rng):\n    %s"
PAIRS = "np.zeros((pairs, 2), np.intp)"

ASK = "def ask(self, state, last, context):\n    %s"
TELL = (
    "def tell(self, state, results, context):\n"
    "    told = super().tell(state, results, context)\n"
    "    %s"
)
FIGURES = "def figures(self, state):\n    return %s"
MEMBERS = """keeps: ClassVar = "front"
def members(self, state):
    best = state["best"]
    return Members(%s, np.zeros(len(best)), {"far": np.zeros(len(best))})
"""

JOINTS = """
channels: ClassVar = {"joint_angles": Channel(("frames", "joints"), "rad", ""), **Body.channels}
def joint_names(self):
    return ("a", "b", "c")
def move(self, genomes):
    return Motion(1.0, {"joint_angles": genomes[:, None].copy(), "distance": genomes[:, 0]})
def play(self, joint_angles):
"""

LEGS = """
damage: tuple[str, ...] = option((), "lost legs")
def leg_joints(self):
    return {"L": (), "R": ()}
"""

RIG = """
def rig(self):
    from gaitsim.contracts import Link, Rig
    return Rig(%s, (), %s, np.array([[[0.0, 0.0, 0.0], [0.0, 0.0, %s]]]), ("trunk",))
"""

WINDS = """
def conditions(self):
    from gaitsim.contracts import Condition
    return {"wind": Condition("", 0.0, 0.0, 1.0, 0.0, 9.0, "")}
"""

SIZES = """
dimensions: dict[str, float] = option({}, "factors")
evolve: tuple[str, ...] = option((), "genes")
ranges: dict[str, tuple[float, float]] = option({}, "ranges")
channels: ClassVar = EvolvingChannels(Body.channels)
def design_space(self):
    return {"thigh": Dimension("m", 0.2, "length"), "shank": Dimension("m", 0.1, "length")}
@model_validator(mode="after")
def check(self):
    check_dimensions(self.design_space(), self.dimensions, self.evolve, self.ranges)
    return self
def genome_space(self):
    groups = (GeneGroup("x", ("a", "b"), -1.0, 1.0),)
    return genome_space(
        (*groups, *dimension_genes(self.design_space(), self.evolve, self.ranges))
    )
def factors(self, genomes):
    own = dict(zip(self.evolve, genomes[:, 2:].T))
    same = np.ones(len(genomes))
    return [own.get(n, same * self.dimensions.get(n, 1.0)) for n in ("thigh", "shank")]
def move(self, genomes):
    thigh, shank = self.factors(genomes)
    motion = Motion(1.0, {"distance": genomes[:, 0] * (thigh + shank)})
    if self.evolve:
        motion.add("dimensions", genomes[:, 2:].copy())
    return motion
def skeleton(self, motion, individual):
    if self.evolve:
        return self.embody(motion["dimensions"][individual])[0].skeleton(motion, individual)
    end = 0.2 * self.dimensions.get("thigh", 1.0)
    return Skeleton(np.array([[[[0, 0, 0], [end, 0, 0]]]]), ("thigh",), 1.0)
"""

DIFFERING = """
joints: int = option(0, "joints of the body; 0 for those that the genome says")
channels: ClassVar = {
    **Body.channels, "present": PRESENT_CHANNEL, "load": Channel(("joints",), "N", "load")
}
def joint_names(self):
    return ("left", "right")[: self.joints or 2]
def move(self, genomes):
    count = np.where(genomes[:, 0] > 0, 2, 1) if not self.joints else self.joints
    present = np.arange(len(self.joint_names())) < np.reshape(count, (-1, 1))
    present = np.broadcast_to(present, (len(genomes), present.shape[1])).copy()
    own = {"distance": genomes[:, 0], "present": present, "load": present * genomes[:, 1:]}
    return Motion(1.0, own)
def embody(self, genome):
    return self.model_copy(update={"joints": 2 if genome[0] > 0 else 1}), genome
"""

STEP = "def step(self, state, seen, inputs, interval):\n    "
START = "def start(self, legs, weights):\n    return "

ERRORS = {
    "organism": {
        "conditions without the option": (WINDS, "no option 'world'"),
        "a check of an unknown condition": (
            "def checks(self):\n    return ({'fog': 1.0},)",
            "unknown condition 'fog'",
        ),
        "a world that is not validated": (
            WINDS + "world: dict[str, float] = option({}, 'a world')",
            "the invalid world {'no-wind': 0.0} is accepted",
        ),
        "a nominal world that is another": (
            WINDS + "world: dict[str, float] = option({}, 'a world')\n"
            "def move(self, genomes):\n"
            "    return Motion(1.0, {'distance': genomes[:, 0] + len(self.world)})",
            "a different motion",
        ),
        "joints that the body lacks": (
            DIFFERING.replace('"present": present,', '"present": present | True,'),
            "has 2 in 'present'",
        ),
        "padding that is not 0": (
            DIFFERING.replace("present * genomes", "(present + 1) * genomes"),
            "load of a joint that is padded",
        ),
        "dimensions without options": (
            SIZES[SIZES.index("def design") : SIZES.index("@model")],
            "no option 'dimensions'",
        ),
        "a dimension of nothing": (
            SIZES.replace('"m", 0.1', '"m", 0.0'),
            "the dimension shank is",
        ),
        "dimensions that are not validated": (
            SIZES.replace("check_dimensions(self", "(self"),
            "is accepted",
        ),
        "an unknown dimension without those that exist": (
            SIZES.replace(
                "    check_dimensions(",
                "    if {'no-thigh'} & {*self.dimensions}:\n"
                "        raise ValueError('unknown')\n    check_dimensions(",
            ),
            "the error for an unknown dimension",
        ),
        "a factor of 1 that moves": (
            SIZES.replace("(thigh + shank)", "(thigh + shank + len(self.dimensions))"),
            "differs with a factor of 1",
        ),
        "no genes of dimensions": (
            SIZES.replace("(*groups, *dimension_genes", "(*groups, *0 * dimension_genes"),
            "one more gene for each",
        ),
        "no channel of dimensions": (
            SIZES.replace("if self.evolve:\n        motion", "if False:\n        motion"),
            "without the channel 'dimensions'",
        ),
        "dimensions of the first individual": (
            SIZES.replace("(thigh + shank)", "(thigh[0] + shank[0])"),
            "in another chunk",
        ),
        "a body of its own that moves differently": (
            SIZES + "def embody(self, genome):\n"
            "    return self.model_copy(update={'evolve': (), 'ranges': {}}), genome[:2]",
            "the body from embody()",
        ),
        "one skeleton for all": (
            SIZES.replace('self.dimensions.get("thigh", 1.0)', "1.0"),
            "skeletons of the same lengths",
        ),
        "a skeleton of another": (
            SIZES.replace('motion["dimensions"][individual])', 'motion["dimensions"][0])'),
            "a drawing with the individual's own dimensions",
        ),
        "genes that go with a leg": (
            LEGS + "def genome_space(self):\n"
            "    n = 2 - len(self.damage)\n"
            "    return RealSpace(-np.ones(n), np.ones(n), ('a', 'b')[:n])",
            "a different genome space",
        ),
        "labels twice": (
            "def genome_space(self):\n    return RealSpace(-np.ones(2), np.ones(2), ('a', 'a'))",
            "2 genes, 1 labels",
        ),
        "a start point outside the space": (
            "def starts(self):\n    return {'hop': np.full(2, 9.0)}",
            "an invalid genome as the start point 'hop'",
        ),
        "no genes": ("def genome_space(self):\n    return BitSpace(())", "0 genes"),
        "a repair that goes on": (
            "def genome_space(self):\n    return BitSpace(('a', 'b'), lambda g: 1 - g)",
            "",
        ),
        "no motion": ("def move(self, genomes):\n    return {}", "a dict"),
        "no frame rate": (
            "def move(self, genomes):\n    return Motion(0, {'distance': genomes[:, 0]})",
            "0",
        ),
        "a channel missing": (
            "channels: ClassVar = {**Body.channels, 'height': Channel((), 'm', '')}",
            "a motion without height",
        ),
        "a list": (MOVES % "list(genomes[:, 0])", "a list"),
        "time first": (MOVES % "genomes.T", "(3, 6)"),
        "another axis than declared": (MOVES % "genomes", "(6, 3)"),
        "another length than declared": (
            "channels: ClassVar = {'distance': Channel((('x', 'y'),), 'm', '')}\n"
            + MOVES % "genomes",
            "(6, 3)",
        ),
        "two lengths of one axis": (
            "channels: ClassVar = dict.fromkeys(\n"
            "    ['distance', 'rise'], Channel(('frames',), 'm', ''))\n"
            "def move(self, genomes):\n"
            "    return Motion(1.0, {'distance': genomes, 'rise': genomes[:, 1:]})",
            "2",
        ),
        "NaN": (
            MOVES % "np.log(np.abs(genomes[:, 0]) - 2)",
            "distance has non-finite values",
        ),
        "all failed": (
            "def move(self, genomes):\n    return Motion(1.0, {'distance': genomes[:, 0]}, None,"
            " {i: 'fell' for i in range(len(genomes))})",
            "fell",
        ),
        "joints without names": (
            "channels: ClassVar = {'joint_angles': Channel(('frames', 'joints'), 'rad', '')}\n"
            "def move(self, genomes):\n"
            "    return Motion(1.0, {'joint_angles': genomes[:, None], 'distance': genomes[:, 0]})",
            "3",
        ),
        "changed genomes": (
            "def move(self, genomes):\n    genomes += 1\n    return super().move(genomes - 1)",
            "move() changes the genomes",
        ),
        "memory": (
            "def move(self, genomes):\n    calls.append(1)\n"
            "    return Motion(1.0, {'distance': genomes[:, 0] + len(calls)})",
            "distance differs",
        ),
        "the population's mean": (
            MOVES % "genomes[:, 0] - genomes.mean()",
            "distance differs when individuals move",
        ),
        "the neighbour": (MOVES % "np.roll(genomes[:, 0], 1)", "in reverse order"),
        "other threads": (
            "threads: ClassVar = True\n"
            + MOVES % "genomes[:, 0] + (threading.current_thread() is not threading.main_thread())",
            "distance differs",
        ),
        "played angles that are changed": (
            JOINTS + "    joint_angles *= 0\n    return self.move(joint_angles[:, 0])",
            "play() changes the joint angles",
        ),
        "a drawing of nothing": (
            "def skeleton(self, motion, individual):\n"
            "    return Skeleton(np.zeros((0, 1, 2, 3)), ('point',), 1.0)",
            "0 frames",
        ),
        "a solid that is not turned": (
            "def skeleton(self, motion, individual):\n"
            "    solids = (Solid('ball', 'sphere', (0.1,)),)\n"
            "    return Skeleton(np.zeros((1, 1, 2, 3)), ('point',), 1.0,\n"
            "                    solids=solids, poses=np.zeros((1, 1, 7)))",
            "a quaternion of length 0",
        ),
        "a rig that is not a tree": (
            RIG % ("(Link('trunk', 'trunk'),)", "('point',)", 0.0),
            "the parent 'trunk'",
        ),
        "a rig of other segments": (RIG % ("(Link('trunk'),)", "('line',)", 0.0), "line"),
        "one measure for all": (
            "def measures(self, motion):\n"
            "    return {'far': Measure(motion['distance'].mean(), 'm', 'how far')}",
            "shape ()",
        ),
        "global randomness": (
            "def genome_space(self):\n    random.random()\n    return super().genome_space()",
            "",
        ),
        "an exception": (MOVES % "1 / 0", "ZeroDivisionError"),
        "no default": ("legs: int = option(..., 'legs', ge=1)", "legs has no default"),
        "no help": ("legs: int = option(4, '', ge=1)", "legs has no description"),
        "a default out of bounds": ("legs: int = option(4, 'legs', ge=6)", "legs = 4"),
        "an option that no file holds": (
            "sizes: dict = option({1: 2}, 'sizes by number')",
            "",
        ),
    },
    "fitness": {
        "no terms": (TERMS % "{}", "does not return a dict with terms"),
        "one term for all": (TERMS % "{'d': motion['distance'].mean()}", "shape ()"),
        "a channel that is not told": (
            "needs: ClassVar = ()\n" + TERMS % "{'d': motion['distance']}",
            "reads distance",
        ),
        "a rank": (
            TERMS % "{'d': motion['distance'] - motion['distance'].max()}",
            "chunk of 1",
        ),
        "a changed motion": (
            "def terms(self, motion):\n    d = motion['distance']\n    d *= 2\n    return {'d': d}",
            "terms() changes the channel distance",
        ),
    },
    "search": {
        "a state of lists": (
            TELL % "return {'best': told['best'].tolist()}",
            "best: a list",
        ),
        "a state that gets more": (
            TELL % "return {**told, 'score': np.array(1.0)}",
            "score: changed after tell()",
        ),
        "a state that is changed": (
            TELL % "state['best'][...] = 0; return told",
            "tell() changes its arguments",
        ),
        "too few genomes": (ASK % "return context.random(3), state", "(3, "),
        "genomes that are not repaired": (
            ASK % "return context.random(context.population) + context.space.dtype.type(2), state",
            "invalid genomes",
        ),
        "genomes lost where all fail": (
            TELL % "return {'best': np.mean(results.genomes, 0, where=np.isfinite(results.scores)"
            "[:, None], keepdims=True).astype(results.genomes.dtype)}",
            "invalid genomes",
        ),
        "parents that do not exist": (
            ASK % "context.record_parents(np.full((context.population, 2), 10**6)); "
            "return super().ask(state, last, context)",
            "parents that do not exist",
        ),
        "parents of the wrong shape": (
            ASK % "context.record_parents(np.zeros(context.population)); "
            "return super().ask(state, last, context)",
            "record_parents()",
        ),
        "genomes by chance": (
            ASK % "return context.space.random(context.population, np.random.default_rng()), state",
            "different bits",
        ),
        "a search with a memory of its own": (
            "_told: set = PrivateAttr(default_factory=set)\n"
            + TELL % "self._told.add(context.generation); return told\n"
            + ASK
            % "return np.roll(super().ask(state, last, context)[0], len(self._told), 0), state",
            "genomes: different after generation 1",
        ),
        "a refused state of its own": (
            "def mismatch(self, state, context):\n    return 'too old'",
            "too old",
        ),
        "a name that is read": ("def reads(self):\n    return 'far'", "'far'"),
        "figures that come and go": (
            FIGURES % "{'best': 1.0} if state['best'].sum() > 0 else {}",
            "",
        ),
        "members that are not kept": ('keeps: ClassVar = "front"', "a NoneType"),
        "members outside the space": (MEMBERS % "best + np.uint8(9)", "invalid genomes"),
        "an archive without cells": (
            (MEMBERS % "best").replace("front", "archive"),
            "None",
        ),
        "several populations with a state": (
            "several: ClassVar = True\n"
            + ASK
            % "shape = (*context.populations, context.population, context.space.genes)\n"
            "    return context.random(int(np.prod(shape[:-1]))).reshape(shape), state",
            "best",
        ),
    },
    "selection": {
        "parents out of range": (PARENTS % f"return {PAIRS} + 50", "50 to 50"),
        "parents by chance": (
            PARENTS % "return np.random.default_rng().integers(0, len(scores), (pairs, 2))",
            "different",
        ),
        "sorted scores": (PARENTS % f"scores.sort(); return {PAIRS}", "() changes the "),
        "others for several populations": (
            "def parents_each(self, scores, pairs, rng):\n"
            "    return np.ones((len(scores), pairs, 2), np.intp)",
            "a different choice",
        ),
    },
    "crossover": {
        "too few children": (CROSS % "return mothers[:1].copy()", "(1, "),
        "the mothers themselves": (CROSS % "return mothers", "shares memory"),
        "genes that are not numbers": (CROSS % "return mothers * np.nan", ""),
    },
    "mutation": {
        "integers": (MUTATE % "return genomes.astype(int)", "int64"),
        "changed parents": (
            MUTATE % "genomes *= 2; return genomes.copy()",
            "() changes the ",
        ),
        "genes that are not bits": (
            MUTATE % "return genomes + genomes.dtype.type(3)",
            "",
        ),
    },
    "reflex": {
        "a state without population": (START + "{'last': np.zeros(3)}", "(3,)"),
        "a state by chance": (
            START + "{'last': np.random.default_rng().random(len(weights))}",
            "another",
        ),
        "changed observations": (STEP + "seen.orientation[:] = 0", "orientation"),
        "a new array of inputs": (
            STEP + "inputs.reach = inputs.reach + 1",
            "reach",
        ),
        "a new array of the state": (
            STEP + "state['last'] = state['last'] + 1",
            "last",
        ),
        "an observation that it does not declare": (
            STEP + "inputs.reach += seen.load",
            "reach is not finite after 1 steps",
        ),
        "a mean over the population": (
            STEP + "inputs.command[:, 1] += seen.orientation[:, 2].mean()",
            "command of step 0",
        ),
        "a choice by the value of an option": (
            STEP + "inputs.command[:, 1] += 1.0 if self.gain > 0 else 0.0",
            "ambiguous",
        ),
        "a number for each leg": (
            STEP + "inputs.rate *= self.gain",
            "broadcast",
        ),
        "an option that C does not have": ("def c99(self):\n    return 'o->force;'", "force"),
    },
}

ADVICE = {
    "organism": {
        "a number without bounds": ("legs: int = option(4, 'legs')", "legs"),
        "a channel that is not told": (
            "def move(self, genomes):\n"
            "    return Motion(1.0, {'distance': genomes[:, 0], 'height': genomes[:, 1]})",
            "height not declared",
        ),
    },
    "fitness": {
        "a channel that is not read": (
            TERMS % "{'d': np.zeros(motion.population)}",
            "never reads distance",
        ),
        "channels of no body": ("needs: ClassVar = ('wheels',)", "no installed body"),
        "never finite": (
            TERMS % "{'d': motion['distance'] * np.nan}",
            "no finite score",
        ),
    },
    "search": {
        "a search that refuses its spaces": (
            "def objection(self, space, population):\n    return 'too large' * (space.genes == 7)",
            "bits: too large",
        )
    },
    "selection": {
        "the worst": (
            PARENTS % "return np.full((pairs, 2), np.argmin(scores), np.intp)",
            "",
        )
    },
}


CORRECT = {
    ("organism", "A body with bits"): ("BitBody", "pass"),
    ("organism", "A body in a wind"): (
        "Body",
        WINDS + "world: dict[str, float] = option({}, 'a world')\n"
        "@model_validator(mode='after')\n"
        "def check(self):\n"
        "    check_world(self.world, self.conditions())\n"
        "    return self",
    ),
    ("organism", "A body with dimensions"): ("Body", SIZES),
    ("reflex", "A reflex whose state has the names of inputs"): (
        "Lean",
        "def start(self, legs, weights):\n"
        "    names = 'reach', 'stride', 'rate', 'command'\n"
        "    return {'last': np.zeros(len(weights)), 'genes': weights.copy(),\n"
        "            **{name: np.zeros(len(weights)) for name in names}}",
    ),
}


def mutants():
    """Return the base class and the body of each class by kind and name."""
    found = dict(CORRECT)
    for kind, base in SOUND.items():
        found[kind, f"A correct {kind}"] = base, "pass"
        for name, (body, _) in (ERRORS[kind] | ADVICE.get(kind, {})).items():
            found[kind, name] = base, body
    return found


@pytest.fixture(scope="module")
def checked(tmp_path_factory):
    """Return the findings in each plugin, all of them in one process."""
    folder = tmp_path_factory.mktemp("mutants")
    source, points = WORKING + HEAD + REFLEX, {kind: {} for kind in SOUND}
    for number, ((kind, name), (base, body)) in enumerate(mutants().items()):
        lines = "\n    ".join(body.strip("\n").splitlines())
        source += f"class X{number}({base}):\n    'A plugin.'\n    {lines}\n"
        points[kind][name] = f"mutants:X{number}"
    (folder / "mutants.py").write_text(source)
    info = folder / "mutants-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: mutants\nVersion: 1.0\n")
    text = "\n".join(
        line
        for kind, names in points.items()
        for line in (f"[gaitsim.{kind}]", *(f"{name} = {at}" for name, at in names.items()))
    )
    (info / "entry_points.txt").write_text(text)
    found = [
        Checked(Entry(kind, name, target, "mutants", "1.0"))
        for kind, names in points.items()
        for name, target in names.items()
    ]
    assert run_pytest(found, [str(folder)], 60) == ""
    return {(one.entry.kind, one.entry.name): one for one in found}


def cases(table):
    """Return the cases of a table: kind, name and text."""
    return [
        pytest.param(kind, name, says, id=name)
        for kind, named in table.items()
        for name, (_, says) in named.items()
    ]


@pytest.mark.parametrize("kind", SOUND)
def test_a_correct_plugin_is_accepted(checked, kind):
    found = checked[kind, f"A correct {kind}"]
    assert found.broken == []
    assert found.advice == []


@pytest.mark.parametrize("key", CORRECT, ids=lambda key: key[1])
def test_an_unusual_correct_plugin_is_accepted(checked, key):
    found = checked[key]
    assert (found.broken, found.advice) == ([], [])
    assert (found.rate > 0) == (key[0] == "organism")


COMMAND = "def run():\n    'Not the run of gaitsim.'\n"


def test_a_command_with_the_name_of_a_built_in_one_is_rejected(install):
    install("odd", COMMAND, {"command": {"run": "run", "walkabout": "run"}})
    with select_plugins("odd") as found:
        run, walk = sorted(check_plugins(found), key=lambda one: one.entry.name)
    assert walk.broken == []
    assert "gaitsim itself has a command of this name" in run.broken[0]


@pytest.mark.parametrize(("kind", "name", "says"), cases(ERRORS))
def test_a_broken_plugin_is_rejected(checked, kind, name, says):
    assert any(says in text for text in checked[kind, name].broken), checked[kind, name]


@pytest.mark.parametrize(("kind", "name", "says"), cases(ADVICE))
def test_advice_is_given(checked, kind, name, says):
    found = checked[kind, name]
    assert found.broken == []
    assert any(says in text for text in found.advice), found
