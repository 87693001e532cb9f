"""The line of ancestors of an individual, and what changed at each step."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from gaitsim.plugin import BitSpace, GaitsimError, Genomes, RealSpace, ReprField, ReprMixin
from gaitsim.plugin.pictures import number as short
from gaitsim.plugin.runs import (
    Choice,
    Evaluator,
    Experiment,
    Individual,
    Numbered,
    Run,
    RunSnapshot,
    breed_again,
)
from gaitsim_lineage.genealogy import Floats, Genealogy, Rows, line_of

ENOUGH = 0.9  # share of a gain that makes a change enough for it
NEEDED = 0.5  # share of a gain whose loss makes a change needed
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
        genome: its genome, (genes,).
        score: its score, evaluated again in the worlds of its generation.
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
        """Whether the score is the recorded one, to the bit."""
        return self.score == self.recorded

    @property
    def what(self) -> str:
        """What changed, the most important first, in a line."""
        if self.lost or self.added:
            parts = [*(f"+ {one}" for one in self.added), *(f"− {one}" for one in self.lost)]
            return ", ".join(parts)
        if not self.changes:
            return self.how
        tried = [one for one in self.changes if one.tried]
        first = max(tried, key=lambda one: max(one.alone, one.without), default=self.changes[0])
        more = len(self.changes) - 1
        return f"{first}" + (f" and {more} more" if more else "")

    @property
    def why(self) -> str:
        """Which changes were enough or needed for the gain; '' if they were not tried."""
        tried = [one for one in self.changes if one.tried]
        if not tried or not self.gain > 0:
            return ""
        shares = {one.name: one.alone / self.gain for one in tried}
        enough = [name for name, share in shares.items() if share >= ENOUGH]
        needed = [one.name for one in tried if one.without >= NEEDED * self.gain]
        text = (
            f"alone enough: {', '.join(enough[:3])}" + " …" * (len(enough) > 3)
            if enough
            else f"none is enough alone; the most is {_percent(max(shares.values()))} of the gain "
            f"by {max(shares, key=lambda name: shares[name])}"
        )
        if needed:
            text += f"; needed: {', '.join(needed[:3])}" + " …" * (len(needed) > 3)
        return text

    def to_dict(self) -> dict[str, Any]:
        """Return the step for JSON."""
        return {
            "generation": self.place.generation,
            "number": self.place.number,
            "score": self.score,
            "recorded": self.recorded,
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
        row: row of the individual in `living`.
        named: whether the search named the parents; otherwise, they are the nearest genomes of
            those from which each generation was bred.
    """

    run: RunSnapshot
    individual: Individual
    steps: tuple[Step, ...]
    living: Rows
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
        """Indices of the first step and of those that scored higher than all before."""
        best, found = -np.inf, []
        for index, step in enumerate(self.steps):
            if step.score > best or index == 0:
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
            step.recorded,
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
        records = [index for index in self.records[1:-1] if self.steps[index].gain > 0]
        largest = sorted(records, key=lambda index: -self.steps[index].gain)[: most - 2]
        chosen = sorted({0, *largest, len(self.steps) - 1})
        found = []
        for index in chosen:
            step = self.steps[index]
            gain = f", {step.gain:+.3g}" if step.gain == step.gain else ""
            found.append(replace(self.individual_of(index), note=f"{step.what}{gain}"))
        return tuple(found)

    @property
    def coalescence(self) -> int | None:
        """The generation of the last common ancestor of all living; None if there is none."""
        shared = _common_ancestor(self.living)
        return None if shared is None else int(self.living.generation[shared])

    def paragraph(self) -> str:
        """Return the history of the individual in a few plain sentences."""
        first, last = self.steps[0], self.steps[-1]
        unit = self.individual.experiment.fitness.unit
        unit = f" {unit}" if unit else ""
        text = (
            f"{_capital(str(last.place))} scores {short(last.score)}{unit}. Its line begins with "
            f"{first.place}, which scored {short(first.score)}{unit}, and has "
            f"{len(self.steps) - 1:,} step{'s' * (len(self.steps) != 2)}"
        )
        rises = self.rises
        text += f", of which {len(rises):,} raised the score." if rises else "."
        if rises and np.isfinite(first.score) and last.score > first.score:
            total = sum(self.steps[one].gain for one in rises)
            few = rises[: min(3, len(rises))]
            share = sum(self.steps[one].gain for one in few) / total
            named = "; ".join(
                f"generation {self.steps[one].place.generation}, {self.steps[one].what} "
                f"({self.steps[one].gain:+.3g}{unit})"
                for one in sorted(few)
            )
            count = "The largest rise" if len(few) == 1 else f"The {len(few)} largest rises"
            text += f" {count} brought {_percent(share)} of all gains: {named}."
        since = self.coalescence
        if since is not None and len(self.steps) > 1:
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
    leaps: int = 5,
    workers: int | None = None,
    begin: Callable[[int], object] = lambda total: None,
    advance: Callable[[int], object] = lambda done: None,
) -> Lineage:
    """Return the line of ancestors of an individual of a run.

    The search is repeated with the recorded scores, without moving bodies; then the individuals of
    the line are evaluated again.

    Args:
        run: a run, or its folder or name.
        which: the best of a generation by its number, a member of a front or archive, an
            individual by generation and number; None for the champion.
        leaps: number of the largest rises whose changes are tried one by one.
        workers: number of parallel workers.
        begin: called with the number of generations.
        advance: called with the number of generations since the last call.

    Raises:
        GaitsimError: the individual does not exist, or the record is damaged.
    """
    if isinstance(run, Run):
        run = run.path
    snapshot = run if isinstance(run, RunSnapshot) else RunSnapshot.find(str(run))
    individual = snapshot.individual(which)
    until = individual.generation
    begin(until)
    genealogy, named = Genealogy(snapshot.experiment_at(until).space()), True
    for bred in breed_again(snapshot, until, advance):
        genealogy.add(bred)
        named = named and (bred.parents is not None or bred.generation.number == 1)
    assert individual.genome is not None, "individuals of runs have genomes"
    genealogy.prune()
    row = genealogy.row_of(individual.genome)
    if row is None:
        raise GaitsimError(
            f"{individual.label} is not among the genomes that the search had",
            where=str(snapshot.path),
            remedy="'gaitsim verify' finds files that were changed",
        )
    line = line_of(genealogy.rows, row)
    steps = _steps(snapshot, genealogy.rows.take(np.array(line)), workers)
    found = Lineage(snapshot, individual, steps, genealogy.rows, row, named)
    return _with_reasons(found, leaps, workers)


