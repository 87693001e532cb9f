"""Four-legged robots whose legs have passive joints, linkages or springs, as MJCF for tests."""

from collections.abc import Callable
from pathlib import Path

THIGH, SHANK = 0.1, 0.1
CRANK = 0.03
Part = tuple[str, str, str]
"""Bodies, equality constraints and actuators of a leg."""


def rod(x: float, z: float, size: float = 0.008) -> str:
    return f'<geom type="capsule" fromto="0 0 0 {x} 0 {z}" size="{size}"/>'


def ball(x: float, z: float) -> str:
    return f'<geom type="sphere" pos="{x} 0 {z}" size="0.012"/>'


def hinge(name: str, more: str = 'range="-1 1"') -> str:
    return f'<joint name="{name}" axis="0 1 0" damping="0.01" armature="5e-4" {more}/>'


def servo(*joints: str) -> str:
    return "".join(
        f'<position name="{one}" joint="{one}" kp="20" kv="0.3" forcerange="-2 2"/>'
        for one in joints
    )


def five_bar(n: str, x: float, y: float) -> Part:
    """Two driven upper arms whose passive lower arms meet at the foot."""
    sides = (("a", 0.02, 1), ("b", -0.02, -1))
    bodies = "".join(
        f'<body name="{n}_upper_{s}" pos="{x + at} {y} 0">{hinge(f"{n}_{s}")}'
        f"{rod(sign * 0.06, -0.06)}"
        f'<body name="{n}_lower_{s}" pos="{sign * 0.06} 0 -0.06">{hinge(f"{n}_pin_{s}", "")}'
        f"{rod(sign * -0.08, -0.1)}{ball(-0.08, -0.1) if sign > 0 else ''}"
        f'<site name="{n}_end_{s}" pos="{sign * -0.08} 0 -0.1"/></body></body>'
        for s, at, sign in sides
    )
    return bodies, f'<connect site1="{n}_end_a" site2="{n}_end_b"/>', servo(f"{n}_a", f"{n}_b")


def parallelogram(n: str, x: float, y: float) -> Part:
    """A driven thigh, and a driven crank that turns the shank by a rod along the thigh."""
    bodies = (
        f'<body name="{n}_thigh" pos="{x} {y} 0">{hinge(f"{n}_hip")}{rod(0, -THIGH)}'
        f'<body name="{n}_shank" pos="0 0 {-THIGH}">{hinge(f"{n}_knee", "")}{rod(0.03, -SHANK)}'
        f'{ball(0.03, -SHANK)}<site name="{n}_end_a" pos="{-CRANK} 0 0"/></body></body>'
        f'<body name="{n}_crank" pos="{x} {y} 0">{hinge(f"{n}_motor")}{rod(-CRANK, 0, 0.005)}'
        f'<body name="{n}_rod" pos="{-CRANK} 0 0">{hinge(f"{n}_pin", "")}{rod(0, -THIGH, 0.004)}'
        f'<site name="{n}_end_b" pos="0 0 {-THIGH}"/></body></body>'
    )
    joints = servo(f"{n}_hip", f"{n}_motor")
    return bodies, f'<connect site1="{n}_end_a" site2="{n}_end_b"/>', joints


def two_links(n: str, x: float, y: float, knee: str, end: str = "") -> str:
    return (
        f'<body name="{n}_thigh" pos="{x} {y} 0">{hinge(f"{n}_hip")}{rod(0.05, -THIGH)}'
        f'<body name="{n}_shank" pos="0.05 0 {-THIGH}">{knee}{rod(-0.05, -SHANK)}'
        f"{end or ball(-0.05, -SHANK)}</body></body>"
    )


def spring_knee(n: str, x: float, y: float) -> Part:
    """A driven hip, and a passive knee with a spring."""
    knee = hinge(f"{n}_knee", 'stiffness="4" springref="0.1" range="-1 1"')
    return two_links(n, x, y, knee), "", servo(f"{n}_hip")


def toe(n: str, x: float, y: float) -> Part:
    """A driven hip and knee, and a passive toe with a spring."""
    joint = hinge(f"{n}_mtp", 'stiffness="2"')
    end = (
        f'<body name="{n}_toe" pos="-0.05 0 {-SHANK}">{joint}'
        f"{rod(0.02, -0.01)}{ball(0.02, -0.01)}</body>"
    )
    bodies = two_links(n, x, y, hinge(f"{n}_knee"), end)
    return bodies, "", servo(f"{n}_hip", f"{n}_knee")


def mimic(n: str, x: float, y: float) -> Part:
    """A driven hip, and a knee that turns −2 × as far."""
    coupling = f'<joint joint1="{n}_knee" joint2="{n}_hip" polycoef="0 -2 0 0 0"/>'
    return two_links(n, x, y, hinge(f"{n}_knee", "")), coupling, servo(f"{n}_hip")


