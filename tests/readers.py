"""The readers of untrusted bytes: valid content for each, and how to change it.

`tests/test_readers.py` changes the content at random. Where a checksum or compression would refuse
almost every change, a layer changes the bytes or values beneath it.
"""

import asyncio
import io
import json
import os
import shutil
import signal
import struct
import subprocess
import zipfile
import zlib
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import numpy as np
import tomlkit
from mutations import changed_bytes, changed_values
from pydantic import ValidationError
from run_helpers import STUDY, THRESHOLD, continue_run, seal
from scipy.io import savemat
from small_robots import QUADRUPED

from conftest import PUPPET
from gaitsim import toml
from gaitsim.errors import ExperimentError, GaitsimError
from gaitsim.experiment import Typed, load_experiment, parse_assignments, parse_experiment
from gaitsim.gait.gait_files import Gait, read_gait, write_gait
from gaitsim.individual import Individual
from gaitsim.live.protocol import (
    RunCommand,
    Snapshot,
    merge,
    read_command,
    read_snapshot,
    write_command,
    write_snapshot,
)
from gaitsim.network import Network
from gaitsim.sharing import code as codes
from gaitsim.sharing.challenge import Challenge
from gaitsim.storage import background
from gaitsim.storage.compatibility import check_start
from gaitsim.storage.creation import champion_of, create_run
from gaitsim.storage.files import safe_pickle
from gaitsim.storage.files.checkpoint import read_champion
from gaitsim.storage.files.history import read_history, read_islands, read_records
from gaitsim.storage.files.records import RECORD, SAVE
from gaitsim.storage.growing import overview
from gaitsim.storage.lock import RunLock
from gaitsim.storage.manage import read_note, read_tags, write_note, write_tags
from gaitsim.storage.overview import list_overviews
from gaitsim.storage.provenance import read_provenance
from gaitsim.storage.query import parse_query
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.tui.config import check_keys, read_config, remember
from gaitsim_adaptation.record import AdaptationRecord, read_record, write_record
from gaitsim_adaptation.report import _REPORT, AdaptationReport, Case, read_report
from gaitsim_adaptation.settings import AdaptationSettings
from gaitsim_adaptation.trials import Trial
from gaitsim_hardware.calibration import default_calibration
from gaitsim_hardware.calibration_file import format_template, read_calibration
from gaitsim_imitation import load_imitator
from gaitsim_imitation.imitator import Imitation, Imitator, save_imitator
from gaitsim_page.gallery import KIND, RECORD as GALLERY, _own_files
from gaitsim_robot import child
from gaitsim_robot.importing import import_robot
from gaitsim_robot.importing.meshes import MeshError, decode
from gaitsim_robot.loading import bundled_text
from gaitsim_robot.organism import Robot
from gaitsim_serve.server import ServedApp
from gaitsim_studies.file import cells, parse_study, read_study
from gaitsim_studies.results import sections, write_results
from gaitsim_studies.running import CELLS, read_result, run_cells
from gaitsim_wire.identification import read_recording
from gaitsim_wire.trials import _LOG, Log, RobotTrial, read_log

FIXTURES = Path(__file__).parent / "fixtures"


@dataclass(frozen=True)
class Layer:
    """The part of a file that is changed, such as the bytes that a checksum guards.

    Attributes:
        unwrap: returns that part of the valid file.
        change: returns a changed copy, given the part and a generator of random numbers.
        wrap: returns the file with a changed part; a part that does not fit raises an error.
    """

    unwrap: Callable[[bytes], Any] = lambda data: data
    change: Callable[[Any, Any], Any] = changed_bytes
    wrap: Callable[[Any], bytes] = lambda part: part


@dataclass(frozen=True)
class Reader:
    """A reader of untrusted bytes.

    Attributes:
        make: writes a valid file into an empty folder, and returns its path.
        read: reads the file at that path.
        layers: parts of the file that are changed.
        refusals: errors with which the reader may refuse a file.
        found: contents that once broke the reader.
    """

    make: Callable[[Path], Path]
    read: Callable[[Path], object]
    layers: tuple[Layer, ...] = (Layer(),)
    refusals: tuple[type[Exception], ...] = (GaitsimError,)
    found: tuple[bytes, ...] = ()


