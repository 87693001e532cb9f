"""A fresh environment to install packages into, with all that this one has."""

import os
import subprocess
import sys
import sysconfig
import venv
from collections.abc import Sequence
from pathlib import Path

SECONDS = 120


class Environment:
    """A virtual environment that sees this one's packages; nothing is downloaded.

    Args:
        folder: where it is made.
    """

    def __init__(self, folder: Path) -> None:
        venv.create(folder, with_pip=False)
        self.python = folder / "bin" / "python"
        self.site = Path(self._run("-c", "import sysconfig; print(sysconfig.get_path('purelib'))"))
        ours = sysconfig.get_path("purelib")
        # addsitedir, as the packages of this environment may themselves be links.
        (self.site / "ours.pth").write_text(f"import site; site.addsitedir({ours!r})\n")
        for command, module in (("gaitsim", "gaitsim"), ("pytest", "pytest")):
            self._script(command, f'exec {self.python} -m {module} "$@"')
        pip = f"{sys.executable} -m pip --disable-pip-version-check --python {self.python}"
        self._script("pip", f'{pip} "$@" --no-deps --no-build-isolation --quiet')
        self.path = f"{folder / 'bin'}{os.pathsep}{os.environ['PATH']}"

    def _script(self, name: str, line: str) -> None:
        path = self.python.parent / name
        path.write_text(f"#!/bin/sh\n{line}\n")
        path.chmod(0o755)

    def _run(self, *arguments: str) -> str:
        done = subprocess.run(
            [self.python, *arguments], capture_output=True, text=True, check=True, timeout=SECONDS
        )
        return done.stdout.strip()

    def run(
        self, command: Sequence[str | Path] | str, folder: Path, code: int = 0
    ) -> subprocess.CompletedProcess[str]:
        """Run a command, or a text as a shell script, in a folder; its exit code is checked."""
        environment = {
            name: value for name, value in os.environ.items() if name != "PYTHONPATH"
        } | {"PATH": self.path}
        words = ["bash", "-euo", "pipefail", "-c", command] if isinstance(command, str) else command
        done = subprocess.run(
            words,
            cwd=folder,
            env=environment,
            capture_output=True,
            text=True,
            timeout=SECONDS,
            check=False,
        )
        assert done.returncode == code, f"{command}:\n{done.stdout}\n{done.stderr}"
        return done