def pogo(n: str, x: float, y: float) -> Part:
    """A driven hip, and a passive slide with a spring."""
    bodies = (
        f'<body name="{n}_tube" pos="{x} {y} 0">{hinge(f"{n}_hip")}{rod(0, -THIGH)}'
        f'<body name="{n}_rod" pos="0 0 {-THIGH}"><joint name="{n}_slide" type="slide" '
        'axis="0 0 1" stiffness="600" damping="3" range="-0.05 0.05"/>'
        f"{rod(0, -0.06)}{ball(0, -0.06)}</body></body>"
    )
    return bodies, "", servo(f"{n}_hip")


def driven_pogo(n: str, x: float, y: float) -> Part:
    """A driven hip, and a driven slide."""
    bodies, _, hip = pogo(n, x, y)
    bodies = bodies.replace('stiffness="600" damping="3"', 'damping="3" armature="0.05"')
    slide = f'<position joint="{n}_slide" kp="2000" kv="40" forcerange="-60 60"/>'
    return bodies, "", hip + slide


def tendon(n: str, x: float, y: float) -> Part:
    """A driven hip, and a tendon with a motor that bends a knee and an ankle with springs."""
    knee = hinge(f"{n}_knee", 'stiffness="1" range="-1.5 1.5"')
    ankle = hinge(f"{n}_ankle", 'stiffness="2" range="-1.5 1.5"')
    bodies = (
        f'<body name="{n}_thigh" pos="{x} {y} 0">{hinge(f"{n}_hip")}{rod(-0.03, -0.08)}'
        f'<body name="{n}_shank" pos="-0.03 0 -0.08">{knee}{rod(0.04, -0.07)}'
        f'<body name="{n}_foot" pos="0.04 0 -0.07">{ankle}{rod(-0.02, -0.05)}{ball(-0.02, -0.05)}'
        "</body></body></body>"
    )
    flexor = f'<position tendon="{n}_flexor" kp="8e4" kv="800" forcerange="-90 90"/>'
    return bodies, "", servo(f"{n}_hip") + flexor


TENDON = (
    '<fixed name="{0}_flexor"><joint joint="{0}_knee" coef="0.02"/>'
    '<joint joint="{0}_ankle" coef="-0.01"/></fixed>'
)


def linear_actuator(n: str, x: float, y: float) -> Part:
    """A driven hip, and a knee that a cylinder between thigh and shank bends."""
    bodies = (
        f'<body name="{n}_thigh" pos="{x - 0.05} {y} 0">{hinge(f"{n}_hip")}{rod(0, -THIGH)}'
        f'<body name="{n}_shank" pos="0 0 {-THIGH}">{hinge(f"{n}_knee", "")}{rod(0.06, -SHANK)}'
        f'{ball(0.06, -SHANK)}<site name="{n}_end_a" pos="-0.05 0 -0.01"/></body>'
        f'<body name="{n}_tube" pos="0 0 -0.03">{hinge(f"{n}_pin", "")}{rod(-0.025, -0.04, 0.005)}'
        f'<body name="{n}_piston"><joint name="{n}_slide" type="slide" axis="-0.05 0 -0.08" '
        'range="-0.02 0.02" damping="3" armature="0.05"/>'
        f'<geom size="0.006" pos="-0.05 0 -0.08"/><site name="{n}_end_b" pos="-0.05 0 -0.08"/>'
        "</body></body></body>"
    )
    slide = f'<position joint="{n}_slide" kp="8000" kv="80" forcerange="-100 100"/>'
    closure = f'<connect site1="{n}_end_a" site2="{n}_end_b"/>'
    return bodies, closure, servo(f"{n}_hip") + slide


MECHANISMS: dict[str, Callable[[str, float, float], Part]] = {
    one.__name__: one for one in (
        five_bar, parallelogram, spring_knee, toe, mimic, pogo, driven_pogo, tendon,
        linear_actuator,
    )
}  # fmt: skip


def mechanism(
    name: str | Callable[[str, float, float], Part], folder: Path, more: str = ""
) -> Path:
    """Write a robot with four legs of a kind, and return its file."""
    places = {"FL": (0.12, 0.08), "FR": (0.12, -0.08), "RL": (-0.12, 0.08), "RR": (-0.12, -0.08)}
    create = MECHANISMS[name] if isinstance(name, str) else name
    name = create.__name__
    parts = [create(leg, *place) for leg, place in places.items()]
    bodies, equalities, actuators = ("".join(kind) for kind in zip(*parts, strict=True))
    path = folder / f"{name}.xml"
    path.write_text(
        f'<mujoco model="{name}"><compiler angle="radian"/><default>'
        '<geom density="500" contype="2" conaffinity="0"/></default><worldbody><body name="trunk" '
        'pos="0 0 0.3"><freejoint/><geom type="box" size="0.15 0.06 0.02"/>'
        f"{bodies}{more}</body></worldbody><equality>{equalities}</equality>"
        f"<tendon>{''.join(map(TENDON.format, places)) if name == 'tendon' else ''}</tendon>"
        f"<actuator>{actuators}</actuator></mujoco>"
    )
    return path
