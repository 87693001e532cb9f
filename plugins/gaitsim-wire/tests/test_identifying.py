"""Fitting the simulation of a robot to recordings of drives."""

from types import SimpleNamespace

import numpy as np
import pytest
from wires import Wire, quadruped, robot_on

from gaitsim.errors import GaitsimError
from gaitsim.experiment import load_experiment
from gaitsim_wire import driving, identification
from gaitsim_wire.driving import GaitPlayer, SafetyLimits, Session, excitation
from gaitsim_wire.identification import (
    WORLD,
    Identified,
    Parameter,
    RecordingReplay,
    identify,
    read_recording,
    simulations,
)
from gaitsim_wire.identify import fitted
from gaitsim_wire.robots import bus_of, calibration_of, pilot_of

JOINTS = quadruped().organism.joint_names()
TRUE = {"friction": 0.6, "latency": 0.05, "joint_offset": 3.0, "seed": 4}


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """Return the recording of a short excitation of a virtual robot with errors, and its errors."""
    path, robot = tmp_path_factory.mktemp("recorded") / "robot.npz", quadruped().organism
    wire = Wire(robot_on("feetech", **TRUE))
    calibration = calibration_of(robot, "feetech", None)
    bus = bus_of("feetech", wire, 1_000_000, calibration, imu=True)
    bus._clock, bus._sleep = wire.time, wire.sleep
    pilot = pilot_of(robot, next(iter(robot.starts().values())), imu=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(driving, "EXCITED", 1.2)
        walker = GaitPlayer(pilot, imu=True, walk=False, script=excitation())
    session = Session(bus, walker, calibration, SafetyLimits(volts=4.5), wire.time, wire.sleep)
    session.run(lambda status: None)
    session.recording.write(path, JOINTS)
    errors = np.degrees(wire.emulator.body._simulation.offset)
    return SimpleNamespace(path=path, errors=errors, seconds=session.status.seconds)


def changed(path, folder, **arrays):
    """Write a copy of a recording with other arrays, None for none; return its path."""
    with np.load(path) as file:
        found = {**file, **arrays}
    copy = folder / "copy.npz"
    np.savez(copy, **{name: one for name, one in found.items() if one is not None})
    return copy


def test_an_excitation_ends_by_itself(recorded):
    assert 12 < recorded.seconds - 2 * driving.RAMP_TIME < 16


@pytest.mark.parametrize("name", ["latency", "friction", "horns"])
def test_measurements_are_closest_to_a_simulation_of_the_robot_itself(recorded, name):
    replay = RecordingReplay(quadruped().organism, [read_recording(recorded.path, JOINTS)], 1)
    true = np.array([0.6, 1.0, 1.0, 0.05, *recorded.errors])
    other = true.copy()
    part = slice(len(WORLD), None) if name == "horns" else [*WORLD].index(name)
    other[part] = replay.start[part]
    deviations = [np.abs(replay.residuals(one)).mean() for one in (true, other)]
    assert deviations[0] < 0.7 * deviations[1]


class Linear:
    """Measurements that depend linearly on four conditions and three horns, with noise."""

    names = (*WORLD, "one", "two", "three")
    parameters = (Parameter(0.1, 1.0, -9.0, 9.0, 0.0),) * 7
    start = np.zeros(7)

    def __init__(self):
        rng = np.random.default_rng(5)
        self.true = rng.normal(0, 0.3, 7)
        self._slopes = rng.normal(0, 30, (6, 15, 20, 7))
        self._noise = rng.normal(0, 5, (6, 15, 20))

    def residuals(self, values):
        return self._slopes @ (self.true - values) + self._noise


def test_parameters_of_a_linear_robot_are_found_within_their_intervals():
    replay, done = Linear(), []
    found, stopped = identify(replay, 3, lambda: done.append(1))
    assert len(done) == simulations(3, 7)
    assert not stopped
    errors = np.abs(found.values - replay.true)
    assert errors.max() < 0.02
    assert (errors < 3 * found.errors).all()
    assert found.errors.max() < 0.05
    assert found.misfit[1] < found.misfit[0] / 2


def test_an_interrupted_fit_keeps_the_best_so_far():
    replay, done = Linear(), []

    def stop():
        done.append(1)
        if len(done) == simulations(1, 7) + 2:
            raise KeyboardInterrupt

    found, stopped = identify(replay, 5, stop)
    assert stopped
    assert np.abs(found.values - replay.true).max() < 0.1


def test_the_fitted_robot_is_an_experiment():
    robot = quadruped().organism
    names, count = (*WORLD, *JOINTS), len(WORLD) + len(JOINTS)
    values = np.array([0.51234567, 0.9, 1.1, 0.031, *np.arange(12) / 4])
    start = np.zeros(count)
    found = fitted(quadruped(), Identified(names, start, values, np.full(count, 0.01), (2, 1)))
    again = load_experiment_text(found)
    assert again.organism.world == {
        "friction": 0.5123, "servo_torque": 0.9, "servo_stiffness": 1.1, "latency": 0.031,
    }  # fmt: skip
    assert again.worlds.ranges["friction"] == (0.4923, 0.5323)
    assert again.worlds.ranges["joint_offset"] == (0.0, 0.01)
    assert not again.worlds.cases
    np.testing.assert_allclose(
        np.degrees(again.organism.simulation.offset), values[len(WORLD) :], atol=1e-9
    )
    assert again.organism.simulation.latency == 0.031
    genome = next(iter(robot.starts().values()))[None]
    own, other = (one.move(genome)["torso"] for one in (robot, again.organism))
    assert np.abs(own - other).max() > 0.01


def load_experiment_text(experiment):
    """Return an experiment as it is read from its file."""
    from gaitsim.experiment import parse_experiment

    return parse_experiment(experiment.to_toml(), "fitted.toml")


def test_horns_belong_to_joints():
    with pytest.raises(GaitsimError, match="unknown joint 'L9 knee'"):
        load_experiment("quadruped", {"organism.horns": {"L9 knee": 1.0}})
    with pytest.raises(GaitsimError, match="≥ -45 and ≤ 45"):
        load_experiment("quadruped", {"organism.horns": {JOINTS[0]: 50.0}})


def nan(path, name):
    """Return an array of a recording with all values missing."""
    return np.full_like(np.load(path)[name], np.nan)


BAD = {
    "another robot": (
        lambda path: {"joint_names": np.array([f"x{n}" for n in range(12)])},
        'has the joint "x0"',
    ),
    "no drive": (lambda path: {"round_trip": None}, "is not a recording of a drive: .*round_trip"),
    "shape": (lambda path: {"rates": np.zeros((5, 3))}, "is not a recording of a drive: .*rates"),
    "not measured": (lambda path: {"measured": nan(path, "measured")}, "no measured joint angles"),
    "not finite": (lambda path: {"commanded": nan(path, "commanded")}, "are not finite"),
    "impossible": (lambda path: {"load": np.full_like(np.load(path)["load"], 1e9)}, "impossible"),
    "backward": (lambda path: {"seconds": -np.load(path)["seconds"]}, "do not increase"),
    "a gap": (lambda path: {"seconds": 1e9 * np.load(path)["seconds"]}, "do not increase"),
    "fallen": (lambda path: {"orientation": 0 * np.load(path)["orientation"] + 2}, "tips over"),
    "short": (
        lambda path: {"driving": np.arange(len(np.load(path)["driving"])) < 300},
        "has only 6.0 s besides",
    ),
}


@pytest.mark.parametrize("bad", BAD)
def test_recordings_that_cannot_identify_the_robot_are_refused(recorded, tmp_path, bad):
    change, message = BAD[bad]
    path = changed(recorded.path, tmp_path, **change(recorded.path))
    with pytest.raises(GaitsimError, match=message):
        read_recording(path, JOINTS)


def test_other_orders_of_joints_and_lost_frames_are_understood(recorded, tmp_path):
    whole = read_recording(recorded.path, JOINTS)
    with np.load(recorded.path) as file:
        turned = {name: file[name][:, ::-1].copy() for name in ("joint_angles", "commanded")}
        turned |= {name: file[name][:, ::-1].copy() for name in ("measured", "load")}
    turned["measured"][50] = np.nan
    path = changed(recorded.path, tmp_path, joint_names=np.array(JOINTS[::-1]), **turned)
    found = read_recording(path, JOINTS)
    np.testing.assert_array_equal(found.commanded, whole.commanded)
    assert np.abs(found.values["measured"] - whole.values["measured"]).max() < 0.1


def test_the_command_asks_for_one_distance_for_each_recording(recorded, gaitsim):
    def said(*words):
        return gaitsim("robots", "identify", "quadruped", recorded.path, *words, code=2).stderr

    assert "2 distances for 1 recordings" in said("--distance", "1m", "--distance", "2m")
    assert "invalid distance: 'fell 1'" in said("--distance", "fell 1")
    assert "unknown unit" in said("--distance", "3kg")
    assert "no folder" in said("--save", "nowhere/robot.toml")


@pytest.mark.slow
def test_the_command_fits_a_robot_and_saves_it(recorded, gaitsim, tmp_path, monkeypatch):
    monkeypatch.setattr(identification, "WINDOW", 100)
    words = [
        "quadruped",
        recorded.path,
        "--distance",
        "20cm",
        "--rounds",
        "1",
        "--save",
        "own.toml",
    ]
    table = gaitsim("robots", "identify", *words).stdout
    assert "L1 hip roll" in table or JOINTS[0] in table
    assert "The deviation from the measurements fell" in table
    fitted = load_experiment(str(tmp_path / "own.toml"))
    assert abs(fitted.organism.world["latency"] - 0.05) < 0.02
    assert len(fitted.organism.horns) == 12
