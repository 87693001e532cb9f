"""Small robots as text, written for tests."""

import math

HEAD = '<mujoco model="test"><compiler angle="radian"/><worldbody><body name="trunk"><freejoint/>'
FOOT = "</body></worldbody></mujoco>"


def box(length: float, width: float, height: float, mass: float) -> str:
    """Return a box for a trunk."""
    sizes = f"{length / 2} {width / 2} {height / 2}"
    return f'<geom type="box" size="{sizes}" mass="{mass}"/>'


def leg(name: str, x: float, y: float, *, knee: str = "-2.5 0", turn: float = 0.0) -> str:
    """Return a leg with roll, pitch and knee that hangs straight down, 0.4 m long."""
    return (
        f'<body name="{name}_hip" pos="{x} {y} 0" euler="0 0 {turn}">'
        f'<joint name="{name}_roll" axis="1 0 0" range="-0.8 0.8"/>'
        '<inertial pos="0 0 0" mass="0.1" diaginertia="1e-4 1e-4 1e-4"/>'
        f'<body name="{name}_thigh"><joint name="{name}_pitch" axis="0 1 0" range="-1.5 1.5"/>'
        '<geom type="capsule" fromto="0 0 0 0 0 -0.2" size="0.015" mass="0.2"/>'
        f'<body name="{name}_shank" pos="0 0 -0.2"><joint name="{name}_knee" axis="0 1 0" '
        f'range="{knee}"/><geom type="capsule" fromto="0 0 0 0 0 -0.18" size="0.01" mass="0.1"/>'
        '<geom type="sphere" pos="0 0 -0.18" size="0.02" mass="0.02"/></body></body></body>'
    )


def spread_leg(name: str, x: float, y: float, heading: float) -> str:
    """Return a leg with coxa, femur and tibia that points in the direction `heading`, rad."""
    return (
        f'<body name="{name}_coxa" pos="{x} {y} 0" euler="0 0 {heading}">'
        f'<joint name="{name}_yaw" axis="0 0 1" range="-0.8 0.8"/>'
        '<geom type="capsule" fromto="0 0 0 0.04 0 0" size="0.01" mass="0.03"/>'
        f'<body name="{name}_femur" pos="0.04 0 0"><joint name="{name}_lift" axis="0 1 0" '
        'range="-1.2 1.2"/><geom type="capsule" fromto="0 0 0 0.08 0 0" size="0.01" mass="0.03"/>'
        f'<body name="{name}_tibia" pos="0.08 0 0"><joint name="{name}_knee" axis="0 1 0" '
        'range="-0.3 2.4"/><geom type="capsule" fromto="0 0 0 0.12 0 0" size="0.008" mass="0.03"/>'
        "</body></body></body>"
    )


def human_leg(name: str, y: float) -> str:
    """Return a leg with six joints and a flat foot, 0.8 m long."""
    return (
        f'<body name="{name}_yaw" pos="0 {y} -0.1"><joint name="{name}_hip_yaw" axis="0 0 1" '
        'range="-0.8 0.8"/><inertial pos="0 0 0" mass="0.5" diaginertia="1e-3 1e-3 1e-3"/>'
        f'<body name="{name}_roll"><joint name="{name}_hip_roll" axis="1 0 0" range="-0.6 0.6"/>'
        '<inertial pos="0 0 0" mass="0.5" diaginertia="1e-3 1e-3 1e-3"/>'
        f'<body name="{name}_thigh"><joint name="{name}_hip_pitch" axis="0 1 0" range="-2 1"/>'
        '<geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.05" mass="3"/>'
        f'<body name="{name}_shank" pos="0 0 -0.4"><joint name="{name}_knee" axis="0 1 0" '
        'range="0 2.4"/><geom type="capsule" fromto="0 0 0 0 0 -0.34" size="0.04" mass="2"/>'
        f'<body name="{name}_ankle" pos="0 0 -0.4"><joint name="{name}_ankle_pitch" axis="0 1 0" '
        'range="-1 1"/><inertial pos="0 0 0" mass="0.2" diaginertia="1e-3 1e-3 1e-3"/>'
        f'<body name="{name}_foot"><joint name="{name}_ankle_roll" axis="1 0 0" range="-0.5 0.5"/>'
        '<geom type="box" pos="0.03 0 -0.05" size="0.11 0.05 0.02" mass="0.8"/>'
        "</body></body></body></body></body></body>"
    )


