"""The options of `gaitsim imitate`, declared like those of other products."""

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
        TrainingPreset, Field(description="As published, or tuned for a gait that lasts.")
    ] = "source"
    activation: Annotated[
        Activation | None, Field(description="Activation of the hidden layer.")
    ] = None
    output: Annotated[OutputActivation | None, Field(description="Activation of the outputs.")] = (
        None
    )
    hidden: Annotated[int | None, Field(ge=1, le=4096, description="Number of hidden neurons.")] = (
        None
    )
    epochs: Annotated[
        int | None, Field(ge=1, le=1_000_000, description="Passes over the data.")
    ] = None
    learning_rate: Annotated[float | None, Field(ge=1e-9, le=10, description="Learning rate.")] = (
        None
    )
    seed: Annotated[int, Field(ge=0, description="Seed of weights, order and noise.")] = 0
    compare_activations: Annotated[
        bool, Field(description="Train with all four and plot their errors.")
    ] = False
    video: Annotated[
        bool,
        Field(description="Also make a video: the error, then the imitator beside its expert."),
    ] = False
    format: Annotated[GaitFormat, Field(description="Format of the imitator's gait file.")] = "mat"
    gait: Annotated[
        str | None,
        Field(description="Gait file to learn instead of the champion: .mat, .npz or .csv."),
    ] = None

    def subject(self, run: Path) -> Path:
        """Return the gait file if one is given, else the run."""
        return Path(self.gait) if self.gait else run

    def words(self, run: Path) -> list[str]:
        """Return the options; with a gait file, also the run for the body and the output."""
        if not self.gait:
            return self._flags()
        return [*self._flags("gait"), "--body", str(run), "--out", str(run / EXPORTS)]
