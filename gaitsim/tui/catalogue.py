"""The installed plugins and presets, and the plugins that cannot be loaded."""

import inspect
from collections.abc import Mapping
from dataclasses import dataclass, field

from gaitsim import registry
from gaitsim.contracts import GenomeSpace, Organism, Plugin
from gaitsim.errors import GaitsimError, PluginError
from gaitsim.experiment import Experiment, read_outline
from gaitsim.experiment.combination import compatible
from gaitsim.experiment.model import space_of
from gaitsim.registry import EXPERIMENTS, KINDS, PLUGINS
from gaitsim.registry.loading import read_preset


@dataclass(frozen=True)
class Preset:
    """A preset: its name, a one-line description, and the name of each plugin by kind."""

    name: str
    description: str
    plugins: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Catalogue:
    """The installed plugins and presets.

    Attributes:
        classes: classes of the usable plugins by kind and name.
        failures: reasons why the other plugins cannot be used, by kind and name.
        presets: installed presets.
    """

    classes: Mapping[str, Mapping[str, type[Plugin]]]
    failures: Mapping[tuple[str, str], GaitsimError]
    presets: tuple[Preset, ...]

    def about(self, kind: str, name: str) -> str:
        """Return the documentation of a plugin."""
        return inspect.getdoc(self.classes[kind][name]) or ""

    def failure(self, kind: str, name: str) -> GaitsimError:
        """Return the reason why a plugin cannot be used."""
        known = self.failures.get((kind, name))
        return known or PluginError(f"no installed package has the {kind} {name!r}")

    def preset_of(self, body: str) -> Preset | None:
        """Return a preset of a body, preferably the one with its name."""
        found = [preset for preset in self.presets if preset.plugins.get("organism") == body]
        named = [preset for preset in found if preset.name == body]
        return next(iter([*named, *found]), None)

    def offered(self, body: str, experiment: Experiment | None) -> dict[str, tuple[str, ...]]:
        """Return the plugins of each kind that work with a body.

        Args:
            body: name of the body.
            experiment: experiment with the body's options; None for the default options.
        """
        known = self.classes["organism"].get(body)
        space = self._space(body, experiment)
        channels = known.channels if known and issubclass(known, Organism) else None
        return {
            kind: tuple(
                name
                for name, plugin in self.classes[kind].items()
                if compatible(plugin, channels, space)
            )
            for kind in KINDS
        }

    def _space(self, body: str, experiment: Experiment | None) -> GenomeSpace | None:
        """Return the body's genome space; None if the body fails."""
        try:
            if experiment is not None and experiment.entries["organism"].name == body:
                return experiment.space()
            entry = registry.find("organism", body)
            with registry.plugin_errors(entry, "being created"):
                organism = self.classes["organism"][body]()
            assert isinstance(organism, Organism)
            return space_of(entry, organism)
        except (GaitsimError, KeyError):
            return None


def read_catalogue() -> Catalogue:
    """Read all plugins and presets; imports every plugin, which takes a second the first time."""
    found = {kind: registry.scan(kind) for kind in PLUGINS}
    return Catalogue(
        {kind: classes for kind, (classes, _) in found.items()},
        {(kind, name): error for kind in found for name, error in found[kind][1].items()},
        read_outlines(),
    )


def read_outlines() -> tuple[Preset, ...]:
    """Read the outlines of all presets, without importing plugins."""
    return tuple(map(_preset, registry.entries(EXPERIMENTS)))


def _preset(name: str) -> Preset:
    try:
        outline = read_outline(read_preset(name), f"preset {name}")
    except GaitsimError as error:
        return Preset(name, f"broken: {error.what}")
    return Preset(name, outline.description, outline.plugins)