def biped(gap: float) -> str:
    """Return a robot on two legs of 0.85 m whose shins end `gap` above the soles, m."""
    legs = (
        f'<body name="{name}_thigh" pos="0 {y} -0.1"><joint name="{name}_hip" axis="0 1 0" '
        'range="-1.5 1.5"/><geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.04" mass="2"/>'
        f'<body name="{name}_shin" pos="0 0 -0.4"><joint name="{name}_knee" axis="0 1 0" '
        f'range="0 2.4"/><geom type="capsule" fromto="0 0 0 0 0 {gap - 0.41}" size="0.04" '
        f'mass="1"/><body name="{name}_foot" pos="0 0 -0.4"><joint name="{name}_ankle" '
        'axis="0 1 0" range="-1.2 1.2"/><geom type="box" pos="0.03 0 -0.03" '
        'size="0.11 0.05 0.02" mass="0.5"/></body></body></body>'
        for name, y in (("left", 0.1), ("right", -0.1))
    )
    return robot('<geom type="box" pos="0 0 0.15" size="0.08 0.12 0.25" mass="15"/>', *legs)


def arm(name: str, y: float) -> str:
    """Return an arm with two joints that hangs from a shoulder 0.4 m above the hips."""
    return (
        f'<body name="{name}_upper_arm" pos="0 {y} 0.4"><joint name="{name}_shoulder" '
        'axis="0 1 0" range="-3 3"/><geom type="capsule" fromto="0 0 0 0 0 -0.25" size="0.03" '
        f'mass="1"/><body name="{name}_forearm" pos="0 0 -0.25"><joint name="{name}_elbow" '
        'axis="0 1 0" range="-2.4 0"/><geom type="capsule" fromto="0 0 0 0 0 -0.25" size="0.03" '
        'mass="0.7"/></body></body>'
    )


HEAD_AND_NECK = (
    '<body name="head" pos="0 0 0.45"><joint name="neck" axis="0 1 0" range="-1 1"/>'
    '<geom type="sphere" pos="0 0 0.1" size="0.1" mass="2"/></body>'
)
ARM_ON_BACK = (
    '<body name="turret" pos="0.1 0 0.06"><joint name="turn" axis="0 0 1" range="-3 3"/>'
    '<geom type="sphere" size="0.02" mass="0.1"/><body name="boom"><joint name="raise" '
    'axis="0 1 0" range="-2 2"/><geom type="capsule" fromto="0 0 0 0.4 0 0.1" size="0.01" '
    'mass="0.2"/></body></body>'
)

CORNERS = {"FL": (0.2, 0.1), "FR": (0.2, -0.1), "RL": (-0.2, 0.1), "RR": (-0.2, -0.1)}


def robot(*parts: str) -> str:
    """Return a robot whose trunk has these parts."""
    return HEAD + "".join(parts) + FOOT


