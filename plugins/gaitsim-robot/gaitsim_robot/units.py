"""Recognise a robot whose file uses other units than metres and kilograms."""

import math

# Body length, mass and mass / length³ beyond which a robot is suspicious.
LENGTHS = 0.01, 2.5  # m
MASSES = 0.002, 500.0  # kg
DENSITIES = 0.3, 2e4  # kg/m³; osmium has 22,590 kg/m³

# Those of most robots. 53 models in benchmarks/public_robots.py, without those of flies, are 0.1 to
# 1.9 m long and have 0.3 to 127 kg; their density has a median of 107 kg/m³, and is between 26 and
# 450 kg/m³ for 80 % of them.
USUAL_LENGTHS = 0.1, 1.0  # m
USUAL_MASSES = 0.3, 60.0  # kg
USUAL_DENSITY = 107.0  # kg/m³

LENGTH_UNITS = {1.0: "metres", 0.001: "millimetres", 0.01: "centimetres", 0.0254: "inches"}
MASS_UNITS = {1.0: "kilograms", 0.001: "grams"}
TINY = 1e-30  # m and kg; a hostile file may have less, and logarithms need more than 0
UNUSUAL = 0.5  # decades that a unit other than metres or kilograms must make a robot more usual
FAR = 2.0  # decades; a robot that no unit makes more usual than this has no likely units
CLOSE = 0.3  # decades; units that are almost as likely as the most likely ones are named, too


def unit_warning(length: float, mass: float) -> str:
    """Return a warning if the size and mass of a robot are implausible, or ''.

    The warning names the units that would make the robot usual, and the options that convert them.

    Args:
        length: length of the body, m.
        mass: mass, kg.
    """
    length, mass = max(length, TINY), max(mass, TINY)
    implausible = (
        _decades_outside(length, LENGTHS)
        + _decades_outside(mass, MASSES)
        + _decades_outside(mass / length**3, DENSITIES)
    )
    if not implausible:
        return ""
    measured = f"the robot is {length:.4g} m long and has a mass of {mass:.4g} kg"
    scales, mass_scales = likely_units(length, mass)
    hints = [
        f"{quantity} in the file are probably in {' or '.join(units[one] for one in found)}: set "
        f"'organism.{option}' to {' or '.join(f'{one:g}' for one in found)}"
        for quantity, option, units, found in (
            ("lengths", "scale", LENGTH_UNITS, scales),
            ("masses", "mass_scale", MASS_UNITS, mass_scales),
        )
        if 1.0 not in found
    ]
    return f"{measured}; " + (
        ", and ".join(hints)
        or "check its units, which 'organism.scale' and 'organism.mass_scale' convert"
    )


def likely_units(length: float, mass: float) -> tuple[list[float], list[float]]:
    """Return the factors of the most likely units of lengths, and of masses; 1 if none is."""
    costs: dict[tuple[float, float], float] = {}
    for scale in LENGTH_UNITS:
        # Masses that result from volumes scale with the cube of lengths, without a unit of mass.
        for mass_scale, unit in ((1.0, 1.0), (0.001, 0.001), (scale**3, 1.0)):
            if (scale, unit) == (0.0254, 0.001):
                continue  # nobody combines inches with grams
            size, weight = scale * length, mass_scale * mass
            cost = (
                abs(math.log10(weight / size**3 / USUAL_DENSITY))
                + _decades_outside(size, USUAL_LENGTHS)
                + _decades_outside(weight, USUAL_MASSES)
                + UNUSUAL * (scale != 1)
                + UNUSUAL * (unit != 1)
            )
            costs[scale, unit] = min(cost, costs.get((scale, unit), math.inf))
    best = min(costs.values())
    if best > FAR:
        return [1.0], [1.0]
    likely = [units for units, cost in costs.items() if cost <= best + CLOSE]
    scales, mass_scales = ([*dict.fromkeys(column)] for column in zip(*likely, strict=True))
    return scales, mass_scales


def _decades_outside(value: float, bounds: tuple[float, float]) -> float:
    """Return by how many powers of ten a value is outside its bounds; 0 inside."""
    low, high = bounds
    return max(0.0, math.log10(low / value), math.log10(value / high))
