"""What the gallery shows of one run."""

import base64
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

from gaitsim.contracts import Skeleton
from gaitsim.errors import GaitsimError
from gaitsim.individual import Individual
from gaitsim.render.scene import Clip, Scene
from gaitsim.runs.notes import read_note
from gaitsim.runs.snapshot import RunSnapshot
from gaitsim.sharing.challenge import code_of

SIZE = 480, 300  # pixels of a picture
MOMENT = 0.4  # of the motion, which a picture shows
QUALITY = 80  # of a WebP file


@dataclass(frozen=True)
class Card:
    """A run, as the index shows it.

    Attributes:
        name: of its folder.
        description: of its experiment.
        body, fitness: names of these plugins.
        score: of its champion.
        unit: of the score, or ''.
        which: which individual the champion is, such as 'generation 120'.
        worlds: ' over 4 worlds', or ''.
        generations: that are finished.
        note: of its user, or ''.
        code: the challenge code of the champion, or ''.
        pictures: the champion as files of WebP, by theme; {} where it cannot be drawn.
        problems: why parts of it are missing, a text each.
        page: path of the page that plays it from the index, or ''.
        code_file: path of the file with a code that is too long for the index, or ''.
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
    """Return a run and its champion.

    Raises:
        GaitsimError: it is damaged or has no champion, or a plugin is not installed.
    """
    run = RunSnapshot(path)
    return run, run.individual()


def card_of(run: RunSnapshot, champion: Individual) -> Card:
    """Return the card of a run, without its page. What cannot be made is among its problems."""
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
    """Return a picture of a body in motion, as a URL that holds it."""
    from PIL import Image

    scene = Scene([Clip(skeleton)], SIZE, "iso", theme)
    data = BytesIO()
    picture = Image.fromarray(scene.draw(MOMENT * scene.seconds)[..., :3])
    picture.save(data, format="WEBP", quality=QUALITY, method=6)
    return f"data:image/webp;base64,{base64.b64encode(data.getvalue()).decode()}"
