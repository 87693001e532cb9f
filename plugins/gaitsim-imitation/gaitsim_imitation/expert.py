"""The gait that a network imitates, from an individual or a gait file."""

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gaitsim.plugin import GaitsimError, literal, plugin_errors, registry, shortened
from gaitsim.plugin.gait import SUFFIXES, Gait, GaitFile, fit_to_body, gait_of, read_gait
from gaitsim.plugin.pictures import heading_of_run
from gaitsim.plugin.runs import (
    EXPORTS,
    Choice,
    Experiment,
    Individual,
    RunSnapshot,
    exports_folder,
    holds_run,
    load_experiment,
    play,
    require_play,
)

_BODY = (
    "choose the body of a preset, a file or a run, such as --body spider; in Python, body='spider'"
)


@dataclass(frozen=True, eq=False)
class Expert:
    """A gait to learn.

    Attributes:
        gait: gait with the angles that the network learns, unchanged if from a file.
        experiment: experiment whose body and fitness evaluate expert and imitator.
        individual: expert on that body; None for a gait file if the body cannot play joint angles.
        source: folder of the run, or the gait file; None for an individual that is not recorded.
        body: origin of the body of a gait file, such as 'preset spider'; '' otherwise.
    """

    gait: Gait
    experiment: Experiment
    individual: Individual | None
    source: Path | None
    body: str = ""

    @property
    def file(self) -> Path | None:
        """The gait file; None if the expert is an individual of a search."""
        return None if self.gait.generation else self.source

    @property
    def title(self) -> str:
        """Description of the gait, with its source."""
        if self.individual is not None:
            return self.individual.title
        return f"{self.source} on the {self.experiment.entries['organism'].name}"

    @property
    def name(self) -> str:
        """Name of the run's folder or of the gait file, or else of the experiment."""
        return self.source.resolve().name if self.source else self.experiment.name

    @property
    def heading(self) -> str:
        """Heading for figures: the name and, for a run, its experiment's name and seed."""
        return self.name if self.file else heading_of_run(self.name, self.experiment)

    def folder(self) -> Path:
        """Return the folder for exports: the run's, or else the folder of the gait file."""
        if self.file is None:
            return exports_folder(self.source or Path())
        run = _run_of_export(self.file)
        return exports_folder(run) if run else self.file.parent


def find_expert(reference: str, body: str | None = None, which: Choice = None) -> Expert:
    """Return the gait of a run's champion, or of a gait file.

    Args:
        reference: name or folder of a run, or path of a gait file.
        body: body of a gait file: the name of a preset, or the path of an experiment, a robot's
            file or a run's folder. None takes the run in whose exports folder the file is, or
            else a preset whose body has the joints that the file names.
        which: individual of the run; None for the champion.
    """
    if not is_gait_file(reference):
        run = RunSnapshot.find(reference)
        if body is not None:
            raise GaitsimError(
                f"{reference} is a run, which defines its own body",
                where="--body",
                remedy="omit --body, or give a gait file",
            )
        individual = run.individual(which)
        individual.experiment.check_functions()
        return expert_of(individual)
    if which is not None:
        raise GaitsimError(
            f"{reference} is a gait file, which has no generations or members",
            remedy="omit --generation and --member, or give a run",
        )
    return expert_of_file(read_gait(Path(reference)), body)


def is_gait_file(reference: str) -> bool:
    """Return whether a reference is a gait file, rather than a run."""
    # Unlike pathlib, os.path does not raise errors for invalid file names.
    if os.path.isdir(reference):  # noqa: PTH112
        return False
    return Path(reference).suffix.lower() in SUFFIXES or os.path.isfile(reference)  # noqa: PTH113


def expert_of(individual: Individual) -> Expert:
    """Return the gait of an individual as an expert."""
    gait = gait_of(individual)
    if len(gait.angles) < 2 or gait.slides or not np.isfinite(gait.angles).all():
        raise GaitsimError(
            f"the gait of generation {individual.generation} cannot be learnt",
            where=str(individual.source),
            allowed="two or more frames, with finite angles of joints that all turn",
        )
    return Expert(gait, individual.embodied.experiment, individual, individual.source)


def expert_of_file(file: GaitFile, body: str | None = None) -> Expert:
    """Return the gait of a file as an expert, played on its body if the body can play it.

    Angles at a different frame rate are interpolated to the body's frame rate.
    """
    experiment, named = _body(file, body)
    organism, entry = experiment.organism, experiment.entries["organism"]
    if "joint_angles" not in organism.channels:
        require_play(experiment)
    if organism.can_play:
        angles = fit_to_body(file, experiment)
        individual = Individual.of_motion(experiment, play(experiment, angles[None]), file.path)
        gait = replace(gait_of(individual), angles=angles)
        return Expert(gait, experiment, individual, file.path, named)
    with plugin_errors(entry, "naming its joints"):
        joints, rest = tuple(organism.joint_names()), np.asarray(organism.standing_pose())
    if file.frame_rate is None:
        raise GaitsimError(
            f"{file.path} has no frame rate, and {entry} cannot play joint angles at its own rate",
            allowed="a .mat or .npz file with frameRate (Hz), or a .csv file with time_s (s)",
        )
    gait = Gait(file.in_order(joints), joints, file.frame_rate, 0, math.nan, rest)
    return Expert(gait, experiment, None, file.path, named)


def _body(file: GaitFile, body: str | None) -> tuple[Experiment, str]:
    """Return the experiment with the body of a gait, and a description of its origin."""
    if body is not None and holds_run(Path(body)):
        return RunSnapshot(Path(body)).experiment, f"the run {body}"
    if body is not None:
        return load_experiment(body), body
    if run := _run_of_export(file.path):
        return RunSnapshot(run).experiment, f"the run {run}"
    if not file.joint_names:
        raise GaitsimError(
            f"{file.path} does not name its {file.angles.shape[1]} joints, so its body is unknown",
            remedy=_BODY,
        )
    for name in sorted(registry.entries(registry.EXPERIMENTS)):
        try:
            experiment = load_experiment(name)
            joints = _joints(experiment)
        except GaitsimError:  # a plugin fails, or is not completely installed
            continue
        if sorted(joints) == sorted(file.joint_names):
            return experiment, f"the preset {name}"
    names = shortened(", ".join(literal(joint) for joint in file.joint_names), 80)
    raise GaitsimError(
        f"no preset has a body with the {len(file.joint_names)} joints of {file.path}: {names}",
        remedy=_BODY,
    )


def _joints(experiment: Experiment) -> Sequence[str]:
    organism = experiment.organism
    if "joint_angles" not in organism.channels:
        return ()
    with plugin_errors(experiment.entries["organism"], "naming its joints"):
        return [str(name) for name in organism.joint_names()]


def _run_of_export(file: Path) -> Path | None:
    """Return the run whose exports folder contains a file, or None."""
    folder = file.parent if file.parent.name else file.absolute().parent
    return folder.parent if folder.name == EXPORTS and holds_run(folder.parent) else None