def changed_attributes(root, chance):
    """Return an XML document in which one to four attributes have hostile values."""
    root = ElementTree.fromstring(ElementTree.tostring(root))
    elements = [element for element in root.iter() if element.attrib]
    for _ in range(chance.randint(1, 4)):
        element = chance.choice(elements)
        element.set(chance.choice(list(element.attrib)), chance.choice(NUMBERS))
    return root


NUMBERS = (
    "nan", "inf", "-1e308", "1e308", "1e-308", "1e30", "1e6", "0", "-1", "", "1e300 0 0 0",
    "1e-300 0 0 0", "nan nan nan", "0 0 0", "1e6 1e6 1e6", "1e-9 1e-9 1e-9", "2147483648",
    "1 2 3 4 5 6 7 8 9", "9" * 400, "x" * 5000, "../../../etc/passwd",
)  # fmt: skip


def changed_words(data, chance):
    """Return bytes in which some 32-bit numbers, such as types and sizes, are changed."""
    changed = bytearray(data)
    for _ in range(chance.choice((1, 1, 2, 5))):
        at = 4 * chance.randrange(len(data) // 4)
        changed[at : at + 4] = struct.pack("<I", chance.choice(WORDS))
    return bytes(changed)


WORDS = (0, 1, 2, 3, 5, 6, 7, 9, 14, 15, 16, 18, 99, 8192, 2**31 - 1, 2**31, 2**32 - 1)


def changed_member(members, chance):
    """Return the members of an archive by name, with one changed."""
    name = chance.choice([*members])
    return members | {name: changed_bytes(members[name], chance)}


def members(data):
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def archive_of(members):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return file.getvalue()


def packed(data):
    """Return a file of MATLAB with each variable compressed, as MATLAB writes it."""
    whole, at = data[:128], 128
    while at + 8 <= len(data):
        size = struct.unpack_from("<I", data, at + 4)[0]
        part = zlib.compress(data[at : at + 8 + size])
        whole += struct.pack("<II", 15, len(part)) + part
        at += 8 + size
    return whole + data[at:]


def load_checkpoint(data):
    return safe_pickle.loads(data, Path("valid"))


BYTES = Layer()
SEALED = Layer(lambda data: data[safe_pickle.HEADER :], wrap=seal)
VALUES = Layer(load_checkpoint, changed_values, safe_pickle.dumps)
CHECKPOINT = (BYTES, SEALED, VALUES)
JSON = (BYTES, Layer(json.loads, changed_values, lambda value: json.dumps(value).encode()))
TOML = (
    BYTES,
    Layer(
        lambda data: toml.parse(data.decode(), "valid"),
        changed_values,
        lambda value: tomlkit.dumps(value).encode(),
    ),
)
XML = (BYTES, Layer(ElementTree.fromstring, changed_attributes, ElementTree.tostring))
NPZ = (BYTES, Layer(members, changed_member, archive_of))
WORDED = Layer(change=changed_words)
PACKED = Layer(change=changed_words, wrap=packed)
CODE = Layer(
    lambda data: codes.decode(data.decode()), wrap=lambda part: codes.encode(part).encode()
)


def written(name: str, content: str | bytes) -> Callable[[Path], Path]:
    """Return a function that writes a file into a folder."""

    def make(folder):
        (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)
        return folder / name

    return make


# Runs


def kept(create: Callable[[Path], object]) -> Callable[[Path], None]:
    """Return a function that copies a folder, which is created only once, into an empty one."""
    made: dict[str, Path] = {}

    def copy(folder):
        if not made:
            made["folder"] = folder.with_name(f"{create.__name__}-kept")
            made["folder"].mkdir()
            create(made["folder"])
        shutil.copytree(made["folder"], folder, dirs_exist_ok=True)

    return copy


def puppet(*overrides):
    return parse_experiment(PUPPET, "puppet.toml", parse_assignments(overrides))


@kept
def run_of_puppets(folder):
    """Evolve three generations on two islands from an individual, with a note, tags and a lock."""
    path = create_run(puppet("islands.number=2"), folder / "first")
    continue_run(path, 1)
    start = champion_of(RunSnapshot(path))
    path = create_run(puppet("islands.number=2", THRESHOLD), folder / "run", start)
    continue_run(path, 3)
    write_note(path, "It drags a leg.")
    write_tags(path, ("slow", "limping"))
    RunLock(path).release()


def of_run(name: str, read: Callable, layers=(BYTES,), make=run_of_puppets, **more) -> Reader:
    """Return the reader of a file in a run; `read` receives the run and the path."""

    def create(folder):
        make(folder)
        return folder / "run" / name

    def read_in_run(path):
        return read(RunSnapshot(path.parents[1] if "/" in name else path.parent), path)

    return Reader(create, read_in_run, layers, **more)


def read_start(run, path):
    check_start(run.experiment, run.start, str(path))


def read_run(run, _):
    """Read what commands show of a run."""
    run.experiment, run.stages, run.history, run.individual()


def read_overview(run, _):
    [found] = [one for one in list_overviews(run.path.parent, overview) if one.name == "run"]
    parse_query("score>0 state:stopped seed<5 tag:x reach>0").matches(found)


def resume(run, _):
    """Resume a copy of a run, which its files control."""
    copy = run.path.with_name("copy")
    shutil.rmtree(copy, ignore_errors=True)
    shutil.copytree(run.path, copy)
    continue_run(copy, 4)


RUNS = {
    "experiment.toml": of_run(
        "experiment.toml", read_run, TOML, found=(b'[search]\nplugin = "x"\n"" = 1.5\n',)
    ),
    "outline": of_run("experiment.toml", lambda run, _: run.outline.search_options(), TOML),
    "history.csv": of_run("history.csv", lambda run, path: read_history(path, 3)),
    "islands.csv": of_run("islands.csv", lambda run, path: read_islands(path, 2, 3)),
    "bests.bin": of_run("bests.bin", read_run),
    "scores.bin": of_run("scores.bin", lambda run, path: run.scores(run.generation)),
    "checksums.bin": of_run("checksums.bin", lambda run, path: read_records(path, RECORD, 3)),
    "saves.bin": of_run("saves.bin", lambda run, path: read_records(path, SAVE)),
    "provenance.json": of_run("provenance.json", lambda run, path: read_provenance(run.path), JSON),
    "population.pickle": of_run("population.pickle", read_run, CHECKPOINT),
    "population.previous.pickle": of_run("population.previous.pickle", read_run, CHECKPOINT),
    "a champion": of_run(
        "champions/generation-000001.pickle", lambda run, path: read_champion(path), CHECKPOINT
    ),
    "start.pickle": of_run("start.pickle", read_start, CHECKPOINT),
    "note.txt": of_run("note.txt", lambda run, _: read_note(run.path)),
    "tags.txt": of_run("tags.txt", lambda run, _: read_tags(run.path)),
    "overview of history.csv": of_run("history.csv", read_overview),
    "overview of experiment.toml": of_run("experiment.toml", read_overview, TOML),
    "overview of population.pickle": of_run("population.pickle", read_overview, CHECKPOINT),
    "resuming saves.bin": of_run("saves.bin", resume),
    "resuming scores.bin": of_run("scores.bin", resume),
    "resuming checksums.bin": of_run("checksums.bin", resume),
    "resuming history.csv": of_run("history.csv", resume),
    "resuming population.pickle": of_run("population.pickle", resume, CHECKPOINT),
}


# Studies


@kept
def studied(folder):
    study = parse_study(STUDY, "small.toml")
    (folder / "study.toml").write_text(STUDY)
    every = cells(study)
    for _ in run_cells(folder, study, every, 1):
        pass
    write_results(folder, study, [(cell, read_result(folder, study, cell)) for cell in every])


def of_study(name: str, read: Callable, layers=(BYTES,)) -> Reader:
    """Return the reader of a file of a study; `name` is a pattern."""

    def create(folder):
        studied(folder)
        return sorted(folder.glob(name))[0]

    return Reader(create, read, layers)


def read_cells(path):
    study, _ = read_study(str(path))
    return cells(study)


def read_cell(path):
    study = parse_study(STUDY, "small.toml")
    for cell in cells(study):
        read_result(path.parents[1], study, cell)


STUDIES = {
    "study.toml": Reader(written("study.toml", STUDY), read_cells, TOML),
    "a cell's result": of_study(f"{CELLS}/*.npy", read_cell),
    "results.csv": of_study("results.csv", lambda path: sections(path.parent)),
    "report.md": of_study("report.md", lambda path: sections(path.parent)),
}


# Gaits and what is exported

NAMES = ("L1 coxa", "naïve, joint", "c")
ANGLES = np.array([[0.0, 0.1, -0.2], [0.05, 0.125, -0.25], [0.1, 1 / 3, 0], [0, 0, 0]])
GAIT = Gait(ANGLES, NAMES, 25.0, 7, 1.5)


def matlab(version, **more):
    file = io.BytesIO()
    # Version 4 has no cells, but a matrix of letters.
    names = np.array(NAMES) if version == "4" else np.array(NAMES, dtype=object)
    values = {"bestGait": ANGLES, "frameRate": 25.0, "jointNames": names, "units": "rad"}
    savemat(file, values | more, format=version)
    return file.getvalue()


def gait_file(format):
    def make(folder):
        write_gait(GAIT, folder / f"gait.{format}", format)
        return folder / f"gait.{format}"

    return make


def recording(folder):
    frames, joints = 800, len(NAMES)
    angles, turned, seconds = np.zeros((frames, joints)), np.zeros((frames, 3)), np.arange(frames)
    columns = {"commanded": angles, "measured": angles, "load": angles}
    columns |= {"orientation": turned, "rates": turned, "round_trip": np.full(frames, 0.004)}
    columns |= {
        "driving": seconds > 100,
        "seconds": seconds / 50,
        "joint_angles": angles,
        "joint_names": np.array(NAMES),
    }
    path = folder / "robot.npz"
    np.savez_compressed(path, frame_rate=50.0, **columns)
    return path


def imitator(folder):
    network = Network(
        (np.ones((4, 3)), np.ones((3, 4))), (np.ones(4), np.ones(3)), "leaky-relu", "linear"
    )
    path = folder / "imitator.npz"
    save_imitator(Imitation(GAIT, ANGLES, Imitator(network, np.zeros(3), 1.0), 3), path)
    return path


def calibration(format):
    file = default_calibration(format, NAMES, np.array([0.0, 0.5, -1.0]))
    return Reader(
        written("robot.toml", format_template(GAIT, file, format)),
        lambda path: read_calibration(path, format, NAMES),
        TOML,
    )


# One changed byte in each of these crashes the process in SciPy's reader (1.17): the type of the
# numbers is 14, 15, 99 or 8192. Two zeros named bestGait, without the header's text.
CRASHERS = tuple(
    b"MATLAB".ljust(124) + b"\0\1IM" + bytes.fromhex(
        "0e000000480000000600000008000000060000000000000005000000080000000200000001000000"
        f"0100000008000000626573744761697{tail}000000000000000000000000000000"
    )[:80]
    for tail in ("40e0000001000000000", "40f0000001000000000", "4630000001000000000",
                 "4002000001000000000")
)  # fmt: skip
GAITS = {
    "MATLAB 5": Reader(
        written("gait.mat", matlab("5")), read_gait, (BYTES, WORDED, PACKED), found=CRASHERS
    ),
    "MATLAB 4": Reader(written("gait.mat", matlab("4")), read_gait, (BYTES, WORDED)),
    "gait.npz": Reader(gait_file("npz"), read_gait, NPZ),
    "gait.csv": Reader(gait_file("csv"), read_gait),
    "recording": Reader(recording, lambda path: read_recording(path, NAMES), NPZ),
    "imitator": Reader(imitator, load_imitator, NPZ),
    "calibration for Arduino": calibration("arduino"),
    "calibration for Dynamixel": calibration("dynamixel"),
}


# Robots


def run_forked(_command, *, input, **_):
    """Replace `subprocess.run` for robots: a fork starts a hundred times as fast."""
    import mujoco  # noqa: F401 (a fork would import it again)

    import gaitsim_robot.importing.convert  # noqa: F401

    source, sink = os.pipe()
    process = os.fork()
    if not process:
        signal.alarm(30)
        with suppress(BaseException):
            os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # Qhull prints its errors
            answer = json.dumps(child._answer(json.loads(input))).encode()
            while answer:
                answer = answer[os.write(sink, answer) :]
        os._exit(0)
    os.close(sink)
    with os.fdopen(source, "rb") as file:
        answer = file.read()
    _, status = os.waitpid(process, 0)
    if os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGALRM:
        raise TimeoutError("reading a robot hangs")
    return SimpleNamespace(stdout=answer, returncode=status)


FORKED = SimpleNamespace(
    run=run_forked, TimeoutExpired=subprocess.TimeoutExpired
)  # in place of the module `subprocess`

DOG = (
    FIXTURES.parents[1]
    / "plugins/gaitsim-robot/tests/fixtures/robots/dog_description/urdf/dog.urdf"
)
URDF = DOG.read_text().replace("package://dog_description/meshes/shank.dae", "foot.obj")
EQUALITY = """<equality><joint joint1="FR_knee" joint2="FL_knee" polycoef="0 1 0 0 0"/>
<connect body1="FR_shank" body2="trunk" anchor="0 0 0" active="false"/></equality>
<actuator><position joint="FL_knee" kp="30" kv="1" gear="1" forcerange="-5 5"/></actuator>"""
MJCF = QUADRUPED.replace("</worldbody>", f"</worldbody>{EQUALITY}")
CORNERS = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1], [0.1, 0.1, 0.1]], "<f4")
OBJ = "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS) + "f 1 2 3\nf 1 2 4\nf 2 3 4\nf 3 4 5\n"
ASCII_STL = "solid a\n" + "".join(
    "facet normal 0 0 1\nouter loop\n"
    + "".join(f"vertex {x} {y} {z}\n" for x, y, z in CORNERS[at : at + 3])
    + "endloop\nendfacet\n"
    for at in range(3)
) + "endsolid a\n"  # fmt: skip
STL = bytes(80) + struct.pack("<I", 3) + b"".join(
    bytes(12) + CORNERS[at : at + 3].tobytes() + b"\0\0" for at in range(3)
)  # fmt: skip
MSH = struct.pack("<4i", 5, 0, 0, 4) + CORNERS.tobytes() + struct.pack(
    "<12i", 0, 1, 2, 0, 1, 3, 1, 2, 3, 2, 3, 4
)  # fmt: skip
DAE = f"""<COLLADA version="1.4.1"><asset><unit meter="1"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="a" count="15">
{" ".join(map(str, CORNERS.ravel()))}</float_array></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices></mesh></geometry>
</library_geometries>
<library_nodes><node id="n"><instance_geometry url="#g"/></node></library_nodes>
<library_visual_scenes><visual_scene><node id="m"><translate>0 0 0</translate>
<rotate>0 0 1 0</rotate><scale>1 1 1</scale><matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix>
<instance_node url="#n"/></node></visual_scene></library_visual_scenes></COLLADA>"""


