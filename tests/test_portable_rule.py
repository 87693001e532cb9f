"""Portable arithmetic where results are decided: ruff bans functions, this test the rest."""

import ast
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
DRAWS = {
    "dirichlet", "f", "multinomial", "negative_binomial", "noncentral_chisquare",
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
        if isinstance(operator, ast.Pow) and not _exact(getattr(node, "left", None)):
            yield node.lineno, "**"
        if getattr(node, "id", None) == "pow":
            yield node.lineno, "pow"
        if isinstance(node, ast.Attribute) and node.attr in DRAWS:
            yield node.lineno, node.attr


def _exact(base):
    """Return whether powers of a constant are exact: of whole numbers and of ±1."""
    if isinstance(base, ast.UnaryOp):
        base = base.operand
    return isinstance(base, ast.Constant) and base.value in (1, 2, 2.0, 10)


PLANTED = [
    "x @ y", "x ** 2", "x **= 0.5", "0.9 ** x", "(-x) ** 0.5", "pow(x, 2)", "x.dot(y)",
    "rng.normal(0, 1)", "self.rng.uniform(a, b)", "draw = rng.standard_normal",
]  # fmt: skip


@pytest.mark.parametrize("planted", PLANTED)
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


@pytest.mark.packages
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
