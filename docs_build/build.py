"""Build the documentation site in site/: `python docs_build/build.py`.

Code hosts show the pages of docs/ directly, so that folder stays unchanged. The script copies it to
build/docs, adds the generated pages and the pages from outside docs/, and adapts the links.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import commands
import everything
import parts

from gaitsim_page.playground import write_page

ROOT = Path(__file__).parents[1]
STAGE = ROOT / "build" / "docs"
OUTSIDE = {
    "../CHANGELOG.md": "changelog.md",
    "../CONTRIBUTING.md": "contributing.md",
    "../benchmarks/README.md": "benchmarks.md",
    "../data/SOURCES.md": "sources.md",
    "../examples/gaitsim-gymnasium/README.md": "gymnasium.md",
    "../README.md": "index.md",
}
"""Files outside docs/ that its pages link to -> their file names on the site."""

API = {
    "api.md": (
        "# Python: the whole API",
        [
            "gaitsim.api.evolve",
            "gaitsim.registry.python_plugins.scalar",
            "gaitsim.optimiser.Optimiser",
            "gaitsim.evaluating.evaluate",
            "gaitsim.api.load",
            "gaitsim.api.runs",
            "gaitsim.api.presets",
            "gaitsim.api.analyse",
            "gaitsim.api.verify",
            "gaitsim.api.share",
            "gaitsim.api.export",
            "gaitsim.api.picture",
            "gaitsim.api.view",
            "gaitsim.api.RunningSearch",
            "gaitsim.api.Run",
            "gaitsim.api.Individual",
            "gaitsim.api.Member",
            "gaitsim.gait.GaitAnalysis",
            "gaitsim.storage.verification.Verdict",
            "gaitsim.sharing.challenge.Checked",
            "gaitsim.sharing.challenge.Challenge",
            "gaitsim.imitation.imitating.imitate",
            "gaitsim.comparing.compare",
            "gaitsim.comparing.importance",
            "gaitsim.comparing.Comparison",
            "gaitsim.study.importance.Importance",
            "gaitsim.study.importance.Share",
            "gaitsim.experiment.load_experiment",
            "gaitsim.experiment.load_atlas",
            "gaitsim.experiment.Experiment",
            "gaitsim.evolution.Generation",
            "gaitsim.evaluation.Evaluation",
            "gaitsim.errors.GaitsimError",
        ],
    ),
    "contracts.md": (
        "# Contracts of plugins, and their check",
        [
            "gaitsim.contracts.Plugin",
            "gaitsim.contracts.option",
            "gaitsim.contracts.Organism",
            "gaitsim.contracts.Fitness",
            "gaitsim.contracts.Selection",
            "gaitsim.contracts.Crossover",
            "gaitsim.contracts.Mutation",
            "gaitsim.contracts.Search",
            "gaitsim.contracts.Context",
            "gaitsim.contracts.Results",
            "gaitsim.contracts.Members",
            "gaitsim.contracts.Plot",
            "gaitsim.contracts.Exporter",
            "gaitsim.contracts.Exported",
            "gaitsim.contracts.Subject",
            "gaitsim.contracts.RealSpace",
            "gaitsim.contracts.BitSpace",
            "gaitsim.contracts.GenomeSpace",
            "gaitsim.contracts.Motion",
            "gaitsim.contracts.Channel",
            "gaitsim.contracts.Measure",
            "gaitsim.contracts.Skeleton",
            "gaitsim.contracts.Solid",
            "gaitsim.contracts.Rig",
            "gaitsim.contracts.Link",
            "gaitsim.contracts.Condition",
            "gaitsim.contracts.BodyFile",
            "gaitsim.contracts.folder_of",
            "gaitsim.contracts.Command",
            "gaitsim.contracts.Steered",
            "gaitsim.contracts.Reflex",
            "gaitsim.contracts.Legs",
            "gaitsim.contracts.Observation",
            "gaitsim.contracts.Inputs",
            "gaitsim.contracts.Controller",
            "gaitsim.encoding.GeneGroup",
            "gaitsim.encoding.genome_space",
            "gaitsim.encoding.split_genomes",
            "gaitsim.encoding.Oscillators",
            "gaitsim.encoding.amplitude_limit",
            "gaitsim.encoding.limit_steps",
            "gaitsim.encoding.check_joint_angles",
            "gaitsim.testing",
        ],
    ),
}
"""Pages generated from docstrings: file name -> heading and documented objects."""


def collect_pages() -> None:
    """Collect all pages of the site in the folder `STAGE`."""
    shutil.rmtree(STAGE, ignore_errors=True)
    shutil.copytree(ROOT / "docs", STAGE)
    for page in STAGE.glob("*.md"):
        page.write_text(_with_links_to_copies(page.read_text()))
    for source, name in OUTSIDE.items():
        if name != "index.md":
            page = ROOT / source.removeprefix("../")
            (STAGE / name).write_text(with_site_links(page.read_text(), page.parent))
    write_page(STAGE / "playground.html")
    shutil.copy(ROOT / "docs_build" / "site.css", STAGE)
    shutil.copytree(ROOT / "docs_build" / "fonts", STAGE / "fonts")
    (STAGE / "commands.md").write_text(commands.page())
    (STAGE / "parts.md").write_text(parts.page())
    documented = {one: name for name, (_, objects) in API.items() for one in objects}
    (STAGE / "everything.md").write_text(everything.page(documented))
    for name, (heading, objects) in API.items():
        (STAGE / name).write_text("\n\n".join([heading, *(f"::: {one}" for one in objects)]) + "\n")


def _with_links_to_copies(text: str) -> str:
    """Return a page of docs/ with links to outside files redirected to their copies."""
    for source, name in OUTSIDE.items():
        text = text.replace(f"]({source}", f"]({name}")
    return text


def with_site_links(text: str, folder: Path) -> str:
    """Return a page from outside docs/ with links that work on the site.

    Links into docs/ lose the folder; other relative links become plain text.
    """

    def replace(found: re.Match[str]) -> str:
        words, target = found.groups()
        if re.match(r"https?:|#", target):
            return found[0]
        path = (folder / target.partition("#")[0]).resolve()
        if path.parent == ROOT / "docs":
            return f"[{words}]({path.name}{target[len(target.partition('#')[0]) :]})"
        return words

    return re.sub(r"\[([^\]]+)\]\(([^)\s]+)\)", replace, text)


def main() -> int:
    """Collect the pages and build the site; return the exit code, which is 1 after a warning."""
    collect_pages()
    shutil.rmtree(ROOT / "site", ignore_errors=True)
    builder = [sys.executable, "-m", "zensical", "build", "--strict", "--clean"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "docs_build")}
    return subprocess.run(builder, cwd=ROOT, env=environment, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
