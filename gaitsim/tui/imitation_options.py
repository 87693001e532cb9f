"""Options of `gaitsim imitate`, declared like those of the other products."""

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
        TrainingPreset,
        Field(
            description="'source': fixed learning rate; 'steady': noisy inputs and a falling rate"
        ),
    ] = "source"
    activation: Annotated[
        Activation | None, Field(description="activation of the hidden layer; none: 'leaky-relu'")
    ] = None
    output: Annotated[
        OutputActivation | None,
        Field(description="activation of the outputs: 'linear', or 'same' as the hidden layer"),
    ] = None
    hidden: Annotated[
        int | None, Field(ge=1, le=4096, description="number of hidden neurons; none: 48")
    ] = None
    epochs: Annotated[
        int | None,
        Field(
            ge=1, le=1_000_000, description="number of epochs; none: 1000, or 3000 with 'steady'"
        ),
    ] = None
    learning_rate: Annotated[
        float | None,
        Field(
            ge=1e-9,
            le=10,
            description="learning rate; none: 0.008, or 0.02 falling to 0 with 'steady'",
        ),
    ] = None
    seed: Annotated[int, Field(ge=0, description="seed of the weights, sample order and noise")] = 0
    compare_activations: Annotated[
        bool, Field(description="whether to train with all four activations and plot their errors")
    ] = False
    video: Annotated[
        bool,
        Field(description="whether to also make a video of the training error and of both gaits"),
    ] = False
    format: Annotated[GaitFormat, Field(description="format of the gait file of the network")] = (
        "mat"
    )
    gait: Annotated[
        str | None,
        Field(description="gait file to imitate instead of the champion: .mat, .npz or .csv"),
    ] = None

    def subject(self, run: Path) -> Path:
        """Return the gait file if one is given, else the run."""
        return Path(self.gait) if self.gait else run

    def arguments(self, run: Path) -> list[str]:
        """Return the options; with a gait file, also the run for the body and the output."""
        if not self.gait:
            return self._flags()
        return [*self._flags("gait"), "--body", str(run), "--out", str(run / EXPORTS)]
