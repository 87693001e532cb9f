"""Texts of the live screen: pure functions of a snapshot and the history."""

import math

from rich.cells import cell_len, set_cell_size
from rich.style import Style
from rich.text import Text

from gaitsim.live.protocol import Event, Snapshot
from gaitsim.render.terminal.curves import sparkline
from gaitsim.render.terminal.text import number
from gaitsim.runs.files.history import FIGURE, MEAN
from gaitsim.runs.growing import HistoryBuffer
from gaitsim.tui.formatting import clip, duration

Styles = dict[str, Style]  # styles of the theme by state, event or part

MARKS = {
    "preparing": "◌",
    "queued": "◌",
    "running": "●",
    "paused": "‖",
    "finished": "✓",
    "stopped": "■",
    "failed": "✗",
    "elsewhere": "◉",
    "stopping": "■",
}
WORDS = {"elsewhere": "running in another program"}
HINTS = {
    "queued": "The run starts when an earlier run ends or is paused.",
    "paused": "space: resume · n: evolve one generation · c: change options · f: fork",
    "stopping": "The run stops after this generation · s: stop immediately",
    "stopped": "space: resume · c: change options · g: set the number of generations",
    "elsewhere": "Another program evolves this run, so you can only watch it · f: fork",
}
EVENT_MARKS = {"best": "★", "kept": "⚑", "stage": "▶", "warning": "!"}
TITLES = (
    "best of each generation",
    "best over time",
    "trend",
)  # of the curve column, the longest that fits
VALUE = 9  # columns of a number
NAME = 12
LEAST_SPARK = 8
WIDEST_SPARK = 60
LEAST_BAR = 6
LABELLED = 24  # minimum columns of an event with a label before its generation


def status(snapshot: Snapshot, state: str, width: int, styles: Styles) -> Text:
    """Return the state, generation, speed and remaining time on one line."""
    line = Text(no_wrap=True, end="")
    line.append(f"{MARKS[state]} {WORDS.get(state, state)}", styles[state])
    numbers = f"{snapshot.generation:,}/{snapshot.generations:,}"
    rest = Text()
    if snapshot.evaluations_per_second > 0:
        rest.append(f"  {snapshot.evaluations_per_second:,.0f} evaluations/s")
    left = snapshot.seconds_left
    if left is not None and not snapshot.ended:
        rest.append(f"  {duration(left)} left")
    if snapshot.stage > 1:
        rest.append(f"  stage {snapshot.stage}", styles["stage"])
    for label in ("  generation ", "  "):  # a label only if the bar fits too
        room = width - line.cell_len - len(label + numbers) - rest.cell_len - 2
        if room >= LEAST_BAR:
            break
    line.append(label + numbers)
    if room >= LEAST_BAR and snapshot.generations:
        full = round(min(snapshot.generation / snapshot.generations, 1.0) * room)
        line.append("  ").append("━" * full, styles[state]).append(
            "─" * (room - full), styles["dim"]
        )
    line.append_text(rest)
    line.truncate(width, overflow="ellipsis")
    return line


def hint(snapshot: Snapshot, state: str, seconds: int = 0) -> str:
    """Return a hint for a state that has lasted `seconds`; '' while the run evolves."""
    if state == "preparing":
        passed = f"{seconds} s" if seconds < 60 else duration(seconds)
        return f"Preparing for {passed}; the first run of a body compiles its kernels …"
    if state == "finished":
        return f"{snapshot.reason} · g: more generations · r: replay · e: export"
    return HINTS.get(state, "")


def event_line(event: Event, width: int, styles: Styles) -> Text:
    """Return an event on one line."""
    line = Text(no_wrap=True, end="")
    label = "gen. " if width >= LABELLED else " "
    line.append(f"{label}{event.generation:>5,} ", styles["dim"])
    line.append(f"{EVENT_MARKS[event.kind]} ", styles[event.kind])
    text = event.text
    if event.kind == "best":
        text = f"best score {text.replace('-', '−')}"
    elif event.kind == "kept":
        text = "saved as a champion"
    line.append(clip(text, max(width - line.cell_len, 1)))
    return line


def table(snapshot: Snapshot, course: HistoryBuffer, width: int, styles: Styles) -> list[Text]:
    """Return the score, terms, diversity and the search's figures, one per line.

    Each line has a curve of the best of each generation, then numbers of the last generation:
    the mean, and as many of the best individuals as fit.
    """
    terms = list(snapshot.top[0].terms) if snapshot.top else course.terms
    names = ["diversity", *terms, *course.figures]
    name = min(max(map(cell_len, names)), max(NAME, width // 6))
    fit = (width - name - LEAST_SPARK - 2) // VALUE - 1
    top = snapshot.top[: max(fit, 0)]
    room = min(max(width - name - 2 - (1 + len(top)) * VALUE, 0), WIDEST_SPARK)
    title = next((title for title in TITLES if len(title) <= room), "")
    head = Text(" " * name + " " + _left(title, room), no_wrap=True, end="")
    for title in ("mean", *(f"#{rank + 1}" for rank in range(len(top)))):
        head.append(title.rjust(VALUE))
    head.stylize(styles["dim"])
    rows = [("score", "best", "mean", [one.score for one in top])]
    rows += [
        (term, term, MEAN + term, [one.terms.get(term, math.nan) for one in top]) for term in terms
    ]
    rows += [("diversity", "diversity", "diversity", [])]
    rows += [(figure, FIGURE + figure, FIGURE + figure, []) for figure in course.figures]
    lines, scored_from = [head], snapshot.scored_from
    for label, column, mean, values in rows:
        first = scored_from - 1 if len(course) >= scored_from else 0
        curve = sparkline(course[column][first:], room) if column in course else ""
        score = label == "score" and column == "best"
        line = Text(_left(label, name) + " ", Style(bold=score), no_wrap=True, end="")
        line.append(curve.ljust(room), styles["spark-score" if score else "spark"])
        for value in (_last(course, mean), *values):
            line.append((number(value) if math.isfinite(value) else "–").rjust(VALUE))
        lines.append(line)
    return islands(snapshot, width, styles) + lines


def islands(snapshot: Snapshot, width: int, styles: Styles) -> list[Text]:
    """Return the best score of each island in the last generation; [] for one population."""
    bests = snapshot.islands
    if not bests:
        return []
    head = "best of each island"
    beside = width >= len(head) + VALUE
    most = max(filter(math.isfinite, bests), default=0.0)
    fit = max((width - len(head) * beside) // VALUE, 1)
    lines = [] if beside else [Text(head, styles["dim"], no_wrap=True, end="")]
    for first in range(0, len(bests), fit):
        line = Text(no_wrap=True, end="")
        if beside:
            line.append((head if first == 0 else "").ljust(len(head)), styles["dim"])
        for best in bests[first : first + fit]:
            text = number(best) if math.isfinite(best) else "–"
            line.append(text.rjust(VALUE), styles["spark-score"] if best == most else "")
        lines.append(line)
    return lines


def _left(text: str, width: int) -> str:
    return set_cell_size(clip(text, width), width) if width > 0 else ""


def _last(course: HistoryBuffer, name: str) -> float:
    return float(course[name][-1]) if name in course and len(course) else math.nan
