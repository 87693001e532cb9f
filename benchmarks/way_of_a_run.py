"""Print how many of gaitsim's frames and calls come before the first movement of a body.

Usage: python benchmarks/way_of_a_run.py run spider --out DIR --generations 1
"""

import sys
from collections import Counter
from pathlib import Path
from types import FrameType

ROOTS = tuple(f"{Path(__file__).parents[1] / name}/" for name in ("gaitsim", "plugins"))


def main() -> None:
    """Run a command, and print the figures at the first call of a method `move`."""
    calls: Counter[str] = Counter()

    def count(frame: FrameType, event: str, _: object) -> None:
        code = frame.f_code
        if event != "call" or not code.co_filename.startswith(ROOTS):
            return
        if code.co_name == "move":
            sys.setprofile(None)
            _print_figures(frame, calls)
        elif not code.co_name.startswith("<"):  # modules, comprehensions and lambdas
            calls[code.co_filename] += 1

    from gaitsim.cli import main as command

    sys.setprofile(count)
    command()


def _print_figures(frame: FrameType, calls: "Counter[str]") -> None:
    frames = []
    at: FrameType | None = frame
    while at is not None:
        if at.f_code.co_filename.startswith(ROOTS):
            frames.append(f"{at.f_code.co_qualname} ({Path(at.f_code.co_filename).name})")
        at = at.f_back
    lines = [f"{len(frames)} frames, {calls.total()} calls in {len(calls)} modules", *frames[::-1]]
    for file, number in calls.most_common(12):
        lines.append(f"{number:6} {file}")
    print("\n".join(lines), file=sys.stderr)


if __name__ == "__main__":
    main()
