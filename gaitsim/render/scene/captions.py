"""Captions of a scene: time, distance and altitude."""

import numpy as np

from gaitsim.render.scene.clip import Clip, Pose

SMALL = 0.25  # metres; distances of smaller bodies are in centimetres


def format_time(seconds: float) -> str:
    """Format a time."""
    return f"{seconds:.2f} s"


def format_moment(clip: Clip, pose: Pose, seconds: float) -> str:
    """Format time, distance and a flying body's altitude, at constant width; '' for a still."""
    if not clip.seconds:
        return ""
    away = float(np.hypot(*(pose.middle - clip.path[0])[:2]))
    return _join(clip, min(seconds, clip.seconds), away, float(pose.middle[2]) + clip.floor)


def widest_moment(clip: Clip) -> str:
    """Return a string about as wide as the widest result of `format_moment`."""
    away = float(np.hypot(*(clip.path - clip.path[0])[:, :2].T).max())
    altitude = clip.path[:, 2] + clip.floor
    return _join(clip, clip.seconds, away, float(altitude[np.abs(altitude).argmax()]))


def format_progress(clip: Clip, pose: Pose, seconds: float) -> str:
    """Format the distance or altitude of one of several bodies, and when its motion ended."""
    away = float(np.hypot(*(pose.middle - clip.path[0])[:2]))
    altitude = float(pose.middle[2]) + clip.floor
    text = (
        f"altitude {format_length(clip, altitude)}"
        if clip.flies
        else f"distance {format_length(clip, away)}"
    )
    return text + (f", ended at {clip.seconds:.2f} s" if seconds > clip.seconds + 1e-6 else "")


def format_length(clip: Clip, metres: float) -> str:
    """Format a length at the scale of a body."""
    # All digits have the same width, so a constant unit keeps the text from jumping.
    small = clip.anatomy.span < SMALL
    return (f"{100 * metres:.1f} cm" if small else f"{metres:.2f} m").replace("-", "−")


def _join(clip: Clip, seconds: float, away: float, altitude: float) -> str:
    words = [format_time(seconds), f"distance {format_length(clip, away)}"]
    return "   ".join(
        [*words, f"altitude {format_length(clip, altitude)}"][: 3 if clip.flies else 2]
    )