def robot(folder, text, suffix):
    (folder / "foot.obj").write_text(OBJ)
    (folder / f"robot{suffix}").write_text(text)
    return folder / f"robot{suffix}"


def validate_robot(path):
    """Validate the text of a robot; errors of pydantic must be caused by errors of gaitsim."""
    text = path.read_bytes().decode(errors="replace")
    try:
        Robot.model_validate({"model": text}).describe()
    except ValidationError as error:
        raise error.errors()[0]["ctx"]["error"] from None


def read_mesh(path):
    """Read a mesh as part of a URDF, or of an MJCF for MuJoCo's own formats."""
    with suppress(MeshError):
        if path.suffix != ".msh":
            decode(path.read_bytes(), path.suffix)
    import_robot(next(path.parent.glob("robot.*")))


def mesh(name, content, layers=(BYTES,), *, urdf=False):
    def make(folder):
        if urdf:
            robot(folder, URDF.replace("foot.obj", name), ".urdf")
        else:
            text = MJCF.replace(
                "<worldbody>", f'<asset><mesh name="m" file="{name}"/></asset><worldbody>'
            ).replace('<geom type="sphere"', '<geom type="mesh" mesh="m"', 1)
            robot(folder, text, ".xml")
        return written(name, content)(folder)

    return Reader(make, read_mesh, layers)


