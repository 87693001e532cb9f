"""Each rule reports its kind of error, and correct plugins pass."""

import sys
from types import SimpleNamespace

import pytest
from gaitsim.testing.examine import digest_results, examine

from gaitsim.registry import find
from gaitsim.testing.rules import bodies

NAMES = {
    "organism": "Body",
    "fitness": "Distance",
    "search": "Fresh",
    "selection": "First",
    "crossover": "Solo",
    "mutation": "Still",
}
HEAD = '''
import random, threading
from gaitsim.contracts import Channel, Measure, Members, Solid
from pydantic import PrivateAttr
calls = []
class X({base}):
    """A plugin."""
'''


@pytest.fixture
def examined(install, working):
    """Examines a plugin that is a working one but for what is given."""

    def run(kind, body="pass", base=None, options=None):
        lines = "\n    ".join(body.strip("\n").splitlines())
        source = f"{working}{HEAD.format(base=base or NAMES[kind])}    {lines}\n"
        points = {key: {"sound": target} for key, target in NAMES.items()}
        points[kind] = points[kind] | {"x": "X"}
        install("fake", source, points)
        return examine(find(kind, "x"), options or {})

    return run


def cases(table):
    """Return the cases of a table: kind -> name -> body, rule and actual value."""
    return [
        pytest.param(kind, *case, id=name)
        for kind, named in table.items()
        for name, case in named.items()
    ]


@pytest.mark.parametrize("kind", NAMES)
def test_a_correct_plugin_passes(examined, kind):
    report = examined(kind)
    assert report.ok
    assert {finding.rule for finding in report.advice} <= {"selection"}  # it takes the first two
    assert len(report.digest) == 64
    assert "passes" in str(report)


def test_a_body_with_bits_passes(examined):
    assert examined("organism", base="BitBody").findings == ()


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

