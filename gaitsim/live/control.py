"""Methods of a run on disk that evolve it in the background."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gaitsim.errors import GaitsimError
from gaitsim.live import background
from gaitsim.runs.background import last_failure
from gaitsim.runs.overview import State
from gaitsim.runs.watcher import overview


class BackgroundControls:
    """The methods of a run that evolve it in the background.

    Attributes:
        path: folder of the run.
    """

    path: Path

    @property
    def state(self) -> State | None:
        """The state in `gaitsim runs`, such as `running`; None if the folder does not exist."""
        found = overview(self.path)
        return found.state if found else None

    @property
    def failure(self) -> GaitsimError | None:
        """The error of its last process in the background; None if it did not fail."""
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
            generations: last generation to evolve, counted from 1; None for the number originally
                planned.
            set: options to change, by key. Changing an option that affects the evolution starts a
                new stage.
            workers: number of parallel workers; None for the body's default.

        Raises:
            ExperimentError: the options have problems.
            GaitsimError: the run is already evolving, or cannot be evolved in the background.
        """
        background.check_detached(self.path, set, generations)
        background.start_detached(
            self.path, overrides=set, generations=generations, workers=workers
        )

    def stop(self, timeout: float | None = None) -> bool:
        """Save and stop the run after its current generation.

        Args:
            timeout: maximum seconds to wait; None for no limit.

        Returns:
            Whether the run has stopped.

        Raises:
            RunError: the run is not evolving in the background.
        """
        return background.stop(self.path, timeout)