ROBOTS = {
    "URDF": Reader(lambda folder: robot(folder, URDF, ".urdf"), import_robot, XML),
    "MJCF": Reader(lambda folder: robot(folder, MJCF, ".xml"), import_robot, XML),
    "a robot's text": Reader(
        written("robot.txt", bundled_text("quadruped")),
        validate_robot,
        XML,
    ),
    "OBJ": mesh("mesh.obj", OBJ),
    "STL": mesh("mesh.stl", STL, (BYTES, WORDED)),
    "STL as text": mesh("mesh.stl", ASCII_STL, urdf=True),
    "MSH": mesh("mesh.msh", MSH, (BYTES, WORDED)),
    "COLLADA": mesh("mesh.dae", DAE, XML, urdf=True),
}


# Codes, adaptations, drives


def a_code(folder):
    experiment = load_experiment("millipede")
    genome = experiment.space().random(1, np.random.default_rng(4))[0]
    challenge = Challenge.of(Individual(experiment, 0.1, {}, 7, genome))
    return written("code.txt", challenge.code)(folder)


def read_code(path):
    text = path.read_bytes().decode(errors="replace")
    challenge = Challenge.read(text)
    assert np.isfinite(challenge.individual.score)
    assert challenge.made_with.isprintable()


TRIALS = (Trial(1, 4, 1.0, 0.9, (0.1,)), Trial(2, 1, 0.3, 0.5, (0.2, 0.3), "fell"))
ADAPTATION = AdaptationRecord(
    "0" * 64, "simulation", ("L2 lost",), "forward", AdaptationSettings(), TRIALS
)
REPORT = AdaptationReport(
    "0" * 64, "simulation", "forward", "m", AdaptationSettings(), {1: 0.5, 4: 0.25},
    (Case(("L1 lost",), TRIALS, (0.1, 0.2)),),
)  # fmt: skip