def _steps(run: RunSnapshot, line: Rows, workers: int | None) -> tuple[Step, ...]:
    """Return the steps of a line, each evaluated again beside its parent in the same worlds."""
    generations = line.generation.tolist()
    genomes = [(line.genomes[max(at - 1, 0)], line.genomes[at]) for at in range(len(line))]
    wanted = [(born, one) for born, pair in zip(generations, genomes, strict=True) for one in pair]
    scored = _evaluate(run, wanted, workers)
    found = []
    for at, generation in enumerate(generations):
        (before, terms_before), (score, terms) = scored[2 * at : 2 * at + 2]
        experiment = run.experiment_at(generation)
        changes = _changes(experiment, *genomes[at], line.inherited[at]) if at else ()
        lost, added = _parts(experiment, *genomes[at]) if at else ((), ())
        place, other = Numbered(generation, int(line.number[at])), None
        if line.other[at, 0]:
            other = Numbered(*line.other[at].tolist())
        how = (
            _how(changes, other, line.genomes.shape[1], named=bool(line.named[at]))
            if at
            else _founder(run, line.genomes[0])
        )
        differences = {name: value - terms_before[name] for name, value in terms.items()}
        found.append(
            Step(
                place,
                line.genomes[at],
                score,
                float(line.scores[at]),
                score - before if at and np.isfinite(before) else np.nan,
                how,
                other,
                changes,
                differences if at else {},
                lost,
                added,
            )
        )
    return tuple(found)


def _evaluate(
    run: RunSnapshot, wanted: Sequence[tuple[int, Genomes]], workers: int | None
) -> list[tuple[float, dict[str, float]]]:
    """Return score and terms of genomes in the worlds of generations, which ascend."""
    found: list[tuple[float, dict[str, float]]] = []

    def same(one: tuple[int, Genomes]) -> tuple[int, int]:
        stage = run.stage_at(one[0])
        return stage.number, stage.outline.worlds.first_of_draw(one[0])

    for _, group in groupby(wanted, same):
        members = [*group]
        generation = members[0][0]
        with Evaluator(run.experiment_at(generation), workers) as evaluator:
            evaluation = evaluator.evaluate(np.stack([one for _, one in members]), generation)
        found += [
            (float(score), evaluation.terms_of(at)) for at, score in enumerate(evaluation.scores)
        ]
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


def _with_reasons(found: Lineage, leaps: int, workers: int | None) -> Lineage:
    """Return the line with the changes of its largest rises tried one by one."""
    steps = [*found.steps]
    for index in found.rises[:leaps]:
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
        with Evaluator(experiment, workers) as evaluator:
            scores = evaluator.evaluate(genomes, generation).scores
        before = step.score - step.gain
        gains, losses = np.split(np.where(np.isfinite(scores), scores, -np.inf), 2)
        changes = tuple(
            replace(one, alone=float(gain - before), without=float(step.score - rest))
            for one, gain, rest in zip(tried, gains, losses, strict=True)
        )
        steps[index] = replace(step, changes=changes + step.changes[MOST_CHANGES:])
    return replace(found, steps=tuple(steps))


def _common_ancestor(rows: Rows) -> int | None:
    """Return the last row from which all rows without children descend; None without one."""
    children = np.bincount(rows.parent[rows.parent >= 0], minlength=len(rows))
    roots = np.flatnonzero(rows.parent < 0)
    if len(roots) != 1:
        return None
    at = int(roots[0])
    following = {parent: row for row, parent in enumerate(rows.parent.tolist())}
    while children[at] == 1:
        at = following[at]
    return at


def _short(value: float) -> str:
    return f"{value:.3g}".replace("-", "−")


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %"


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
