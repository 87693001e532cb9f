"""A client of PyBullet, and silence while its C++ prints."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock
from types import ModuleType
from typing import Any

from gaitsim_robot.errors import RobotError

_redirecting = Lock()  # the streams are those of the process


class Client:
    """A world of its own; an attribute is PyBullet's function in this world, or a constant."""

    def __init__(self, module: ModuleType) -> None:
        self._module = module
        self._number = module.connect(module.DIRECT)

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._module, name)
        if not callable(found):
            return found

        def call(*values: Any, **options: Any) -> Any:
            return found(*values, physicsClientId=self._number, **options)

        setattr(self, name, call)  # the next use is quicker
        return call


@contextmanager
def connected(dt: float) -> Iterator[Client]:
    """Yield an empty world with this step, s, and end it.

    Raises:
        RobotError: PyBullet is not installed.
    """
    client = Client(imported())
    try:
        with _silent(1):  # it prints the solver's name
            client.setPhysicsEngineParameter(
                fixedTimeStep=dt,
                # Rotors weigh a hundred times as much as shanks: iterations from row to row need
                # hundreds of rounds. Dantzig's elimination is exact, and quicker.
                constraintSolverType=client.CONSTRAINT_SOLVER_LCP_DANTZIG,
                deterministicOverlappingPairs=1,
            )
        yield client
    finally:
        client.disconnect()


def imported() -> ModuleType:
    """Return PyBullet.

    Raises:
        RobotError: it is not installed.
    """
    try:
        with _silent(2):  # it prints when it was built
            import pybullet
    except ImportError:
        raise RobotError(
            "PyBullet is not installed",
            key="engine",
            allowed="mujoco without it",
            remedy="pip install 'gaitsim[bullet]' (it has wheels for Python 3.11)",
        ) from None
    module: ModuleType = pybullet
    return module


@contextmanager
def _silent(stream: int) -> Iterator[None]:
    """Send a stream of the process, 1 or 2, to nowhere for a moment."""
    with _redirecting:
        kept, nowhere = os.dup(stream), os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream)
        try:
            yield
        finally:
            os.dup2(kept, stream)
            os.close(kept)
            os.close(nowhere)
