"""Exported C code, compiled and called from Python."""

import ctypes
import shutil
import subprocess

import numpy as np
import pytest

import gaitsim as gs
from gaitsim.experiment import with_overrides
from gaitsim_hardware.c_code import c_code
from gaitsim_robot.feeling import Pilot, Truth

COMPILER = shutil.which("gcc") or shutil.which("clang")
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-pedantic")
INTERVAL = 0.02
ALL = {"heading": {}, "level": {}, "contact": {}, "phase": {}, "network": {}}


def robot(preset="hexapod", reflexes=("heading",), **options):
    """Return a robot with reflexes, and a genome that walks, with random genes of the reflexes."""
    told = {
        "organism.reflexes": {name: {} for name in reflexes},
        "organism.sensors": ["ideal", "load", "joints"],
        **{f"organism.{name}": value for name, value in options.items()},
    }
    organism = with_overrides(gs.load_experiment(preset), told).organism
    genome = next(iter(organism.starts().values())).copy()
    own = organism._encoding.genes
    genome[own:] += np.random.default_rng(1).uniform(-0.5, 0.5, len(genome) - own)
    return organism, genome


class CGait:
    """The gait of a controller, compiled."""

    def __init__(self, code, folder, *flags):
        if COMPILER is None:
            pytest.skip("no C compiler")
        (folder / "gait.h").write_text(code.header)
        (folder / "gait.c").write_text(code.source)
        sized = "const unsigned long gait_size = sizeof(gait_state);"
        (folder / "size.c").write_text(f'#include "gait.h"\n{sized}\n')
        library = folder / "gait.so"
        sources = [str(folder / "gait.c"), str(folder / "size.c")]
        command = [COMPILER, *STRICT, "-O2", *flags, "-shared", "-fPIC", "-o", str(library)]
        done = subprocess.run(
            [*command, *sources, "-lm"], capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
        self._library = ctypes.CDLL(str(library))
        self._step = self._library.gait_step
        self._step.restype = None
        self._step.argtypes = [ctypes.c_void_p, ctypes.c_double, *[ctypes.c_void_p] * 3]
        self.size = ctypes.c_ulong.in_dll(self._library, "gait_size").value
        self.state = ctypes.create_string_buffer(self.size)
        self._library.gait_init(ctypes.byref(self.state))

    def step(self, senses, command, joints):
        """Return the angles; senses as in gait_senses."""
        senses, command = (np.ascontiguousarray(one, np.float64) for one in (senses, command))
        angles = np.empty(joints)
        pointers = [one.ctypes.data for one in (senses, command, angles)]
        self._step(ctypes.addressof(self.state), INTERVAL, *pointers)
        return angles

    @property
    def heading(self):
        """The direction that commands asked for, rad."""
        return np.frombuffer(self.state, np.float64, 5)[4]


def pilot_of(organism, genome):
    """Return the controller of a calibrated robot in Python."""
    return organism.calibrated(genome).pilot(genome[None])


def senses_of(truth):
    """Return the measurements in the order of gait_senses."""
    parts = (truth.orientation, truth.rates, truth.load > 0, truth.load, truth.joints)
    return np.concatenate([np.ravel(part) for part in parts])


def largest_difference(organism, genome, folder, steps, *flags, seed=3):
    """Return the largest difference between angles in C and in Python with random inputs, rad."""
    controller = organism.controller(genome)
    gait = CGait(c_code(controller, "a gait"), folder, *flags)
    pilot, rng = pilot_of(organism, genome), np.random.default_rng(seed)
    legs, joints = len(controller.rhythm.names), len(controller.rhythm.joint_names)
    command, worst, change = np.zeros(4), 0.0, 0
    for frame in range(steps):
        if frame == change:
            # Also beyond the limits, and to stand.
            command = (
                rng.normal(0, 0.8, 4) * controller.rhythm.limits[0] * rng.choice([0, 1, 1, 1], 4)
            )
            command *= rng.random() < 0.85
            change += int(rng.integers(50, 250))
        load = np.maximum(rng.normal(0.1, 0.2, (1, legs)), 0.0)
        truth = Truth(
            rng.normal(0, [[0.1, 0.1, 1.0]]), rng.normal(0, 0.5, (1, 3)), load,
            rng.normal(0, 0.3, (1, joints)),
        )  # fmt: skip
        # A sensor fails for a moment, or for longer than the last valid measurement is used.
        if frame % 500 in range(100, 100 + 12 * (frame // 500 % 3)) or rng.random() < 0.01:
            parts = (truth.orientation, truth.rates, truth.load, truth.joints)
            parts[rng.integers(4)][0, 0] = rng.choice([np.nan, np.inf])
        expected = pilot.step(frame, command[None], truth)[0]
        angles = gait.step(senses_of(truth), command, joints)
        worst = np.maximum(worst, np.abs(angles - expected).max())  # also NaN
    assert abs(gait.heading - pilot.heading[0]) < 1e-9
    return worst


class CPilot(Pilot):
    """A robot's controller whose angles come from C code, `gait`."""

    gait: CGait

    def _measure(self, frame, truth):
        self._felt = super()._measure(frame, truth)
        return self._felt

    def step(self, frame, target, truth):
        """Return the angles of the C code, and keep the record of the one in Python."""
        super().step(frame, target, truth)
        joints = len(self.rhythm.joint_names)
        return self.gait.step(senses_of(Truth(*self._felt)), target[0], joints)[None]
