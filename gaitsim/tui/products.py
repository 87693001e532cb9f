"""The products that can be exported from a run: their commands and options.

Options are declared like those of plugins, so the same forms show them.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from pydantic import ValidationError
from pydantic.fields import FieldInfo

from gaitsim.choices import PlotKind
from gaitsim.errors import GaitsimError
from gaitsim.registry import options
from gaitsim.tui.imitation_options import Imitator
from gaitsim.tui.product_options import (
    Analysis,
    Archive,
    Bag,
    BodyFile,
    CalibratedFile,
    Differences,
    Events,
    GaitFile,
    Page,
    Plot,
    RobotFile,
    Servo,
    Settings,
    Template,
    Video,
)

if TYPE_CHECKING:
    from gaitsim.individual import Individual

Check = Callable[["Individual"], object]


@dataclass(frozen=True)
class Product:
    """An export of a run.

    Attributes:
        title: name in a list.
        command: words of the command, without the run.
        model: options of the command.
        kind: kind of plot; '' for other products.
    """

    title: str
    command: tuple[str, ...]
    model: type[Settings]
    kind: str = ""

    def fields(self) -> dict[str, FieldInfo]:
        """Return the options that the command reads, by name."""
        known = self.model.model_fields
        if self.model is not Plot:
            return known
        from gaitsim.render.plots.kinds import ALL_OPTIONS, KINDS

        read = KINDS[self.kind].options if self.kind in KINDS else ALL_OPTIONS
        return {n: f for n, f in known.items() if n in ("theme", "format") or f"--{n}" in read}

    def arguments(self, run: Path, settings: Settings) -> tuple[str, ...]:
        """Return the arguments of `gaitsim`."""
        verb, *more = self.command
        return (verb, str(settings.subject(run)), *more, *settings.arguments(run))

    def read(self, texts: Mapping[str, str]) -> tuple[Settings | None, dict[str, GaitsimError]]:
        """Read typed options; return them, or None and the problems by name."""
        fields = self.fields()
        typed = {name: text.strip() for name, text in texts.items() if name in fields}
        try:
            return self.model.model_validate(
                {name: _value(fields[name], text) for name, text in typed.items()}
            ), {}
        except ValidationError as error:
            names = dict.fromkeys(str(detail["loc"][0]) for detail in error.errors())
        return None, {
            name: GaitsimError(
                f"invalid {name}: {typed.get(name, '')!r}",
                allowed=options.type_and_bounds(fields[name]) if typed.get(name) else "a value",
            )
            for name in names
        }


def default(field: FieldInfo) -> str:
    """Return the text of an option's default."""
    return options.format_value(field, field.get_default())


def _value(field: FieldInfo, text: str) -> Any:
    texts = str in (field.annotation, *get_args(field.annotation))
    return options.convert_value(field, text if texts else options.parse_value(text), text)


PLOTS = {
    "fitness": "Fitness curve",
    "terms": "Terms of the score",
    "diversity": "Diversity",
    "genome": "Best genomes over time",
    "runs": "Comparison of runs",
    "search": "Progress of the search",
    "front": "Pareto front",
    "archive": "Archive map",
    "gaits": "Best gait per pattern",
    "path": "Path in 3D",
    "channel": "Channel of the motion",
    "footfall": "Footfalls",
    "phase": "Phases of the feet",
    "joints": "Joint angles",
    "stability": "Stability margin",
}
GROUPS: dict[str, tuple[Product, ...]] = {
    "Gait": (
        Product("Gait file", ("export",), GaitFile),
        Product("Servo keyframes", ("export", "--format", "servo"), Servo),
        Product("Arduino sketch", ("export", "--format", "arduino"), CalibratedFile),
        Product("Dynamixel positions", ("export", "--format", "dynamixel"), CalibratedFile),
        Product("Feetech positions", ("export", "--format", "feetech"), CalibratedFile),
        Product("ROS 2 trajectory", ("export", "--format", "ros2"), RobotFile),
        Product("ROS 2 bag", ("export", "--format", "rosbag2"), Bag),
        Product("Calibration template", ("export",), Template),
    ),
    "Plot": (
        *(
            Product(PLOTS.get(kind, kind.capitalize()), ("plot", "--kind", kind), Plot, kind)
            for kind in get_args(PlotKind)
        ),
        Product("All plots", ("plot", "--kind", "all"), Plot, "all"),
    ),
    "More": (
        Product("Web page", ("export", "--format", "html"), Page),
        Product("Archive as a web page", ("export", "--format", "atlas"), Archive),
        Product("glTF for Blender", ("export", "--format", "glb"), BodyFile),
        Product("Events for TensorBoard", ("export", "--format", "tensorboard"), Events),
        Product("Video", ("video",), Video),
        Product("Analysis", ("analyse",), Analysis),
        Product("Imitation network", ("imitate",), Imitator),
        Product("Run differences", ("differences",), Differences),
    ),
}
PRODUCTS = tuple(product for products in GROUPS.values() for product in products)


def unavailable_products(run: Path) -> dict[Product, GaitsimError]:
    """Return the products that cannot be exported from a run, with the commands' errors."""
    from gaitsim.gait.gait_files import gait_of
    from gaitsim.hardware.exporting import check_bag
    from gaitsim.imitation.expert import expert_of
    from gaitsim.render.plots.kinds import KINDS
    from gaitsim.render.plots.request import require_kept
    from gaitsim.render.scene.clip import clip_of
    from gaitsim.render.tensorboard import check_installed
    from gaitsim.runs.files.folder import exports_folder
    from gaitsim.runs.snapshot import RunSnapshot

    exports_folder(run)
    champion = RunSnapshot(run).individual()
    checks: Mapping[type[Settings], Check] = {
        GaitFile: gait_of,
        RobotFile: gait_of,
        CalibratedFile: gait_of,
        Servo: gait_of,
        Template: gait_of,
        Bag: check_bag,
        BodyFile: clip_of,
        Events: lambda _: check_installed(),
        Page: clip_of,
        Archive: partial(require_kept, kept="archive"),
        Imitator: expert_of,
    }
    found = {}
    for product in PRODUCTS:
        kind = KINDS.get(product.kind)
        check = kind.check if kind else checks.get(product.model)
        try:
            if check is not None:
                check(champion)
        except GaitsimError as error:
            found[product] = error
    return found
