"""Fail or kill each step of commands that write, then start again: `python faults.py STRIDE`.

A step is a call that changes the file system. In every STRIDE-th case one child process gets an
error at a step, or ends there, and another one starts the command again. Prints the cases after
which a draft was left behind, or the second start failed. Works in the current, empty folder.
"""

import errno
import json
import os
import shutil
import sys
from functools import partial
from itertools import count
from pathlib import Path

from gaitsim.errors import GaitsimError
from gaitsim.evaluation import evaluate
from gaitsim.experiment import parse_assignments, parse_experiment
from gaitsim.storage.creation import create_run, fork_run
from gaitsim.storage.files.atomic import write_bytes
from gaitsim.storage.files.folder import create_folder, exports_folder
from gaitsim.storage.manage import delete_run, empty_trash, list_trash, restore_run, trash_run
from gaitsim.storage.writer import RunWriter

STEPS = ("fsync", "rename", "replace", "mkdir", "link", "unlink", "rmdir", "ftruncate", "write")
FAULTS = {  # the error, 0 to end the process, and whether all later steps fail, too
    "no space": (errno.ENOSPC, False),
    "disk error": (errno.EIO, False),
    "disk gone": (errno.EIO, True),
    "killed": (0, False),
}
RUN, COPY = Path("runs/puppet"), Path("runs/copy")
LASTING = (".lock", ".lock-owner", ".trash")
ENDED, REFUSED, CRASHED = 0, 2, 3


def evolve(path, *overrides):
    with RunWriter.open(path, overrides=parse_assignments(overrides)) as writer:
        for _ in writer.evolve(partial(evaluate, writer.experiment)):
            pass


def run():
    if not RUN.exists():
        create_run(parse_experiment(TEXT, "puppet.toml", parse_assignments(LENGTH)))
    evolve(RUN)


def resume():
    evolve(RUN, "evolution.generations=6", "search.elites=1")


def fork():
    if not COPY.exists():
        fork_run(RUN, COPY)
    evolve(COPY)


def delete():
    if RUN.exists():
        delete_run(RUN)
    else:
        create_folder(RUN, {"experiment.toml": ""})


def trash():
    if not RUN.exists():
        for one in list_trash(RUN.parent):
            restore_run(one)
    if not RUN.exists():
        create_folder(RUN, {"experiment.toml": ""})
    trash_run(RUN)
    (one,) = list_trash(RUN.parent)
    restore_run(one)
    trash_run(RUN)
    empty_trash(RUN.parent)


def export():
    write_bytes(exports_folder(RUN) / "gait.csv", b"1")


def compare():
    write_bytes(create_folder(Path("runs/comparison"), {"1.toml": ""}) / "report.md", b"1")


def in_child(work):
    child = os.fork()
    if not child:
        try:
            work()
            os._exit(ENDED)
        except GaitsimError:
            os._exit(REFUSED)
        except BaseException as error:
            print(f"{error!r}", file=sys.stderr)
            os._exit(CRASHED)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def with_fault(work, at, code, lasting):
    """Do the work, whose step `at` fails; return the number of its steps."""
    numbers = count()

    def faulty(real):
        def step(*arguments, **options):
            number = next(numbers)
            if number == at or (lasting and number > at):
                if not code:
                    os._exit(REFUSED)
                raise OSError(code, os.strerror(code))
            return real(*arguments, **options)

        return step

    for name in STEPS:
        setattr(os, name, faulty(getattr(os, name)))
    work()
    return next(numbers)


def before(work):
    shutil.rmtree("runs", ignore_errors=True)
    if work is not run:
        shutil.copytree("seed", "runs")


def steps_of(work):
    before(work)
    return in_child(lambda: os._exit(with_fault(work, -1, 0, False)))


def main(stride):
    works = (run, resume, fork, delete, trash, export, compare)
    steps = {work: steps_of(work) for work in works}
    cases = [(work, name, at) for work in works for name in FAULTS for at in range(steps[work])]
    wrong = []
    for work, name, at in cases[::stride]:
        before(work)
        code, lasting = FAULTS[name]
        ended = in_child(partial(with_fault, work, at, code, lasting))
        again = in_child(work)
        left = [str(path) for path in Path("runs").rglob(".*") if path.name not in LASTING]
        if ended not in (ENDED, REFUSED) or again != ENDED or left:
            wrong.append([work.__name__, name, at, ended, again, left])
    print(json.dumps({"cases": len(cases[::stride]), "wrong": wrong}))


TEXT, LENGTH = Path("puppet.toml").read_text(), ["evolution.generations=3"]
os.fsync = lambda descriptor: None  # which takes most of the time
in_child(run)
Path("runs").rename("seed")
main(int(sys.argv[1]))