def adaptation(folder):
    write_record(folder / "adaptation.json", ADAPTATION)
    return folder / "adaptation.json"


ON_ROBOT = Log(
    "gaitsim1-x", 6, 0, 0.05, 0.5,
    (
        RobotTrial((0.5, -1.0), (0.62, 0.6), "walked", "62cm 60cm", 0.1),
        RobotTrial((0.4, 1e-300), (0.3,), "fell", "fell 0.3"),
    ),
)  # fmt: skip

DRIVE = [{"at": 0.0, "speed": 0.3}, {"at": 1.0, "turn": 20.0, "push": 1.0, "direction": 90.0}]


def driven(folder):
    experiment = load_experiment("quadruped", {"organism.drive": DRIVE})
    return written("drive.toml", experiment.to_toml())(folder)


SHARED = {
    "a challenge code": Reader(a_code, read_code, (BYTES, CODE)),
    "an adaptation": Reader(adaptation, read_record, JSON),
    "a report on adaptations": Reader(
        written("report.json", _REPORT.dump_json(REPORT)),
        lambda path: read_report(path, 5),
        JSON,
    ),
    "a search on a robot": Reader(
        written("trials.json", _LOG.dump_json(ON_ROBOT)), read_log, JSON
    ),
    "a drive": Reader(driven, lambda path: load_experiment(str(path)), TOML),
}  # fmt: skip


