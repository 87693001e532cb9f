"""The line of ancestors of an individual, and what changed at each step."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from gaitsim.plugin import (
    ARGUMENTS,
    BitSpace,
    GaitsimError,
    Genomes,
    RealSpace,
    ReprField,
    ReprMixin,
)
from gaitsim.plugin.pictures import number as short
from gaitsim.plugin.runs import (
    Choice,
    Evaluator,
    Experiment,
    Individual,
    Member,
    Numbered,
    Run,
    RunSnapshot,
    breed_again,
)
from gaitsim_lineage.genealogy import Floats, Genealogy, Integers, Rows, line_of

ENOUGH = 0.9  # share of a gain that makes a change enough for it
NEEDED = 0.5  # share of a gain whose loss makes a change needed
CHUNK = 10_000  # individuals that are evaluated together
MOST_CHANGES = 60  # changed genes of a step that are tried one by one, the largest first


@dataclass(frozen=True)
class GeneChange:
    """A gene that differs between an individual and its parent.

    Attributes:
        gene: index of the gene.
        name: label of the gene.
        before: its value in the parent.
        after: its value in the individual.
        inherited: whether the value is that of the other parent.
        alone: gain of the parent with this change alone; NaN if it was not tried.
        without: loss of the individual without this change; NaN if it was not tried.
    """

    gene: int
    name: str
    before: float
    after: float
    inherited: bool
    alone: float = np.nan
    without: float = np.nan

    @property
    def tried(self) -> bool:
        """Whether the change was tried alone, and left out."""
        return not np.isnan(self.alone)

    def __str__(self) -> str:
        return f"{self.name} {_short(self.before)} → {_short(self.after)}"


@dataclass(frozen=True, eq=False)
class Step:
    """An individual of a line, and what distinguishes it from its parent.

    Attributes:
        place: generation and number of the individual.
        scale: stage and first generation of the worlds; scores of others cannot be compared.
        genome: its genome, (genes,).
        score: its score, re-evaluated in the worlds of its generation.
        recorded: the score in the record of the run.
        gain: score minus that of its parent in the same worlds; NaN for the first individual.
        how: how it arose, such as 'mutation', 'crossover' or 'first generation'.
        other: the other parent; None without one.
        changes: genes that differ from the parent's, the largest change first.
        terms: differences of the terms of the score from those of the parent, by name.
        lost: parts of the parent's body that it lacks.
        added: parts of its body that the parent lacks.
    """

    place: Numbered
    scale: tuple[int, int]
    genome: Genomes
    score: float
    recorded: float
    gain: float
    how: str
    other: Numbered | None
    changes: tuple[GeneChange, ...]
    terms: Mapping[str, float]
    lost: tuple[str, ...] = ()
    added: tuple[str, ...] = ()

    @property
    def reproduced(self) -> bool:
        """Whether the score is the recorded one, to the bit; runs record none of centres."""
        return self.score == self.recorded or np.isnan(self.recorded)

    @property
    def what(self) -> str:
        """The changes in a line, the most important first; '' for the first individual."""
        if self.lost or self.added:
            parts = [*(f"+ {one}" for one in self.added), *(f"− {one}" for one in self.lost)]
            return ", ".join(parts)
        if not self.changes:
            return ""
        first = max(
            self.tried, key=lambda one: max(one.alone, one.without), default=self.changes[0]
        )
        more = len(self.changes) - 1
        return f"{first}" + (f" and {more} more" if more else "")

    @property
    def tried(self) -> list[GeneChange]:
        """The changes that were tried one by one."""
        return [one for one in self.changes if one.tried]

    @property
    def why(self) -> str:
        """The changes that were enough or needed for the gain; '' if none was tried."""
        tried, gain = self.tried, self.gain
        if not tried or not gain > 0:
            return ""
        best = max(tried, key=lambda one: one.alone)
        enough = [one.name for one in tried if one.alone >= ENOUGH * gain]
        needed = [one.name for one in tried if one.without >= NEEDED * gain]
        few = len(tried) < len(self.changes)
        text = f"of the {len(tried)} largest of {len(self.changes)} changes, " * few
        if enough:
            text += f"alone enough: {_listed(enough)}"
        elif best.alone > 0:
            text += f"none is enough alone; the most is {_percent(best.alone / gain)} of the gain"
            text += f" by {best.name}"
        else:
            text += "none raises the score alone"
        return text + (f"; needed: {_listed(needed)}" if needed else "")

    def to_dict(self) -> dict[str, Any]:
        """Return the step for JSON."""
        return {
            "generation": self.place.generation,
            "number": self.place.number,
            "score": self.score,
            "recorded": None if np.isnan(self.recorded) else self.recorded,
            "gain": None if np.isnan(self.gain) else self.gain,
            "how": self.how,
            "other": None
            if self.other is None
            else {"generation": self.other.generation, "number": self.other.number},
            "changes": [
                {
                    "gene": one.name,
                    "before": one.before,
                    "after": one.after,
                    "inherited": one.inherited,
                    "alone": one.alone if one.tried else None,
                    "without": one.without if one.tried else None,
                }
                for one in self.changes
            ],
            "terms": dict(self.terms),
            "lost": list(self.lost),
            "added": list(self.added),
        }


@dataclass(frozen=True, eq=False, repr=False)
class Lineage(ReprMixin):
    """The line of ancestors of an individual, from the first generation on.

    Attributes:
        run: the run.
        individual: the individual.
        steps: its ancestors and itself, the first one first.
        living: individuals that the search had at the end of the individual's generation, and
            their ancestors.
        alive: rows of those that it had.
        row: row of the individual in `living`.
        named: whether the search named the parents; otherwise, they are the nearest genomes of
            those from which each generation was bred.
    """

    run: RunSnapshot
    individual: Individual
    steps: tuple[Step, ...]
    living: Rows
    alive: Integers
    row: int
    named: bool

    @cached_property
    def rises(self) -> tuple[int, ...]:
        """Indices of the steps that scored higher than their parents, the largest gain first."""
        gains = [(-step.gain, index) for index, step in enumerate(self.steps) if step.gain > 0]
        return tuple(index for _, index in sorted(gains))

    @property
    def line(self) -> list[int]:
        """Rows of the individual and its ancestors in `living`."""
        return line_of(self.living, self.row)

    @property
    def records(self) -> tuple[int, ...]:
        """Indices of the first and the last step, and of those that scored higher than all before.

        If the fitness or the worlds change, a step is compared only with those after the change.
        """
        best, scale, found = -np.inf, None, []
        for index, step in enumerate(self.steps):
            if step.scale != scale:
                best, scale = -np.inf, step.scale
            if step.score > best or index in (0, len(self.steps) - 1):
                found.append(index)
            best = max(best, step.score)
        return tuple(found)

    def individual_of(self, index: int) -> Individual:
        """Return the individual of a step, with the terms of its score."""
        step = self.steps[index]
        generation = step.place.generation
        experiment = self.run.experiment_at(generation)
        found = Individual(
            experiment,
            step.score,
            {},
            generation,
            step.genome,
            self.run.path,
            member=step.place,
        )
        return replace(found, terms=found.evaluated_terms())

    def shown(self, most: int = 5) -> tuple[Individual, ...]:
        """Return the most important ancestors, in order of time, with notes on what changed.

        They are the first and the last one, and those with the largest rises among the records.
        """
        last = len(self.steps) - 1
        records = [at for at in self.records if 0 < at < last and self.steps[at].gain > 0]
        largest = sorted(records, key=lambda at: -self.steps[at].gain)[: most - 2]
        chosen = sorted({0, *largest, last})
        found = []
        for index in chosen:
            step = self.steps[index]
            note = f"{step.what}, {signed(step.gain)}" if np.isfinite(step.gain) else step.how
            found.append(replace(self.individual_of(index), note=note))
        return tuple(found)

    @property
    def coalescence(self) -> int | None:
        """The generation of the last common ancestor of all that the search had.

        None if there is none, or if the search names no parents.
        """
        shared = _common_ancestor(self.living, self.alive) if self.named else None
        return None if shared is None else int(self.living.generation[shared])

    def paragraph(self) -> str:
        """Return the history of the individual in a few plain sentences."""
        first, last, individual = self.steps[0], self.steps[-1], self.individual
        unit = f" {individual.experiment.fitness.unit}".rstrip()
        where = str(last.place) if individual.member is None else individual.label
        text = f"{_capital(where)} {_scored(individual.score, unit, 'scores')}"
        if individual.member is None or individual.member == last.place:
            text += ". "
        else:
            text += f"; it is {last.place}. "
        if len(self.steps) == 1:
            return text + "It has no parent."
        text += (
            f"Its line begins with {first.place}, which {_scored(first.score, unit, 'scored')}, "
            f"and has {len(self.steps) - 1:,} step{'s' * (len(self.steps) != 2)}, of which "
            f"{len(self.rises):,} raised the score."
        )
        if first.scale != last.scale:
            text += " The fitness or the worlds changed, so not all scores can be compared."
        if few := self.rises[:3]:
            named = "; ".join(
                f"generation {self.steps[one].place.generation}, {self.steps[one].what} "
                f"({signed(self.steps[one].gain)}{unit})"
                for one in sorted(few)
            )
            text += f" The largest rise{'s' * (len(few) > 1)}: {named}."
        if not self.steps[0].place.number:
            text += (
                " The search draws each generation around a centre, which moves: the ancestors are "
                "the centres."
            )
        elif (since := self.coalescence) is not None:
            text += f" All individuals of its time descend from one of generation {since}."
        if not self.named:
            text += (
                " The search names no parents: each parent is the nearest of the genomes from "
                "which the generation was drawn."
            )
        return text

    def to_dicts(self) -> list[dict[str, Any]]:
        """Return a dictionary for each step, such as for `pandas.DataFrame`."""
        return [step.to_dict() for step in self.steps]

    def to_dict(self) -> dict[str, Any]:
        """Return the line for JSON."""
        return {
            "run": str(self.run.path),
            "individual": self.individual.label,
            "text": self.paragraph(),
            "named": self.named,
            "common_ancestor": self.coalescence,
            "steps": self.to_dicts(),
        }

    def to_networkx(self) -> Any:
        """Return the tree of the living and their ancestors as a `networkx.DiGraph`.

        Nodes are pairs of generation and number, with their `score`; edges lead from parents to
        children.

        Raises:
            GaitsimError: networkx is not installed.
        """
        try:
            import networkx  # type: ignore[import-untyped]
        except ImportError:
            raise GaitsimError("networkx is not installed", remedy="pip install networkx") from None
        graph, rows = networkx.DiGraph(), self.living
        places = [*zip(rows.generation.tolist(), rows.number.tolist(), strict=True)]
        for place, score in zip(places, rows.scores.tolist(), strict=True):
            graph.add_node(place, score=score)
        for child, parent in enumerate(rows.parent.tolist()):
            if parent >= 0:
                graph.add_edge(places[parent], places[child])
        return graph

    def _repr_fields(self) -> Mapping[str, ReprField]:
        return {
            "individual": str(self.steps[-1].place),
            "steps": len(self.steps),
            "rises": len(self.rises),
            "score": self.steps[-1].score,
            "named": self.named,
        }


def lineage(
    run: RunSnapshot | Run | str | Path,
    which: Choice = None,
    *,
    explain: int = 5,
    workers: int | None = None,
    begin: Callable[[int], object] = lambda total: None,
    advance: Callable[[int], object] = lambda done: None,
) -> Lineage:
    """Return the line of ancestors of an individual of a run.

    The search is repeated with the recorded scores, without moving bodies; then the individuals of
    the line are re-evaluated.

    Args:
        run: a run, or its folder or name.
        which: the best of a generation by its number, a member of a front or archive, an
            individual by generation and number; None for the champion.
        explain: number of the largest rises whose changes are tried one by one.
        workers: number of parallel workers.
        begin: called with the number of generations.
        advance: called with the number of generations since the last call.

    Raises:
        GaitsimError: the individual does not exist, or the record is damaged.
    """
    if isinstance(run, Run):
        run = run.path
    snapshot = run if isinstance(run, RunSnapshot) else RunSnapshot.find(str(run))
    if not isinstance(which, int | Member | Numbered | Mapping | None):
        raise GaitsimError(
            f"invalid individual: {which!r:.80}",
            where=ARGUMENTS,
            allowed="a generation, gs.Member(3), gs.Numbered(12, 34), or None for the champion",
        )
    individual = snapshot.individual(which)
    until = individual.generation
    begin(until)
    genealogy = Genealogy(snapshot.experiment_at(until).space())
    named, best = True, 0
    for bred in breed_again(snapshot, until, advance):
        genealogy.add(bred)
        known = bred.parents is not None or bred.centre is not None
        named = named and (known or bred.generation.number == 1)
        best = bred.generation.best
    genealogy.prune()
    row = _row(genealogy, individual, best)
    if row is None:
        raise GaitsimError(
            f"{individual.label} is not among the genomes that the search had",
            where=str(snapshot.path),
            remedy="'gaitsim verify' finds files that were changed",
        )
    rows = genealogy.rows
    steps = _steps(snapshot, rows.take(np.array(line_of(rows, row))), workers)
    found = Lineage(snapshot, individual, steps, rows, np.unique(genealogy.living), row, named)
    return _with_reasons(found, explain, workers)


def _row(genealogy: Genealogy, individual: Individual, best: int) -> int | None:
    """Return the row of an individual, given the index of the best of the last generation."""
    match individual.member:
        case Numbered(number=0):
            return genealogy.centre
        case Numbered(number=number):
            return int(genealogy.latest[number - 1])
        case None:
            return int(genealogy.latest[best])
    assert individual.genome is not None, "individuals of runs have genomes"
    return genealogy.row_of(individual.genome)


def _steps(run: RunSnapshot, line: Rows, workers: int | None) -> tuple[Step, ...]:
    """Return the steps of a line, each re-evaluated beside its parent in the same worlds."""
    scales = [_scale(run, generation) for generation in line.generation.tolist()]
    scored: dict[tuple[tuple[int, int], int], tuple[float, dict[str, float]]] = {}
    for scale, group in groupby(range(len(line)), scales.__getitem__):
        members = [*group]
        members = [max(members[0] - 1, 0), *members]  # the first parent is of other worlds
        found = _evaluate(run, int(line.generation[members[-1]]), line.genomes[members], workers)
        scored |= {(scale, at): one for at, one in zip(members, found, strict=True)}
    steps = []
    for at, scale in enumerate(scales):
        (score, terms), (before, then) = scored[scale, at], scored[scale, max(at - 1, 0)]
        experiment = run.experiment_at(int(line.generation[at]))
        pair = line.genomes[max(at - 1, 0)], line.genomes[at]
        changes = _changes(experiment, *pair, line.inherited[at])
        lost, added = _parts(experiment, *pair)
        other = Numbered(*line.other[at].tolist()) if line.other[at, 0] else None
        if not at:
            how = _founder(run, pair[1])
        elif not line.number[at - 1]:
            how = "sample" if line.number[at] else "centre moved"
        else:
            how = _how(changes, other, line.genomes.shape[1], named=bool(line.named[at]))
        steps.append(
            Step(
                Numbered(int(line.generation[at]), int(line.number[at])),
                scale,
                line.genomes[at],
                score,
                float(line.scores[at]),
                score - before if at and np.isfinite(before) else np.nan,
                how,
                other,
                changes,
                {name: value - then[name] for name, value in terms.items()} if at else {},
                lost,
                added,
            )
        )
    return tuple(steps)


def _scale(run: RunSnapshot, generation: int) -> tuple[int, int]:
    """Return the stage of a generation, and the first generation in its worlds."""
    stage = run.stage_at(generation)
    return stage.number, stage.outline.worlds.first_of_draw(generation)


def _evaluate(
    run: RunSnapshot, generation: int, genomes: Genomes, workers: int | None
) -> list[tuple[float, dict[str, float]]]:
    """Return score and terms of genomes in the worlds of a generation."""
    found = []
    with Evaluator(run.experiment_at(generation), workers) as evaluator:
        for first in range(0, len(genomes), CHUNK):
            part = evaluator.evaluate(genomes[first : first + CHUNK], generation)
            found += [(float(one), part.terms_of(at)) for at, one in enumerate(part.scores)]
    return found


def _changes(
    experiment: Experiment, before: Genomes, after: Genomes, inherited: Floats
) -> tuple[GeneChange, ...]:
    """Return the genes that differ, those that changed most first."""
    space = experiment.space()
    genes = np.flatnonzero(before != after)
    size = np.ones(len(genes))
    if isinstance(space, RealSpace):
        size = np.abs(after - before)[genes] / space.width[genes]
        if space.periodic is not None:
            size = np.where(space.periodic[genes], np.minimum(size, 1 - size), size)
    genes = genes[np.argsort(-size, kind="stable")]
    return tuple(
        GeneChange(
            int(gene),
            space.labels[gene],
            float(before[gene]),
            float(after[gene]),
            bool(inherited[gene]),
        )
        for gene in genes
    )


def _parts(
    experiment: Experiment, before: Genomes, after: Genomes
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the parts of a body that were lost and added, as its design names them."""
    if isinstance(experiment.space(), RealSpace | BitSpace):
        return (), ()
    designs = []
    for genome in (before, after):
        body, _ = experiment.organism.embody(genome.copy())
        designs.append([part.strip() for part in body.design().split(",") if part.strip()])
    then, now = designs
    return tuple(one for one in then if one not in now), tuple(
        one for one in now if one not in then
    )


