"""A client of PyBullet that suppresses the output of its C++ code."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock
from types import ModuleType
from typing import Any

from gaitsim_robot.errors import RobotError

ITERATIONS = 100  # robots walk as far as with 1,000 rounds, to 2 %

_redirecting = Lock()  # all threads of the process share its streams


class Client:
    """A separate world. Its attributes are PyBullet's constants, and functions bound to it."""

    def __init__(self, module: ModuleType) -> None:
        self._module = module
        self._number = module.connect(module.DIRECT)

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._module, name)
        if not callable(found):
            return found

        def call(*values: Any, **options: Any) -> Any:
            return found(*values, physicsClientId=self._number, **options)

        setattr(self, name, call)  # later uses skip __getattr__
        return call


@contextmanager
def open_client(dt: float) -> Iterator[Client]:
    """Yield an empty world with time step `dt`, s, and close it afterwards."""
    client = Client(import_pybullet())
    try:
        with _silent(1):  # PyBullet prints the solver's name
            client.setPhysicsEngineParameter(
                fixedTimeStep=dt,
                # The armature of rotors is about a hundred times the inertia of shanks, so this
                # iterative solver needs many rounds. Dantzig's method needs none, but limits the
                # friction to shares of normal forces that it computes without friction.
                constraintSolverType=client.CONSTRAINT_SOLVER_LCP_SI,
                numSolverIterations=ITERATIONS,
                solverResidualThreshold=0.0,
                enableConeFriction=0,  # see `Ground`
                deterministicOverlappingPairs=1,
            )
        yield client
    finally:
        client.disconnect()


def import_pybullet() -> ModuleType:
    """Import PyBullet, and return its module."""
    try:
        with _silent(2):  # PyBullet prints its build time
            import pybullet
    except ImportError:
        raise RobotError(
            "PyBullet is not installed",
            key="engine",
            allowed="'mujoco', which does not need PyBullet",
            remedy="pip install pybullet (it has wheels for Python 3.11)",
        ) from None
    module: ModuleType = pybullet
    return module


@contextmanager
def _silent(stream: int) -> Iterator[None]:
    """Discard a stream of the process, 1 or 2, within the context."""
    with _redirecting:
        kept, nowhere = os.dup(stream), os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream)
        try:
            yield
        finally:
            os.dup2(kept, stream)
            os.close(kept)
            os.close(nowhere)
