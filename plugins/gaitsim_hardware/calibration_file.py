"""Read calibration files, and report all problems of a file at once."""

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from gaitsim import toml
from gaitsim.errors import ExperimentError, GaitsimError, nearest
from gaitsim.experiment.loading import read_file
from gaitsim.experiment.overrides import Problems, invalid_value
from gaitsim.legged import SERVOS
from gaitsim_hardware.calibration import BUSES, Calibration, Joint

SCHEMA = 1
NOUN = "calibration"
_MAX_NAMES = 4


def read_calibration(path: Path, format: str, joints: Sequence[str]) -> Calibration:
    """Read the calibration of a robot with the given joints.

    Args:
        path: path of the TOML file.
        format: export format, such as 'arduino', which determines the type of servo.
        joints: names of the joints, in the order of the gait.
    """
    template = "the file that --calibration-template writes"
    text = read_file(path, NOUN, template, "write one with --calibration-template")
    problems = Problems(str(path))
    try:
        data = toml.parse(text, str(path))
    except GaitsimError as error:
        raise ExperimentError([error], NOUN) from None
    for key in data:
        if key not in ("schema", "joints"):
            problems.add_unknown_key("", key, ("schema", "joints"))
    if data.get("schema", SCHEMA) != SCHEMA:
        what = invalid_value("schema", toml.literal(data["schema"]))
        problems.report("schema", what, str(SCHEMA))
    given = data.get("joints", {})
    if not isinstance(given, dict):
        problems.report("joints", "'joints' is not a section", '[joints."name"] for each joint')
        given = {}
    found = _joints(given, joints, problems)
    if not problems.found:
        _check_format(found, format, problems)
    if problems.found:
        raise ExperimentError(problems.found[:20], NOUN)
    return Calibration({name: found[name] for name in joints}, str(path), f"in {path}")


def _joints(
    given: Mapping[str, Any], joints: Sequence[str], problems: Problems
) -> dict[str, Joint]:
    extra = [name for name in given if name not in joints]
    missing = [name for name in joints if name not in given]
    if extra:
        problems.report(
            "joints",
            f"the gait does not have the joint{'s' * (len(extra) > 1)} {_list_names(extra)}",
            f"the joints of the gait: {', '.join(joints)}",
            nearest(extra[0], missing),
        )
    if missing:
        problems.report(
            "joints",
            f"{_list_names(missing)} {'is' if len(missing) == 1 else 'are'} missing",
            "all joints of the gait",
            "create a new file with --calibration-template and copy the joints from it",
        )
    found = {}
    for name, section in given.items():
        if name in extra:
            continue
        key = f"joints.{json.dumps(name, ensure_ascii=False)}"
        if not isinstance(section, dict):
            problems.report(key, f"{key} is not a section", f"[{key}], followed by its keys")
            continue
        try:
            found[name] = Joint.model_validate(section)
        except ValidationError as error:
            problems.add_option_errors(key, Joint, section, error)
    return found


def _check_format(found: Mapping[str, Joint], format: str, problems: Problems) -> None:
    """Report missing or duplicate channels and ids, and servos that the format cannot drive."""
    bus = BUSES.get(format)
    if bus is None:
        return
    kind = "channel" if bus == "pwm" else "id"
    taken: dict[tuple[int, int | None], str] = {}
    for name, joint in found.items():
        section = f"joints.{json.dumps(name, ensure_ascii=False)}"
        key = f"{section}.{kind}"
        address = (joint.board, joint.channel) if bus == "pwm" else (0, joint.id)
        if address[1] is None:
            problems.report(key, f"{key} is required for --format {format}")
        elif address in taken:
            board = f" of board {address[0]}" if bus == "pwm" else ""
            problems.report(
                key,
                f"{taken[address]} and {name} have the same {kind} {address[1]}{board}",
                f"a different {kind} for each joint",
            )
        taken.setdefault(address, name)
        servo = joint.model
        if (servo is None and bus != "pwm") or (servo and servo.bus != bus):
            problems.report(
                f"{section}.servo",
                f"--format {format} cannot drive the servo {servo.name}"
                if servo
                else f"--format {format} needs the model of the servo of {name}",
                ", ".join(one.name for one in SERVOS.values() if one.bus == bus),
            )


def _list_names(names: Iterable[str]) -> str:
    found = [toml.literal(name) for name in names]
    more = len(found) - _MAX_NAMES
    return ", ".join(found[:_MAX_NAMES]) + (f" and {more} more" if more > 0 else "")
