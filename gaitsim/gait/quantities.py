"""The travel, slip and stability of a gait as named quantities, in units for display."""

import math

import numpy as np

from gaitsim.gait.report import Footfalls, GaitAnalysis
from gaitsim.individual import Measurement

SCALES = {"°": math.degrees(1), "mm": 1000.0, "%": 100.0}  # from SI units


def quantities(gait: GaitAnalysis) -> dict[str, Measurement]:
    """Return the quantities that `gaitsim analyse` prints, by name; NaN if not defined."""
    travel, feet = gait.travel, gait.footfalls
    rows: list[tuple[str, float | None, str, str]] = [
        ("speed", travel.speed, "m/s", f"displacement over {travel.seconds:.2f} s"),
        ("forward", travel.forward, "m", "displacement along x"),
        ("lateral", travel.lateral, "m", "displacement to the left"),
    ]
    if feet is None:
        rows.append(("climb", travel.climb, "m", "displacement upwards"))
    rows += [
        ("deviation", travel.deviation, "m", "greatest distance from the starting line"),
        ("straightness", travel.straightness, "", "displacement over length of path"),
        ("yaw", travel.yaw, "°", "turn to the left at the end"),
        ("yaw range", travel.yaw_range, "°", "angle between the extreme headings"),
    ]
    if feet is not None:
        rows += [
            ("Froude number", travel.froude, "", "speed² / (g · height of the centre)"),
            ("slip ratio", feet.slip.ratio, "", "slide of standing feet over length of path"),
            ("least margin", feet.margin.min(), "mm", "static stability, minimum over time"),
            (
                "median margin",
                float(np.median(feet.margin)),
                "mm",
                "static stability, median over time",
            ),
            ("unsupported", float(np.mean(feet.margin < 0)), "%", _unsupported(feet)),
        ]
    if travel.joint_travel is not None:
        rows.append(
            ("joint travel", travel.joint_travel, "rad/m", "sum of all joints; not an energy")
        )
    if travel.cost_of_transport is not None:
        cost = travel.cost_of_transport
        rows.append(("cost of transport", cost, "", "work over weight times displacement"))
    if travel.lasted is not None:
        rows.append(("lasted", travel.lasted, "s", "time before a fall, or the whole motion"))
    return {
        name: Measurement(
            math.nan if value is None else float(value) * SCALES.get(unit, 1.0), unit, meaning
        )
        for name, value, unit, meaning in rows
    }


def _unsupported(found: Footfalls) -> str:
    if found.lying > 0:
        return f"by the feet; the trunk lies on the ground {100 * found.lying:.0f} % of the time"
    return "share of the time with the centre outside the support"
