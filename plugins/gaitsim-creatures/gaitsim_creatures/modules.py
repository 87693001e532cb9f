"""Tables of modules: sizes, masses and servos of core, brick and hinge."""

import math
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from gaitsim.plugin import GaitsimError, nearest, read_regular, toml
from gaitsim.plugin.toolkit import SERVOS, Servo
from gaitsim_creatures.trees import BRICK, CORE, FACES, FRONT, HINGE, Shapes

TABLES = ("revolve2", "robogen", "ariel")
LARGEST_FILE = 100_000  # bytes

Length = Annotated[float, Field(ge=1e-3, le=2.0)]
Mass = Annotated[float, Field(ge=1e-4, le=100.0)]
Size = tuple[Length, Length, Length]
Face = Literal["front", "left", "right", "back", "up", "down"]


class _Table(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Block(_Table):
    """A rigid module: the core or a brick.

    Attributes:
        size: extents, m; x points away from the parent.
        mass: mass, kg.
        faces: faces to which modules can be attached; a brick's back is on its parent.
        drop: distance of the lateral faces' centres below the middle of the core, m.
    """

    size: Size
    mass: Mass
    faces: tuple[Face, ...] = Field(min_length=1)
    drop: float = Field(0.0, ge=0.0, le=1.0)


class Hinge(_Table):
    """A module with a servo, whose arm turns about the axis y between base and arm.

    Attributes:
        base: extents of the part on the parent, m.
        base_mass: its mass, kg.
        arm: extents of the part that turns and carries the next module, m.
        arm_mass: its mass, kg.
        reach: largest angle from the middle, °.
    """

    base: Size
    base_mass: Mass
    arm: Size
    arm_mass: Mass
    reach: float = Field(ge=5.0, le=180.0)


class Motor(_Table):
    """The servo of a hinge; the fields are those of `Servo`, in SI units."""

    stall_torque: float = Field(gt=0.0, le=1e3)
    no_load_speed: float = Field(gt=0.0, le=100.0)
    stiffness: float = Field(gt=0.0, le=1e4)
    damping: float = Field(gt=0.0, le=1e3)
    armature: float = Field(gt=0.0, le=10.0)
    latency: float = Field(0.0, ge=0.0, le=0.2)
    continuous: float = Field(0.0, ge=0.0, le=1.0)


class Modules(_Table):
    """A table of modules, with the source of its facts."""

    source: str = Field(min_length=1, max_length=300)
    core: Block
    brick: Block
    hinge: Hinge
    servo: Motor

    @property
    def shapes(self) -> Shapes:
        """The sizes and faces of the modules."""
        base, arm = self.hinge.base, self.hinge.arm
        hinge = (base[0] + arm[0], max(base[1], arm[1]), max(base[2], arm[2]))
        faces = np.zeros((3, len(FACES)), np.bool_)
        for kind, block in ((CORE, self.core), (BRICK, self.brick)):
            faces[kind, [FACES.index(face) for face in block.faces]] = True
        faces[HINGE, FRONT] = True
        return Shapes(np.array([self.core.size, self.brick.size, hinge]), faces, self.core.drop)

    @property
    def reach(self) -> float:
        """The largest angle of a hinge from its middle, rad."""
        return math.radians(self.hinge.reach)

    def motor(self, name: str) -> Servo:
        """Return the servo of the table, or one with a name."""
        if name != "modules":
            return SERVOS[name]
        return Servo("modules", **self.servo.model_dump(), source=self.source)


def modules_text(value: str, folder: Path | None) -> str:
    """Return the option `modules` as an experiment stores it: the name of a table, or its text.

    Args:
        value: name of a bundled table, text of a table, or the path of its file.
        folder: base of relative paths; None forbids files.

    Raises:
        GaitsimError: there is no such table, or it is invalid.
    """
    if value in TABLES:
        return value
    if "\n" not in value:
        allowed = f"{', '.join(TABLES)}, or the path of a TOML file like them"
        remedy = nearest(value, TABLES)
        if folder is None:
            what = f"there is no bundled table of modules {value[:200]!r}"
            raise GaitsimError(what, allowed=allowed, remedy=remedy)
        try:
            value = read_regular(folder / value, LARGEST_FILE, follow=True).decode()
        except (OSError, ValueError) as error:
            what = f"the table of modules {value[:200]!r} cannot be read: {error}"
            raise GaitsimError(what, allowed=allowed, remedy=remedy) from None
    load_modules(value)
    return value


@lru_cache(maxsize=16)
def load_modules(text: str) -> Modules:
    """Return a table of modules from the stored option.

    Raises:
        GaitsimError: the text is not a table of modules.
    """
    if text in TABLES:
        folder = files("gaitsim_creatures") / "tables"
        text = (folder / f"{text}.toml").read_text(encoding="utf-8")
    try:
        return Modules.model_validate(toml.parse(text, "the table of modules"))
    except ValidationError as error:
        first: Any = error.errors(include_url=False)[0]
        key = ".".join(map(str, first["loc"]))
        problem = first["msg"][:1].lower() + first["msg"][1:]
        raise GaitsimError(
            f"invalid table of modules: {key}: {problem}",
            allowed="the keys of a bundled table, with sizes in m, masses in kg, torque in N m",
            remedy="gaitsim plugins show creature prints where they are",
        ) from None