ERRORS = {
    "organism": {
        "conditions without the option": (WINDS, "worlds", "none"),
        "a check of an unknown condition": (
            "def checks(self):\n    return ({'fog': 1.0},)",
            "worlds",
            "unknown condition 'fog'",
        ),
        "a nominal world that is another": (
            WINDS + "world: dict[str, float] = option({}, 'a world')\n"
            "def move(self, genomes):\n"
            "    return Motion(1.0, {'distance': genomes[:, 0] + len(self.world)})",
            "worlds",
            "a different motion",
        ),
        "genes that go with a leg": (
            LEGS + "def genome_space(self):\n"
            "    n = 2 - len(self.damage)\n"
            "    return RealSpace(-np.ones(n), np.ones(n), ('a', 'b')[:n])",
            "damage",
            "a different space",
        ),
        "a channel that goes with a leg": (
            LEGS + "def move(self, genomes):\n"
            "    shape = (len(genomes), 2 - len(self.damage))\n"
            "    return Motion(1.0, {'distance': genomes[:, 0], 'feet': np.zeros(shape)})",
            "damage",
            "shape (6, 1)",
        ),
        "labels twice": (
            "def genome_space(self):\n    return RealSpace(-np.ones(2), np.ones(2), ('a', 'a'))",
            "genome space",
            "2 genes, 1 labels",
        ),
        "a start point outside the space": (
            "def starts(self):\n    return {'hop': np.full(2, 9.0)}",
            "starts",
            "an invalid genome as the start point 'hop'",
        ),
        "a start point with a reserved name": (
            "def starts(self):\n    return {'random': np.zeros(2)}",
            "starts",
            "names a start point 'random'",
        ),
        "no genes": ("def genome_space(self):\n    return BitSpace(())", "genome space", "0 genes"),
        "a repair that goes on": (
            "def genome_space(self):\n    return BitSpace(('a', 'b'), lambda g: 1 - g)",
            "genome space",
            "",
        ),
        "no motion": ("def move(self, genomes):\n    return {}", "motion", "a dict"),
        "no frame rate": (
            "def move(self, genomes):\n    return Motion(0, {'distance': genomes[:, 0]})",
            "motion",
            "0",
        ),
        "a channel missing": (
            "channels: ClassVar = {**Body.channels, 'height': Channel((), 'm', '')}",
            "channels",
            "height missing",
        ),
        "a list": (MOVES % "list(genomes[:, 0])", "channels", "a list"),
        "complex": (MOVES % "genomes[:, 0] + 0j", "channels", "complex128"),
        "time first": (MOVES % "genomes.T", "shapes", "(3, 6)"),
        "another axis than declared": (MOVES % "genomes", "shapes", "(6, 3)"),
        "another length than declared": (
            "channels: ClassVar = {'distance': Channel((('x', 'y'),), 'm', '')}\n"
            + MOVES % "genomes",
            "shapes",
            "(6, 3)",
        ),
        "two lengths of one axis": (
            "channels: ClassVar = dict.fromkeys(\n"
            "    ['distance', 'rise'], Channel(('frames',), 'm', ''))\n"
            "def move(self, genomes):\n"
            "    return Motion(1.0, {'distance': genomes, 'rise': genomes[:, 1:]})",
            "shapes",
            "2",
        ),
        "NaN": (
            MOVES % "np.log(np.abs(genomes[:, 0]) - 2)",
            "finite values",
            "1 non-finite values",
        ),
        "all failed": (
            "def move(self, genomes):\n    return Motion(1.0, {'distance': genomes[:, 0]}, None,"
            " {i: 'fell' for i in range(len(genomes))})",
            "failures",
            "fell",
        ),
        "joints without names": (
            "channels: ClassVar = {'joint_angles': Channel(('frames', 'joints'), 'rad', '')}\n"
            "def move(self, genomes):\n"
            "    return Motion(1.0, {'joint_angles': genomes[:, None], 'distance': genomes[:, 0]})",
            "shapes",
            "3",
        ),
        "changed genomes": (
            "def move(self, genomes):\n    genomes += 1\n    return super().move(genomes - 1)",
            "inputs",
            "move() changes them",
        ),
        "memory": (
            "def move(self, genomes):\n    calls.append(1)\n"
            "    return Motion(1.0, {'distance': genomes[:, 0] + len(calls)})",
            "determinism",
            "distance differs",
        ),
        "the population's mean": (
            MOVES % "genomes[:, 0] - genomes.mean()",
            "chunks",
            "distance differs when individuals move",
        ),
        "the neighbour": (MOVES % "np.roll(genomes[:, 0], 1)", "chunks", "in reverse order"),
        "other threads": (
            "threads: ClassVar = True\n"
            + MOVES % "genomes[:, 0] + (threading.current_thread() is not threading.main_thread())",
            "threads",
            "distance differs",
        ),
        "played angles that are changed": (
            JOINTS + "    joint_angles *= 0\n    return self.move(joint_angles[:, 0])",
            "play",
            "play() changes them",
        ),
        "nothing played": (JOINTS + "    return None", "play", "a NoneType"),
        "a drawing of nothing": (
            "def skeleton(self, motion, individual):\n"
            "    return Skeleton(np.zeros((0, 1, 2, 3)), ('point',), 1.0)",
            "skeleton",
            "0 frames",
        ),
        "a drawing that does not fit": (
            "def skeleton(self, motion, individual):\n"
            "    return Skeleton(np.zeros((1, 2, 2, 3)), ('point',), 1.0)",
            "skeleton",
            "Skeleton.segments has shape (1, 2, 2, 3)",
        ),
        "a solid that is not turned": (
            "def skeleton(self, motion, individual):\n"
            "    solids = (Solid('ball', 'sphere', (0.1,)),)\n"
            "    return Skeleton(np.zeros((1, 1, 2, 3)), ('point',), 1.0,\n"
            "                    solids=solids, poses=np.zeros((1, 1, 7)))",
            "skeleton",
            "a quaternion of length 0",
        ),
        "a solid of no shape": (
            "def skeleton(self, motion, individual):\n    return Solid('ball', 'torus', (0.1,))",
            "skeleton",
            "expected one of box, sphere",
        ),
        "no drawing": (
            "def skeleton(self, motion, individual):\n    return None",
            "skeleton",
            "a NoneType",
        ),
        "a rig that is not a tree": (
            RIG % ("(Link('trunk', 'trunk'),)", "('point',)", 0.0),
            "rig",
            "the parent 'trunk'",
        ),
        "a rig of other segments": (RIG % ("(Link('trunk'),)", "('line',)", 0.0), "rig", "line"),
        "a rig of longer segments": (RIG % ("(Link('trunk'),)", "('point',)", 1.0), "rig", "1 m"),
        "no rig": ("def rig(self):\n    return ()", "rig", "a tuple"),
        "one measure for all": (
            "def measures(self, motion):\n"
            "    return {'far': Measure(motion['distance'].mean(), 'm', 'how far')}",
            "measures",
            "shape ()",
        ),
        "global randomness": (
            "def genome_space(self):\n    random.random()\n    return super().genome_space()",
            "randomness",
            "",
        ),
        "an exception": (MOVES % "1 / 0", "failure", "ZeroDivisionError"),
        "an exit": (MOVES % "exit(0)", "failure", "SystemExit"),
        "no default": ("legs: int = option(..., 'legs', ge=1)", "options", "legs has none"),
        "no help": ("legs: int = option(4, '', ge=1)", "options", "legs has none"),
        "a default out of bounds": ("legs: int = option(4, 'legs', ge=6)", "options", "legs = 4"),
        "an option that no file holds": (
            "sizes: dict = option({1: 2}, 'sizes by number')",
            "options",
            "",
        ),
    },
    "fitness": {
        "no terms": (TERMS % "{}", "terms", "{}"),
        "one term for all": (TERMS % "{'d': motion['distance'].mean()}", "shapes", "shape ()"),
        "a channel that is not told": (
            "needs: ClassVar = ()\n" + TERMS % "{'d': motion['distance']}",
            "needs",
            "reads distance",
        ),
        "a rank": (
            TERMS % "{'d': motion['distance'] - motion['distance'].max()}",
            "chunks",
            "chunk of 1",
        ),
        "a changed motion": (
            "def terms(self, motion):\n    d = motion['distance']\n    d *= 2\n    return {'d': d}",
            "inputs",
            "channel distance",
        ),
        "a fitness with memory": (
            "def terms(self, motion):\n    calls.append(1)\n"
            "    return {'d': motion['distance'] + len(calls)}",
            "determinism",
            "d differs",
        ),
        "other terms each time": (
            TERMS % "{str(len(motion['distance'])): motion['distance']}",
            "chunks",
            "",
        ),
    },
    "search": {
        "a state of lists": (
            TELL % "return {'best': told['best'].tolist()}",
            "state",
            "best: a list",
        ),
        "a state of small floats": (
            TELL % "return {'best': told['best'].astype('f4')}",
            "state",
            "best: float32",
        ),
        "a state that gets more": (
            TELL % "return {**told, 'score': np.array(1.0)}",
            "state",
            "score: changed after tell()",
        ),
        "a state that is changed": (
            TELL % "state['best'][...] = 0; return told",
            "inputs",
            "tell() changes them",
        ),
        "sorted scores of a generation": (
            TELL % "results.scores.sort(); return told",
            "inputs",
            "tell() changes them",
        ),
        "too few genomes": (ASK % "return context.random(3), state", "shapes", "(3, 5)"),
        "genomes alone": (ASK % "return context.random(12)", "ask", "a ndarray"),
        "genomes that are not repaired": (
            ASK % "return context.random(context.population) + context.space.dtype.type(2), state",
            "bounds",
            "invalid genomes",
        ),
        "genomes lost where all fail": (
            TELL % "return {'best': np.mean(results.genomes, 0, where=np.isfinite(results.scores)"
            "[:, None], keepdims=True).astype(results.genomes.dtype)}",
            "bounds",
            "invalid genomes",
        ),
        "genomes by chance": (
            ASK % "return context.space.random(context.population, np.random.default_rng()), state",
            "determinism",
            "different bits",
        ),
        "a search with a memory of its own": (
            "_told: set = PrivateAttr(default_factory=set)\n"
            + TELL % "self._told.add(context.generation); return told\n"
            + ASK
            % "return np.roll(super().ask(state, last, context)[0], len(self._told), 0), state",
            "resume",
            "genomes: different after generation 1",
        ),
        "a refused state of its own": (
            "def mismatch(self, state, context):\n    return 'too old'",
            "mismatch",
            "too old",
        ),
        "an objection of nothing": (
            "def objection(self, space, population):\n    return None",
            "objection",
            "None",
        ),
        "a name that is read": ("def reads(self):\n    return 'far'", "reads", "'far'"),
        "figures that come and go": (
            FIGURES % "{'best': 1.0} if state['best'].sum() > 0 else {}",
            "figures",
            "",
        ),
        "a figure that is none": (FIGURES % "{'size': np.nan}", "figures", "size: nan"),
        "members that are not kept": ('keeps: ClassVar = "front"', "members", "a NoneType"),
        "members outside the space": (MEMBERS % "best + np.uint8(9)", "members", "invalid genomes"),
        "half of a member": (MEMBERS % "best[:, :1]", "members", "invalid genomes"),
        "an archive without cells": (
            (MEMBERS % "best").replace("front", "archive"),
            "members",
            "None",
        ),
        "memories outside the space": (
            "def remembered(self, state):\n    return state['best'] + np.uint8(9)",
            "remembered",
            "invalid genomes",
        ),
        "several populations with a state": (
            "several: ClassVar = True\n"
            + ASK
            % "shape = (*context.populations, context.population, context.space.genes)\n"
            "    return context.random(int(np.prod(shape[:-1]))).reshape(shape), state",
            "several",
            "best",
        ),
    },
    "selection": {
        "parents out of range": (PARENTS % f"return {PAIRS} + 50", "bounds", "50 to 50"),
        "parents as floats": (PARENTS % "return np.zeros((pairs, 2))", "dtypes", "float64"),
        "single parents": (PARENTS % "return np.zeros(pairs, np.intp)", "shapes", "shape (1,)"),
        "parents by chance": (
            PARENTS % "return np.random.default_rng().integers(0, len(scores), (pairs, 2))",
            "determinism",
            "different",
        ),
        "sorted scores": (PARENTS % f"scores.sort(); return {PAIRS}", "inputs", "changes them"),
        "others for several populations": (
            "def parents_each(self, scores, pairs, rng):\n"
            "    return np.ones((len(scores), pairs, 2), np.intp)",
            "parents_each",
            "a different choice",
        ),
        "no objection": (
            "def objection(self, population, elites, children):\n    return None",
            "objection",
            "None",
        ),
    },
    "crossover": {
        "too few children": (CROSS % "return mothers[:1].copy()", "shapes", "(1, 5)"),
        "the mothers themselves": (CROSS % "return mothers", "inputs", "memory shared"),
        "genes that are not numbers": (CROSS % "return mothers * np.nan", "finite values", ""),
        "children by chance": (
            CROSS % "return mothers if random.random() < 0 else mothers + random.random()",
            "determinism",
            "",
        ),
    },
    "mutation": {
        "integers": (MUTATE % "return genomes.astype(int)", "dtypes", "int64"),
        "changed parents": (
            MUTATE % "genomes *= 2; return genomes.copy()",
            "inputs",
            "changes them",
        ),
        "genes that are not bits": (
            MUTATE % "return genomes + genomes.dtype.type(3)",
            "bounds",
            "",
        ),
        "a schedule of nothing": (
            "def at(self, generation):\n    return None",
            "schedule",
            "NoneType",
        ),
    },
}