QUADRUPED = robot(
    box(0.4, 0.16, 0.1, 4), *(leg(name, x, y) for name, (x, y) in CORNERS.items()), ARM_ON_BACK
)
FACING_Y = robot(
    box(0.16, 0.4, 0.1, 4),
    *(leg(name, -y, x, turn=math.pi / 2) for name, (x, y) in CORNERS.items()),
)
HEXAPOD = robot(
    box(0.2, 0.1, 0.04, 1),
    *(
        spread_leg(f"{side}{row}", x, sign * 0.06, sign * heading)
        for side, sign in (("l", 1), ("r", -1))
        for row, (x, heading) in enumerate(((0.1, 0.8), (0.0, 1.57), (-0.1, 2.34)))
    ),
)
HUMANOID = robot(
    '<geom type="box" pos="0 0 0.15" size="0.08 0.12 0.25" mass="15"/>',
    human_leg("left", 0.1),
    human_leg("right", -0.1),
    arm("left", 0.2),
    arm("right", -0.2),
    HEAD_AND_NECK,
)
ARM = robot(
    '<geom type="cylinder" size="0.1 0.05" mass="5"/>',
    '<body name="turret" pos="0 0 0.1"><joint name="turn" axis="0 0 1" range="-3 3"/>'
    '<geom type="sphere" size="0.05" mass="1"/><body name="boom"><joint name="raise" '
    'axis="0 1 0" range="-3 3"/><geom type="capsule" fromto="0 0 0 0.5 0 0" size="0.03" '
    'mass="1"/></body></body>',
)
WHEELS = robot(
    box(0.4, 0.2, 0.1, 4),
    *(
        f'<body name="wheel_{name}" pos="{x} {y} -0.05" euler="1.5708 0 0"><joint '
        f'name="axle_{name}" axis="0 0 1" range="-3.1416 3.1416"/><geom type="cylinder" '
        'size="0.08 0.02" mass="0.3"/></body>'
        for name, (x, y) in CORNERS.items()
    ),
)


def dog_urdf(*, length: float = 1, mass: float = 1, angle: float = 1, masses: bool = True) -> str:
    """Return a quadruped of 12 kg and 0.4 m in other units.

    Args:
        length: number of units of length in a metre.
        mass: number of units of mass in a kilogram.
        angle: number of units of angles in a radian.
        masses: whether the links state masses.
    """
    inertia = mass * length**2

    def link(name: str, weight: float, moment: float, drop: float, solid: str) -> str:
        moments = " ".join(f'i{axis}="{moment * inertia}"' for axis in ("xx", "yy", "zz"))
        origin = f'<origin xyz="0 0 {-drop * length}"/>'
        inertial = (
            f'<inertial>{origin}<mass value="{weight * mass}"/><inertia {moments} ixy="0" '
            'ixz="0" iyz="0"/></inertial>'
        )
        return (
            f'<link name="{name}">{inertial if masses else ""}<collision>{origin}'
            f"<geometry>{solid}</geometry></collision></link>"
        )

    def rod(radius: float, size: float) -> str:
        return f'<cylinder radius="{radius * length}" length="{size * length}"/>'

    parts = [
        link("trunk", 8, 0.1, 0, f'<box size="{0.4 * length} {0.16 * length} {0.1 * length}"/>')
    ]
    for name, (x, y) in CORNERS.items():
        parts += [
            link(f"{name}_hip", 0.3, 1e-4, 0, f'<sphere radius="{0.02 * length}"/>'),
            link(f"{name}_thigh", 0.5, 2e-3, 0.1, rod(0.015, 0.2)),
            link(f"{name}_shank", 0.2, 6e-4, 0.09, rod(0.01, 0.18)),
        ]
        for joint, parent, child, place, axis, low, high in (
            ("roll", "trunk", f"{name}_hip", (x, y, 0), "1 0 0", -0.8, 0.8),
            ("pitch", f"{name}_hip", f"{name}_thigh", (0, 0, 0), "0 1 0", -1.5, 1.5),
            ("knee", f"{name}_thigh", f"{name}_shank", (0, 0, -0.2), "0 1 0", -2.5, -0.1),
        ):
            origin = " ".join(str(value * length) for value in place)
            parts.append(
                f'<joint name="{name}_{joint}" type="revolute"><parent link="{parent}"/>'
                f'<child link="{child}"/><origin xyz="{origin}"/><axis xyz="{axis}"/>'
                f'<limit lower="{low * angle}" upper="{high * angle}" effort="20" velocity="10"/>'
                "</joint>"
            )
    return f'<robot name="dog">{"".join(parts)}</robot>'
