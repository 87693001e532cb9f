"""The options of `gaitsim imitate`, declared as those of the other products are."""

from pathlib import Path
from typing import Annotated

from pydantic import Field

from gaitsim.choices import Activation, GaitFormat, OutputActivation, TrainingPreset
from gaitsim.runs.files.folder import EXPORTS
from gaitsim.tui.product_options import Generation, Member, Settings


class Imitator(Settings):
    generation: Generation = None
    member: Member = None
    settings: Annotated[
        TrainingPreset, Field(description="As published, or steadier for a gait that lasts.")
    ] = "source"
    activation: Annotated[Activation | None, Field(description="Of the hidden layer.")] = None
    output: Annotated[OutputActivation | None, Field(description="Of the outputs.")] = None
    hidden: Annotated[int | None, Field(ge=1, le=4096, description="Hidden neurons.")] = None
    epochs: Annotated[int | None, Field(ge=1, le=1_000_000, description="Passes.")] = None
    learning_rate: Annotated[
        float | None, Field(ge=1e-9, le=10, description="Step along the gradient.")
    ] = None
    seed: Annotated[int, Field(ge=0, description="Of weights, order and noise.")] = 0
    compare_activations: Annotated[
        bool, Field(description="Train with all four, and plot their errors.")
    ] = False
    video: Annotated[
        bool, Field(description="A video, too: the error, then the imitator beside its expert.")
    ] = False
    format: Annotated[GaitFormat, Field(description="Of the imitator's gait file.")] = "mat"
    gait: Annotated[
        str | None,
        Field(description="A gait file to learn instead of the champion: .mat, .npz or .csv."),
    ] = None

    def subject(self, run: Path) -> Path:
        """Return the gait file where there is one."""
        return Path(self.gait) if self.gait else run

    def words(self, run: Path) -> list[str]:
        """Return the options; a gait file is of the run's body, and its imitator of the run."""
        if not self.gait:
            return self._flags()
        return [*self._flags("gait"), "--body", str(run), "--out", str(run / EXPORTS)]
