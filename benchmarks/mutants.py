"""Break random places in the code, one at a time, and count those that a package's tests notice.

    python mutants.py [COUNT] [SEED]

Run it in a separate working copy, as it changes files and restores them. The place and the change
of each mutant that survives are printed. A mutant may survive because it changes nothing, or
because tests of other packages would notice it.
"""

import ast
import os
import random
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
TESTS = {
    "gaitsim_operators": "tests/operators",
    "gaitsim_searches": "tests/searches tests/evolution tests/storage/test_searches.py",
    "gaitsim_spider": "tests/spider tests/evolution",
    "gaitsim_millipede": "tests/millipede tests/evolution",
    "gaitsim_fly": "tests/fly tests/evolution",
    "gaitsim_walker": "tests/walker tests/evolution",
    "gaitsim_plots": "tests/render",
    "gaitsim_exports": "tests/cli tests/gait",
}
"""Tests of packages whose tests are not in their own folder."""

REST = "tests/cli tests/storage tests/live tests/tui tests/test_api.py tests/test_in_python.py"
"""Tests of parts of the core without a folder of tests."""

SWAPPED: dict[type, type] = {
    ast.Lt: ast.GtE, ast.LtE: ast.Gt, ast.Gt: ast.LtE, ast.GtE: ast.Lt, ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq, ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn,
    ast.NotIn: ast.In, ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult,
    ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip


def main() -> None:
    count, seed = (int(word) for word in (*sys.argv[1:], "60", "1")[:2])
    chance, caught, tried = random.Random(seed), 0, 0
    packages = [ROOT / "gaitsim", *sorted(ROOT.glob("plugins/gaitsim[_-]*"))]
    while tried < count:
        package = packages[tried % len(packages)]
        files = [one for one in sorted(package.rglob("*.py")) if "tests" not in one.parts]
        path = chance.choice(files)
        text = path.read_text(encoding="utf-8")
        places = [*_places(ast.parse(text))]
        if not places:
            continue
        tried += 1
        found = chance.choice(places)
        changed = _mutated(text, found)
        path.write_text(changed, encoding="utf-8")
        try:
            noticed = _fails(tests_of(path))
        finally:
            path.write_text(text, encoding="utf-8")
        caught += noticed
        line = text.splitlines()[found.lineno - 1].strip()
        verdict = "caught" if noticed else "SURVIVED"
        print(f"{tried:3} {verdict:9}{path.relative_to(ROOT)}:{found.lineno}: {line}", flush=True)
    print(f"{caught} of {tried} caught")


def tests_of(path: Path) -> list[str]:
    """Return the tests of the package that a file belongs to."""
    parts = path.relative_to(ROOT).parts
    if parts[0] == "plugins":
        return TESTS.get(parts[1], f"plugins/{parts[1]}/tests").split()
    own = ROOT / "tests" / parts[1].removesuffix(".py")
    return [str(own)] if own.is_dir() else REST.split()


def _places(tree: ast.AST) -> Iterator[ast.expr]:
    for function in ast.walk(tree):
        if isinstance(function, ast.FunctionDef):
            for node in ast.walk(function):
                operator = (
                    node.ops[0]
                    if isinstance(node, ast.Compare)
                    else node.op
                    if isinstance(node, ast.BinOp | ast.BoolOp)
                    else None
                )
                if type(operator) in SWAPPED:
                    yield node  # type: ignore[misc]


def _mutated(text: str, node: ast.expr) -> str:
    """Return a text with the operator of one expression swapped."""
    if isinstance(node, ast.Compare):
        node.ops[0] = SWAPPED[type(node.ops[0])]()
    elif isinstance(node, ast.BinOp | ast.BoolOp):
        node.op = SWAPPED[type(node.op)]()
    data = text.encode()
    starts = [0]
    for line in data.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    assert node.end_lineno is not None
    assert node.end_col_offset is not None
    first = starts[node.lineno - 1] + node.col_offset
    last = starts[node.end_lineno - 1] + node.end_col_offset
    return (data[:first] + f"({ast.unparse(node)})".encode() + data[last:]).decode()


def _fails(tests: list[str]) -> bool:
    """Return whether any of these tests fails, hangs, or cannot start."""
    folders = [ROOT, *ROOT.glob("plugins"), *ROOT.glob("plugins/gaitsim-*")]
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *tests]
    try:
        done = subprocess.run(
            command,
            cwd=ROOT,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(map(str, folders))},
            capture_output=True,
            timeout=600,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return True
    return done.returncode != 0


if __name__ == "__main__":
    main()
