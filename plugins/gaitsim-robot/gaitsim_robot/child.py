"""Process untrusted files in a child process with limits on time and memory.

A file that crashes MuJoCo's C++ compiler, hangs it or exhausts the memory ends only the child, and
the user gets one message.
"""

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any, BinaryIO

from gaitsim.plugin import GaitsimError
from gaitsim_robot.errors import RobotError

SECONDS = 120
MEMORY = 4 * 2**30  # bytes of address space; NumPy, SciPy and MuJoCo reserve about 1 GiB

# `-I` keeps the current folder off the path; the parent sends its own path on stdin.
_START = """\
import json, sys
request = json.loads(sys.stdin.buffer.readline())
sys.path[:] = request["path"]
from gaitsim_robot.child import serve
serve(request)
"""


def run_in_child(task: str, argument: Mapping[str, Any], *, where: str) -> dict[str, Any]:
    """Call a function in a child process and return its result.

    Args:
        task: `module:function` of a function that takes the items of `argument` and returns a
            dictionary.
        argument: keyword arguments, a JSON object.
        where: the file or text, for messages.
    """
    path = [os.path.abspath(entry) for entry in sys.path]  # noqa: PTH100 (the child runs elsewhere)
    request = {"path": path, "task": task, "argument": dict(argument)}
    # One thread, as the memory limit includes the stack and arena of every thread.
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    with tempfile.TemporaryDirectory() as folder:  # MuJoCo writes its log into the current folder
        try:
            done = subprocess.run(
                [sys.executable, "-I", "-c", _START],
                input=json.dumps(request).encode() + b"\n",
                capture_output=True,
                cwd=folder,
                env=environment,
                timeout=SECONDS,
                check=False,
            )
        except subprocess.TimeoutExpired:
            raise _import_error(f"took more than {SECONDS} s", where) from None
    try:
        answer = json.loads(done.stdout)
    except ValueError:
        reason = f"crashed MuJoCo (exit status {done.returncode})"
        raise _import_error(reason, where) from None
    if "error" in answer:
        raise RobotError(**answer["error"])
    if "bug" in answer:
        raise RuntimeError(answer["bug"])
    result: dict[str, Any] = answer["result"]
    return result


def serve(request: Mapping[str, Any]) -> None:
    """Handle one request in the child process, and exit."""
    output = _redirect_output()
    _limit_resources()
    output.write(json.dumps(_answer(request)).encode())
    output.flush()
    os._exit(0)  # a damaged heap may crash the interpreter's shutdown


def _answer(request: Mapping[str, Any]) -> dict[str, Any]:
    module, _, name = request["task"].partition(":")
    try:
        function: Callable[..., dict[str, Any]] = getattr(import_module(module), name)
        return {"result": function(**request["argument"])}
    except GaitsimError as error:
        return {"error": error.to_dict()}
    except MemoryError:
        return {"error": _import_error("needs too much memory", "").to_dict()}
    except Exception:
        import traceback

        return {"bug": traceback.format_exc()}


def _redirect_output() -> BinaryIO:
    """Return a stream for the answer, and discard the output of libraries."""
    answer = os.fdopen(os.dup(1), "wb")
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    return answer


def _limit_resources() -> None:
    try:
        import resource
    except ImportError:  # Windows has only the parent's time limit
        return
    for kind, value in (
        (resource.RLIMIT_AS, MEMORY),
        (resource.RLIMIT_CPU, SECONDS),
        (resource.RLIMIT_CORE, 0),
    ):
        try:
            resource.setrlimit(kind, (value, value))
        except (ValueError, OSError):  # the current limit is lower, or is not supported
            continue


def _import_error(reason: str, where: str) -> RobotError:
    return RobotError(
        f"the robot cannot be imported: reading it {reason}",
        where=where,
        remedy="simplify its meshes, or check the file with a different program",
    )