@pytest.mark.parametrize(("kind", "body", "rule", "actual"), cases(ERRORS))
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_each_violation_is_found(examined, kind, body, rule, actual):
    report = examined(kind, body)
    assert not report.ok
    found = [finding for finding in report.errors if finding.rule == rule]
    assert found, report
    assert actual in found[0].actual
    assert all(finding.expected for finding in report.findings)
    assert "fails" in str(report)


ADVICE = {
    "organism": {
        "a number without bounds": ("legs: int = option(4, 'legs')", "options", "legs"),
        "a channel that is not told": (
            "def move(self, genomes):\n"
            "    return Motion(1.0, {'distance': genomes[:, 0], 'height': genomes[:, 1]})",
            "channels",
            "height not declared",
        ),
    },
    "fitness": {
        "a channel that is not read": (
            TERMS % "{'d': np.zeros(motion.population)}",
            "needs",
            "never reads distance",
        ),
        "channels of no body": ("needs: ClassVar = ('wheels',)", "needs", "no such body"),
        "never finite": (
            TERMS % "{'d': motion['distance'] * np.nan}",
            "finite values",
            "no finite score",
        ),
    },
    "search": {
        "a search that refuses its spaces": (
            "def objection(self, space, population):\n    return 'too large' * (space.genes == 7)",
            "objection",
            "bits: too large",
        )
    },
    "selection": {
        "the worst": (
            PARENTS % "return np.full((pairs, 2), np.argmin(scores), np.intp)",
            "selection",
            "",
        )
    },
}


