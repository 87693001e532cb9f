"""Check a plugin with `gaitsim plugins check`, and show the verdict."""

import asyncio
import json
import sys
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from rich.text import Text

from gaitsim.render.terminal.text import visible, visible_lines

COMMAND = ("plugins", "check")


async def check_plugin(kind: str, name: str) -> dict[str, Any]:
    """Return the JSON report of a plugin's check; {'failure': reason} if the check failed.

    Cancelling the coroutine terminates the process, which terminates its children.
    """
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "gaitsim", *COMMAND, name, "--json"),
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
        start_new_session=True,
    )
    try:
        output, errors = await process.communicate()
    finally:
        if process.returncode is None:
            with suppress(ProcessLookupError):
                process.terminate()
            await process.wait()
    for line in output.decode().splitlines():
        report: dict[str, Any] = json.loads(line)
        if report["kind"] == kind:
            return report
    return {
        "failure": errors.decode(errors="replace").strip() or "the check ended without a report"
    }


def verdict_view(report: Mapping[str, Any] | None, colours: Mapping[str, str]) -> Text:
    """Return the verdict and all findings; None stands for a check in progress."""
    if report is None:
        return Text("Checking …", colours["secondary"])
    if "failure" in report:
        return Text(visible_lines(report["failure"]), colours["error"])
    text = Text()
    if report["ok"]:
        text.append("✓ The plugin fulfils its contract", colours["success"])
    else:
        text.append("✗ The plugin breaks its contract", colours["error"])
    rate = report["figures"].get("individuals_per_second")
    if rate:
        number = f"{rate:,.0f}" if rate >= 10 else f"{rate:.2g}"
        text.append(f"  {number} individuals/s", "dim")
    for finding in report["findings"]:
        colour = colours["error" if finding["level"] == "error" else "warning"]
        text.append(f"\n{finding['level']}: {finding['rule']}", f"bold {colour}")
        for key in ("expected", "actual", "fix"):
            if finding[key]:
                text.append(f"\n  {key}: ", "dim")
                text.append(visible(finding[key]))
    return text