# Files of the user, and of other processes


def read_settings(path):
    """Read the settings, and remember a theme in them."""
    check_keys(read_config(path))
    remember(path, "theme", "dracula")
    assert read_config(path).theme == "dracula"


CONFIG = '[tui]\ntheme = "nord"\nnotify = true\n[keys]\nhome.delete = "x" # mine\n'


def runtime(kind, **content):
    """Return the reader of a file of a background process, whose run is the folder `run`."""

    def make(folder):
        folder.chmod(0o700)
        run = folder / "run"
        run.mkdir()
        os.environ[background.VARIABLE] = str(folder)
        values = {"run": str(run), "identity": background.identity(run), **content}
        return written(background.runtime_file(run, kind).name, json.dumps(values))(folder)

    def read(path):
        run = path.parent / "run"
        background.background_process(run), background.background_processes()
        found = background.last_failure(run)
        assert found is None or str(found)

    return Reader(make, read, JSON)


FILES = {
    "config.toml": Reader(written("config.toml", CONFIG), read_settings, TOML),
    "gallery.json": Reader(
        written(GALLERY, json.dumps({"kind": KIND, "files": ["pages/a.html"], "runs": []})),
        lambda path: _own_files(path.parent),
        JSON,
    ),
    "a background process": runtime(
        background.STATUS, state="running", pid=os.getpid(), started=1.5
    ),
    "a background failure": runtime(
        background.FAILURE, error=ExperimentError([GaitsimError("x", where="y")]).to_dict()
    ),
}


