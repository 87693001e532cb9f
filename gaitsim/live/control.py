"""A run on disk that is evolved in the background."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gaitsim.errors import GaitsimError
from gaitsim.live import background
from gaitsim.runs.background import last_failure
from gaitsim.runs.overview import State, overview


class BackgroundControls:
    """A run on disk, with the methods that evolve it in the background.

    Attributes:
        path: its folder.
    """

    path: Path

    @property
    def state(self) -> State | None:
        """What `gaitsim runs` says of it, such as `running` or `queued`; None where it is gone."""
        found = overview(self.path)
        return found.state if found else None

    @property
    def failure(self) -> GaitsimError | None:
        """Why its last process in the background failed; None where it did not."""
        return last_failure(self.path)

    def detach(
        self,
        generations: int | None = None,
        *,
        set: Mapping[str, Any] | None = None,
        workers: int | None = None,
    ) -> None:
        """Continue the run in the background, in a process that outlives this one.

        Args:
            generations: the last generation to evolve, counted from the first one; None as planned.
            set: options from here on, by key; those that matter begin a stage.
            workers: number of parallel workers; None for what suits the body.

        Raises:
            ExperimentError: the options have problems.
            GaitsimError: the run is evolved already, or cannot be evolved in the background.
        """
        background.check_detached(self.path, set, generations)
        background.start_detached(
            self.path, overrides=set, generations=generations, workers=workers
        )

    def stop(self, timeout: float | None = None) -> bool:
        """Stop it in the background after its current generation, saved.

        Args:
            timeout: seconds to wait for it; None without a limit.

        Returns:
            whether it has stopped.

        Raises:
            RunError: it does not evolve in the background.
        """
        return background.stop(self.path, timeout)