@pytest.mark.parametrize(("kind", "body", "rule", "actual"), cases(ADVICE))
def test_advice_is_given(examined, kind, body, rule, actual):
    report = examined(kind, body)
    assert report.ok, report
    found = [finding for finding in report.advice if finding.rule == rule]
    assert found, report
    assert actual in found[0].actual


def test_a_missing_docstring_is_found(install, working):
    install("fake", working + "\nclass X(Still):\n    pass\n", {"mutation": {"x": "X"}})
    report = examine(find("mutation", "x"), {})
    assert report.ok
    assert [finding.rule for finding in report.findings] == ["docstring"]


def test_an_import_error_says_where(install):
    install("fake", "x = 1\nimport no_such_thing\n", {"organism": {"x": "X"}})
    (finding,) = examine(find("organism", "x"), {}).findings
    assert "No module named 'no_such_thing'" in finding.actual
    assert "fake.py, line 2" in finding.actual


def test_options_reach_the_plugin(examined):
    report = examined(
        "organism",
        "legs: int = option(4, 'legs', ge=1)\n"
        + MOVES % "np.full(len(genomes), np.nan if self.legs == 5 else self.legs)",
        options={"legs": 5},
    )
    (finding,) = report.findings
    assert finding.rule == "finite values"
    entry = find("organism", "x")
    assert digest_results(entry, {"legs": 4}) != digest_results(entry, {"legs": 6})
    assert digest_results(entry, {"legs": 4}) == digest_results(entry, {})


@pytest.mark.parametrize(
    ("first", "more", "slow", "rate"),
    [
        (0.6, 0.001, False, 100 / 0.699),  # whole arrays: the rate is that of a population
        (90.0, 0.0, False, 100 / 90),
        (0.001, 0.001, False, 1000),
        (0.1, 0.1, False, 10),
        (0.6, 0.6, True, 1 / 0.6),
    ],
)
def test_only_a_body_with_slow_further_individuals_is_slow(
    examined, monkeypatch, first, more, slow, rate
):
    def clock():
        moved = sys.modules["fake"].calls
        return sum(first + (individuals - 1) * more for individuals in moved)

    monkeypatch.setattr(bodies, "time", SimpleNamespace(perf_counter=clock))
    report = examined(
        "organism",
        "def move(self, genomes):\n    calls.append(len(genomes))\n"
        "    return super().move(genomes)",
        base="Body",
    )
    assert report.ok
    assert ("speed" in {finding.rule for finding in report.advice}) == slow
    assert report.figures["individuals_per_second"] == pytest.approx(rate)
