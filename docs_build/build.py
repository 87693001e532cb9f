"""Build the documentation site in site/: `python docs_build/build.py`.

Code hosts show the pages in docs/ and plugins/*/docs/ directly, so they stay unchanged. The script
copies them to build/docs, adds generated pages and those from other folders, and adapts the links.
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
PAGES = {
    **{page: page.name for page in sorted(ROOT.glob("docs/*.md"))},
    **{page: page.name for page in sorted(ROOT.glob("plugins/*/docs/*.md"))},
    ROOT / "CHANGELOG.md": "changelog.md",
    ROOT / "CONTRIBUTING.md": "contributing.md",
    ROOT / "benchmarks" / "README.md": "benchmarks.md",
    ROOT / "data" / "SOURCES.md": "sources.md",
    ROOT / "examples" / "gaitsim-gymnasium" / "README.md": "gymnasium.md",
}
"""The pages of the site, by file -> their names there."""

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
            "gaitsim.api.Numbered",
            "gaitsim.gait.GaitAnalysis",
            "gaitsim.storage.verification.Verdict",
            "gaitsim.sharing.challenge.CodeVerdict",
            "gaitsim.sharing.challenge.Challenge",
            "gaitsim_design.creating.design",
            "gaitsim_lineage.lineage.lineage",
            "gaitsim_imitation.imitating.imitate",
            "gaitsim_studies.comparing.compare",
            "gaitsim_studies.comparing.Comparison",
            "gaitsim.experiment.load_experiment",
            "gaitsim_adaptation.atlas.load_atlas",
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
            "gaitsim_testing",
        ],
    ),
}
"""Pages generated from docstrings: file name -> heading and documented objects."""


def collect_pages() -> None:
    """Collect all pages of the site in the folder `STAGE`."""
    shutil.rmtree(STAGE, ignore_errors=True)
    shutil.copytree(ROOT / "docs", STAGE)
    for page, name in PAGES.items():
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


def with_site_links(text: str, folder: Path) -> str:
    """Return a page with links that work on the site, where all pages are in one folder.

    Links to other files become plain text, except those to pictures.

    Args:
        text: the page.
        folder: folder of the page in the repository.
    """
    docs = ROOT / "docs"

    def replace(found: re.Match[str]) -> str:
        words, target = found.groups()
        if re.match(r"https?:|#", target):
            return found[0]
        place, sign, part = target.partition("#")
        path = (folder / place).resolve()
        if path == ROOT / "README.md":
            return f"[{words}](index.md{sign}{part})"
        if path in PAGES:
            return f"[{words}]({PAGES[path]}{sign}{part})"
        return f"[{words}]({path.relative_to(docs)})" if docs in path.parents else words

    return re.sub(r"\[([^\]]*)\]\(([^)\s]+)\)", replace, text)


def main() -> int:
    """Collect the pages and build the site; return the exit code, which is 1 after a warning."""
    collect_pages()
    shutil.rmtree(ROOT / "site", ignore_errors=True)
    builder = [sys.executable, "-m", "zensical", "build", "--strict", "--clean"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "docs_build")}
    return subprocess.run(builder, cwd=ROOT, env=environment, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