# What crosses a socket or a pipe

SNAPSHOT = {
    "state": "paused",
    "generation": 5,
    "generations": 9,
    "rows": {"generation": [4, 5], "best": [1.5, 2.5]},
    "top": [{"generation": 5, "score": 1.5, "terms": {"reach": 1.5}}],
    "champion": {"generation": 4, "score": 1.5, "genome": [0.1, 1e-300]},
    "events": [{"generation": 4, "kind": "best", "text": "1.5"}],
    "error": GaitsimError("x", where="y").to_dict(),
}


def read_snapshots(path):
    """Read a snapshot, and use it as the terminal UI does."""
    before = read_snapshot(write_snapshot(SNAPSHOT), Snapshot("running"))
    found = read_snapshot(path.read_bytes(), before)
    merge(before, found)


def send_message(path):
    """Send a message of the page to the app."""

    async def send():
        sent = []

        async def take(data):
            sent.append(data)

        app = ServedApp("", None, None, lambda path: "")
        app.remote_write_str = take
        app._stdin = SimpleNamespace(write=sent.append, drain=lambda: asyncio.sleep(0))
        await app.handle_message(path.read_bytes().decode(errors="replace"))

    asyncio.run(send())


def message(*parts):
    return Reader(written("message.json", json.dumps(parts)), send_message, JSON, (ValueError,))


WIRE = {
    "a command": Reader(
        written("line", write_command(RunCommand("set", {"a.b": 1, "c": Typed("[1]")}))),
        lambda path: read_command(path.read_bytes()),
        JSON,
    ),
    "a snapshot": Reader(
        written("line", write_snapshot(SNAPSHOT)),
        read_snapshots,
        JSON,
        (ValueError,),
        found=(
            b"[" * 3000,
            b'{"error": {"what": 1, "where": "", "key": "", "allowed": "", "remedy": ""}}',
        ),
    ),
    "keys from a browser": message("stdin", "é\x1b"),
    "a size from a browser": message("resize", {"width": 80, "height": 24}),
    "a ping from a browser": message("ping", "1"),
}

READERS = RUNS | STUDIES | GAITS | ROBOTS | SHARED | FILES | WIRE
