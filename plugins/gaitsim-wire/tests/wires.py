"""Virtual robots for tests: four legs, twelve servos."""

from functools import cache

from gaitsim.experiment import load_experiment
from gaitsim_wire.emulator import Noise
from gaitsim_wire.robots import create_emulator


@cache
def quadruped(**world):
    """Return the experiment of a quadruped in a world."""
    overrides = {"organism.world": dict(world)} if world else {}
    return load_experiment("quadruped", overrides)


def robot_on(bus, *faults, noise=None, imu=True, calibration=None, hung=False, **world):
    """Return a virtual robot on a bus, with the faults that act from the start."""
    noise = noise or Noise()
    emulator = create_emulator(quadruped(**world), bus, calibration, (), noise, imu=imu, hung=hung)
    for fault in faults:
        emulator.inject(fault)
    return emulator


class Wire:
    """The port of a virtual robot, as pyserial's, whose time is that of the bytes on the wire.

    Attributes:
        now: time, s.
    """

    def __init__(self, emulator, baud=1_000_000):
        self.emulator, self._byte = emulator, 10 / baud
        self.now, self._replies = 0.0, bytearray()

    def write(self, data):
        self.now += self._byte * len(data)
        replies = self.emulator.exchange(bytes(data), self.now)
        self.now += self._byte * len(replies)
        self._replies += replies
        return len(data)

    def read(self, size=1):
        found = bytes(self._replies[:size])
        del self._replies[:size]
        return found

    @property
    def in_waiting(self):
        return len(self._replies)

    def reset_input_buffer(self):
        self._replies.clear()

    def time(self):
        return self.now

    def sleep(self, seconds):
        """Let time pass; the robot moves by itself."""
        self.now += seconds
        self._replies += self.emulator.exchange(b"", self.now)

    def flush(self):
        pass

    def close(self):
        pass
