"""The trained controllers that the package includes."""

from dataclasses import dataclass
from functools import cache
from importlib.resources import as_file, files

import numpy as np

from gaitsim.contracts import Genomes


@dataclass(frozen=True, eq=False)
class TrainedNetworks:
    """Trained networks.

    Attributes:
        layers: units of each layer, inputs first.
        genomes: genomes (genes,) by command.
        experiments: experiments that trained the networks, as TOML, by command.
    """

    layers: tuple[int, ...]
    genomes: dict[str, Genomes]
    experiments: dict[str, str]


@cache
def trained_networks() -> TrainedNetworks:
    """Return the networks in `controllers.npz`."""
    with (
        as_file(files("gaitsim_fly") / "controllers.npz") as path,
        np.load(path, allow_pickle=False) as stored,
    ):
        names = stored["commands"].tolist()
        genomes = {name: stored[name] for name in names}
        for genome in genomes.values():
            genome.flags.writeable = False
        experiments = {name: str(stored[f"{name} experiment"]) for name in names}
        return TrainedNetworks(tuple(stored["layers"].tolist()), genomes, experiments)
