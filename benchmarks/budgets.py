"""Every budget beside its measurement: python benchmarks/budgets.py

Runs the benchmarks that have budgets, one after the other, and repeats at the end which budgets
were exceeded. The figures depend on the machine: compare ratios, on an idle machine.
"""

import subprocess
import sys
from pathlib import Path

SCRIPTS = "spider", "recording", "startup", "video", "waits"


def main() -> None:
    """Run the benchmarks, and print their budgets."""
    over = []
    for script in SCRIPTS:
        print(f"# {script}.py", flush=True)
        command = [sys.executable, str(Path(__file__).with_name(f"{script}.py"))]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
            for line in process.stdout or ():
                if "budget" in line.lower():
                    print(line, end="", flush=True)
                if "OVER BUDGET" in line:
                    over.append(f"{script}.py: {line}")
        if process.returncode:
            over.append(f"{script}.py failed\n")
    print("\nover budget:" if over else "\nall within budget")
    print("".join(over), end="")


if __name__ == "__main__":
    main()
