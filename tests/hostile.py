"""Hostile run folders: runs in which a file is replaced by an attack."""

import os
import shutil
import socket
from pathlib import Path

from conftest import PUPPET

HUGE = 3 * 2**30
FILES = (
    "experiment.toml",
    "start.pickle",
    "population.pickle",
    "population.previous.pickle",
    "history.csv",
    "islands.csv",
    "bests.bin",
    "scores.bin",
    "checksums.bin",
    "provenance.json",
    "note.txt",
    ".lock",
    ".lock-owner",
    ".gaitsim-0.partial",
    "champions",
    "champions/generation-000001.pickle",
    "exports",
    "exports/fitness.png",
)


def a_socket(path):
    here = Path.cwd()
    os.chdir(path.parent)  # paths of sockets are limited to about 100 characters
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(path.name)
    os.chdir(here)


def a_device(path):
    try:
        os.mknod(path, 0o666 | 0o020000, os.makedev(1, 5))  # the same device as /dev/zero
    except PermissionError:
        path.symlink_to("/dev/full")


def filled(path, data, length=None):
    with path.open("wb") as file:
        file.write(data)
        if length is not None:
            file.truncate(length)


def mutated(path, data):
    if data:
        data = bytearray(data)
        data[len(data) // 2] ^= 1
    filled(path, bytes(data))


# Attack -> function that replaces a file, given its path, its content and an outside folder.
ATTACKS = {
    "pipe": lambda path, data, outside: os.mkfifo(path),
    "socket": lambda path, data, outside: a_socket(path),
    "device": lambda path, data, outside: a_device(path),
    "link to its copy": lambda path, data, outside: path.symlink_to(outside / path.name),
    "link to a file": lambda path, data, outside: path.symlink_to(outside / "file"),
    "link to a folder": lambda path, data, outside: path.symlink_to(outside),
    "link to nothing": lambda path, data, outside: path.symlink_to(outside / "nothing"),
    "endless": lambda path, data, outside: path.symlink_to("/dev/zero"),
    "hard link": lambda path, data, outside: os.link(outside / path.name, path),
    "huge": lambda path, data, outside: filled(path, data, HUGE),
    "huge zeros": lambda path, data, outside: filled(path, b"", HUGE),
    "newlines": lambda path, data, outside: filled(path, b"\n" * 100_000_000),
    "empty": lambda path, data, outside: filled(path, b""),
    "folder": lambda path, data, outside: path.mkdir(),
    "missing": lambda path, data, outside: None,
    "mutated": lambda path, data, outside: mutated(path, data),
    "cut": lambda path, data, outside: filled(path, data[: len(data) // 2]),
}
CASES = [
    (file, attack)
    for file in FILES
    for attack in ATTACKS
    if not ((Path(file).suffix == "" and "lock" not in file) and attack in ("hard link", "huge"))
]


def make_template(run):
    """Fill the current folder with a run that has every file, another run, and an experiment.

    Args:
        run: function that runs a gaitsim command, given its arguments.
    """
    Path("puppet.toml").write_text(PUPPET)
    given = ("run", "puppet.toml", "--workers", "1", "--set", "evolution.fitness_threshold=0")
    run(*given, "--out", "runs/other")
    run(*given, "--set", "islands.number=2", "--from", "other", "--out", "runs/victim")
    run("plot", "victim", "--kind", "fitness")
    run("note", "victim", "It drags a leg.")
    Path("runs/victim/.gaitsim-0.partial").touch()
    experiment = Path("runs/victim/experiment.toml")  # more generations, so that resume has work
    experiment.write_text(experiment.read_text().replace("generations = 5", "generations = 7"))
    assert {file for file in FILES if not Path("runs/victim", file).exists()} == set()


def attacked(template, folder, file, attack):
    """Copy the template to `folder`, and replace a file of its run."""
    shutil.copytree(template, folder)
    outside = folder / "outside"
    outside.mkdir()
    path = folder / "runs/victim" / file
    data = b"" if path.is_dir() else path.read_bytes()
    shutil.move(path, outside / path.name)
    if path.name == "champions":  # a champion not in the checkpoint, which resume removes
        shutil.copy(outside / "champions/generation-000001.pickle", outside / "champions/x.pickle")
        (outside / "champions/x.pickle").rename(outside / "champions/generation-000099.pickle")
    (outside / "file").write_bytes(b"mine")
    ATTACKS[attack](path, data, outside)
