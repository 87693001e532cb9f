"""Values of runs in tables: of `gaitsim runs` and of the terminal UI."""

from gaitsim.render.terminal.text import age, duration, number
from gaitsim.storage.overview import Overview
from gaitsim.storage.query import value_of
from gaitsim.toml import shortened


def run_cell(run: Overview, key: str, now: float) -> str:
    """Return a value of a run as text; '' if the run does not have it.

    Args:
        run: the run.
        key: key of the value, as in queries.
        now: time in seconds since 1970.
    """
    value = value_of(run, key)
    match key, value:
        case _, None:
            return ""
        case "generation", _:
            return f"{run.generation}/{run.generations}" if run.generations else ""
        case "age", _:
            return age(now - run.changed)
        case "time", float() | int():
            return duration(value)
        case "score", float() | int():
            return number(value, 4)
        case "evaluations", int():
            return f"{value:,}"
        case _, bool():
            return str(value).lower()
        case _, float():
            return f"{value:.4g}".replace("-", "−")
        case _, tuple():
            return ", ".join(map(str, value))
    return shortened(str(value).partition("\n")[0])