def _founder(run: RunSnapshot, genome: Genomes) -> str:
    """Return what the first individual of a line is."""
    if run.start is not None and (run.start.genomes == genome).all(axis=1).any():
        return f"start, of generation {run.start.generation} of another run"
    starts = run.experiment_at(1).starts()
    name = next((name for name, one in starts.items() if np.array_equal(one, genome)), "")
    return f"start point '{name}'" if name else "founder"


def _how(
    changes: tuple[GeneChange, ...], other: Numbered | None, genes: int, *, named: bool
) -> str:
    """Return how an individual arose, as far as its genes show it."""
    if not named:
        return "nearest sample"
    inherited = sum(one.inherited for one in changes)
    if other is None or (not inherited and 2 * len(changes) < genes):
        return "mutation"
    if inherited == len(changes):
        return "crossover"
    return "crossover and mutation" if inherited else "recombination"


def _with_reasons(found: Lineage, explain: int, workers: int | None) -> Lineage:
    """Return the line with the changes of its largest rises tried one by one."""
    steps = [*found.steps]
    for index in found.rises[: max(explain, 0)]:
        step, parent = steps[index], steps[index - 1]
        generation = step.place.generation
        experiment = found.run.experiment_at(generation)
        tried = step.changes[:MOST_CHANGES]
        if len(step.changes) < 2 or not isinstance(experiment.space(), RealSpace | BitSpace):
            continue
        genes = np.array([one.gene for one in tried])
        rows = np.arange(len(tried))
        alone = np.repeat(parent.genome[None], len(tried), axis=0)
        alone[rows, genes] = step.genome[genes]
        without = np.repeat(step.genome[None], len(tried), axis=0)
        without[rows, genes] = parent.genome[genes]
        genomes = experiment.space().repair(np.concatenate([alone, without]))
        scores = np.array([one for one, _ in _evaluate(found.run, generation, genomes, workers)])
        before = step.score - step.gain
        gains, losses = np.split(np.where(np.isfinite(scores), scores, -np.inf), 2)
        changes = tuple(
            replace(one, alone=float(gain - before), without=float(step.score - rest))
            for one, gain, rest in zip(tried, gains, losses, strict=True)
        )
        steps[index] = replace(step, changes=changes + step.changes[MOST_CHANGES:])
    return replace(found, steps=tuple(steps))


def _common_ancestor(rows: Rows, alive: Integers) -> int | None:
    """Return the last row from which all that are alive descend, or that is alive itself."""
    children = np.bincount(rows.parent[rows.parent >= 0], minlength=len(rows))
    roots = np.flatnonzero(rows.parent < 0)
    if len(roots) != 1:
        return None
    at, living = int(roots[0]), {*alive.tolist()}
    following = {parent: row for row, parent in enumerate(rows.parent.tolist())}
    while children[at] == 1 and at not in living:
        at = following[at]
    return at


def signed(value: float) -> str:
    """Return a gain with its sign; '' if it is not finite."""
    return f"{value:+.3g}".replace("-", "−") if np.isfinite(value) else ""


def _short(value: float) -> str:
    return f"{value:.3g}".replace("-", "−")


def _scored(score: float, unit: str, verb: str) -> str:
    failed = "fails" if verb == "scores" else "failed"
    return f"{verb} {short(score)}{unit}" if np.isfinite(score) else failed


def _listed(names: Sequence[str], most: int = 3) -> str:
    return ", ".join(names[:most]) + " …" * (len(names) > most)


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %"


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
