"""A calibration in which no two servos are alike."""

from gaitsim_hardware.calibration import Calibration, Joint


def calibrate(names, **limits):
    """A calibration with a different order, direction, offset and pulses for each servo."""
    return Calibration(
        {
            name: Joint(
                board=1 - index // 16,
                channel=(7 * index) % 16,
                direction=-1 if index % 3 else 1,
                offset=float(index - 9),
                pulse=(500 + index, 2500 - 2 * index),
                **limits,
            )
            for index, name in enumerate(names)
        }
    )
