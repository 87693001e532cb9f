"""The cards of a gallery: one run each."""

import base64
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

from gaitsim.contracts import Skeleton
from gaitsim.errors import GaitsimError
from gaitsim.individual import Individual
from gaitsim.render.scene import Clip, Scene
from gaitsim.runs.manage import read_note
from gaitsim.runs.snapshot import RunSnapshot
from gaitsim.sharing.challenge import code_of

SIZE = 480, 300  # size of a picture, pixels
MOMENT = 0.4  # moment in the picture, as a share of the motion
QUALITY = 80  # quality of a WebP file


@dataclass(frozen=True)
class Card:
    """The content of a run's card in the index.

    Attributes:
        name: name of the run's folder.
        description: description of the experiment.
        body, fitness: names of the plugins.
        score: score of the champion.
        unit: unit of the score, or ''.
        which: label of the champion, such as 'generation 120'.
        worlds: number of worlds, as ' over 4 worlds', or ''.
        generations: number of finished generations.
        note: note of the user, or ''.
        code: challenge code of the champion, or ''.
        pictures: pictures of the champion as WebP data URLs, by theme; {} if it cannot be drawn.
        problems: reasons why parts are missing.
        page: path, relative to the index, of the page that plays the champion, or ''.
        code_file: path, relative to the index, of the file with a challenge code that is too long
            for the index, or ''.
    """

    name: str
    description: str
    body: str
    fitness: str
    score: float
    unit: str
    which: str
    worlds: str
    generations: int
    note: str
    code: str
    pictures: dict[str, str]
    problems: tuple[str, ...]
    page: str = ""
    code_file: str = ""


def read_champion(path: Path) -> tuple[RunSnapshot, Individual]:
    """Return a run and its champion."""
    run = RunSnapshot(path)
    return run, run.individual()


def card_of(run: RunSnapshot, champion: Individual) -> Card:
    """Return the card of a run, without its page; parts that fail are listed as problems."""
    experiment = champion.experiment
    problems = []
    note, code = "", ""
    pictures: dict[str, str] = {}
    try:
        note = read_note(run.path)
    except GaitsimError as error:
        problems.append(error.what)
    try:
        code = code_of(champion)
    except GaitsimError as error:
        problems.append(f"no challenge code: {error.what}")
    try:
        skeleton = champion.skeleton
        pictures = {theme: _picture(skeleton, theme) for theme in ("light", "dark")}
    except GaitsimError as error:
        problems.append(f"no picture: {error.what}")
    return Card(
        name=champion.name,
        description=experiment.description,
        body=experiment.entries["organism"].name,
        fitness=experiment.entries["fitness"].name,
        score=champion.score,
        unit=experiment.fitness.unit,
        which=champion.label,
        worlds=champion.over_worlds,
        generations=run.generation,
        note=note,
        code=code,
        pictures=pictures,
        problems=tuple(problems),
    )


def _picture(skeleton: Skeleton, theme: str) -> str:
    """Return a picture of a body in motion, as a data URL."""
    from PIL import Image

    scene = Scene([Clip(skeleton)], SIZE, "iso", theme)
    data = BytesIO()
    picture = Image.fromarray(scene.draw(MOMENT * scene.seconds)[..., :3])
    picture.save(data, format="WEBP", quality=QUALITY, method=6)
    return f"data:image/webp;base64,{base64.b64encode(data.getvalue()).decode()}"
