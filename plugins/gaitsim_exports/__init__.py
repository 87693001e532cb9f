"""Joint angles and motions for MATLAB, NumPy, pandas and spreadsheets; glTF; TensorBoard."""

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from gaitsim.plugin import Exported, Exporter, Subject, option

if TYPE_CHECKING:
    from gaitsim.plugin import Input
    from gaitsim.plugin.runs import Individual


class GaitExporter(Exporter):
    """The joint angles of a gait."""

    group: ClassVar[str] = "Joint angles"

    def check(self, individual: "Individual") -> None:
        """Check that the body has joint angles."""
        from gaitsim.plugin.gait import gait_of

        gait_of(individual)

    def write(self, subject: Subject, path: Path) -> Exported:
        """Write the file."""
        from gaitsim.plugin.gait import gait_of, write_gait

        gait = gait_of(subject.individual)
        write_gait(gait, path, self.suffix[1:])
        size = "{} frames × {} joints".format(*gait.angles.shape)
        return Exported(f"{size} at {gait.frame_rate:g} Hz, {gait.units}")


class Mat(GaitExporter):
    """The joint angles of a gait, for MATLAB and Octave."""

    title: ClassVar[str] = "Gait file for MATLAB"
    note: ClassVar[str] = "MATLAB, Octave"
    suffix: ClassVar[str] = ".mat"


class Csv(GaitExporter):
    """The joint angles of a gait, as a table."""

    title: ClassVar[str] = "Gait file as CSV"
    suffix: ClassVar[str] = ".csv"


class Npz(GaitExporter):
    """The joint angles of a gait, for NumPy."""

    title: ClassVar[str] = "Gait file for NumPy"
    note: ClassVar[str] = "NumPy"
    suffix: ClassVar[str] = ".npz"


class MotionTable(Exporter):
    """All channels of the motion with units, as a table or as arrays.

    A file .csv or .parquet has a row for each frame and a column for each entry of a channel, such
    as `feet L1 x (m)`. A file .npz has an array for each channel, (individuals, …), and their axes
    and units as JSON in `about`. Parquet needs the package pyarrow.
    """

    title: ClassVar[str] = "Motion as a table"
    group: ClassVar[str] = "The body in motion"
    note: ClassVar[str] = "all channels; .npz, .csv or .parquet"
    input: ClassVar["Input"] = "individuals"
    suffix: ClassVar[str] = ".npz"
    other_suffixes: ClassVar[tuple[str, ...]] = (".csv", ".parquet")
    stem: ClassVar[str] = "motion"
    items: ClassVar[str] = "individuals"

    every: int | None = option(
        None,
        "export the best individual of every N-th generation; 1 for all generations",
        ge=1,
        placeholder="N",
        unset="the chosen individuals",
    )
    population: str | None = option(
        None,
        "export all individuals of these generations: 'last', a list such as 10,20, or 'every 10'",
        allowed="'last', numbers separated by commas, or 'every N'",
        placeholder="last|N,N,…|every N",
        unset="the chosen individuals",
    )

    def write(self, subject: Subject, path: Path) -> Exported:
        """Write the file."""
        from gaitsim_exports.motion import write_motion

        return Exported(write_motion(subject, path, self.every, self.population))


class Glb(Exporter):
    """The body in motion as glTF, for Blender and others."""

    title: ClassVar[str] = "glTF for Blender"
    group: ClassVar[str] = "The body in motion"
    note: ClassVar[str] = "glTF for Blender and others"
    suffix: ClassVar[str] = ".glb"
    stem: ClassVar[str] = "body"

    def check(self, individual: "Individual") -> None:
        """Check that the body can be drawn."""
        from gaitsim.plugin.pictures import clip_of

        clip_of(individual)

    def write(self, subject: Subject, path: Path) -> Exported:
        """Write the file."""
        from gaitsim_exports.gltf.glb import write_glb

        write_glb(subject.individual, path)
        skeleton = subject.individual.skeleton
        frames, rate = len(skeleton.segments), skeleton.frame_rate
        return Exported(f"animated glTF 2.0 of {frames:,} frames at {rate:g} Hz")


class Tensorboard(Exporter):
    """Event files for TensorBoard."""

    title: ClassVar[str] = "Events for TensorBoard"
    group: ClassVar[str] = "The whole run"
    input: ClassVar["Input"] = "run"
    suffix: ClassVar[str] = ""
    stem: ClassVar[str] = "tensorboard"
    items: ClassVar[str] = "generations"

    def check(self, individual: "Individual") -> None:
        """Check that the package tensorboardX is installed."""
        from gaitsim_exports.tensorboard import check_installed

        check_installed()

    def write(self, subject: Subject, path: Path) -> Exported:
        """Write the event files to a folder."""
        from gaitsim_exports.tensorboard import write_events

        run = subject.whole_run
        subject.begin(run.generation)
        notices = write_events(run, path, subject.advance)
        show = f"tensorboard --logdir {shlex.quote(str(path))}"
        return Exported(f"{run.generation:,} generations; to view them: {show}", notices)
