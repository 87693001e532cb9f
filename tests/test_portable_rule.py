"""What decides a result uses portable arithmetic: ruff bans functions, and this test the rest."""

import ast
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
DRAWS = {
    "beta", "binomial", "chisquare", "exponential", "gamma", "geometric", "gumbel", "laplace",
    "logistic", "lognormal", "multivariate_normal", "normal", "pareto", "poisson", "power",
    "rayleigh", "standard_cauchy", "standard_exponential", "standard_gamma", "standard_normal",
    "standard_t", "triangular", "uniform", "vonmises", "wald", "weibull", "dot",
}  # fmt: skip


def covered():
    """Return the files that ruff's rule covers."""
    ignores = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["ruff"]["lint"]
    [pattern] = [key for key in ignores["per-file-ignores"] if key.startswith("!")]
    listed = subprocess.run(
        [sys.executable, "-m", "ruff", "check", "--isolated", "--show-files",
         "--config", f'include = ["{pattern[1:]}"]', ROOT],
        capture_output=True, text=True, check=True, cwd=ROOT,
    )  # fmt: skip
    return [Path(line) for line in listed.stdout.split() if line.endswith(".py")]


def offences(text):
    """Return the expressions of a module that are not portable."""
    for node in ast.walk(ast.parse(text)):
        operator = getattr(node, "op", None)
        if isinstance(operator, ast.MatMult):
            yield node.lineno, "@"
        # Powers of a whole number are exact.
        base = getattr(node, "left", None)
        if isinstance(operator, ast.Pow) and not isinstance(base, (ast.Constant, ast.UnaryOp)):
            yield node.lineno, "**"
        if isinstance(node, ast.Call) and getattr(node.func, "attr", None) in DRAWS:
            yield node.lineno, node.func.attr


@pytest.mark.parametrize(
    "planted",
    ["x @ y", "x ** 2", "x **= 0.5", "rng.normal(0, 1)", "self.rng.uniform(a, b)", "x.dot(y)"],
)
def test_the_rule_finds_operators_and_draws(planted):
    assert [*offences(planted)]


@pytest.mark.parametrize("planted", ["np.exp(x)", "math.sin(x)", "np.linalg.norm(x)", "np.einsum"])
def test_lint_finds_a_function_planted_in_a_search(planted):
    found = subprocess.run(
        [sys.executable, "-m", "ruff", "check", "--output-format", "concise",
         "--stdin-filename", "plugins/gaitsim_searches/planted.py", "-"],
        input=f"import math\n\nimport numpy as np\n\nx = math.pi * np.pi\ny = {planted}\n",
        capture_output=True, text=True, check=False, cwd=ROOT,
    )  # fmt: skip
    assert "TID251" in found.stdout


def test_no_operator_or_draw_decides_a_result():
    files = covered()
    names = {path.relative_to(ROOT).as_posix() for path in files}
    assert {"gaitsim/network.py", "plugins/gaitsim_searches/cma_es.py"} <= names
    assert "plugins/gaitsim_robot/organism.py" not in names
    found = [
        f"{path.relative_to(ROOT)}:{line}: {what}"
        for path in files
        for line, what in offences(path.read_text())
    ]
    assert not found
