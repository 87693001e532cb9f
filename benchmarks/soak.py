"""Memory, file descriptors, disk and results of gaitsim under hours of use, and at scale.

Each soak prints its figures while it runs. They need the extras `serve` and `dask`.
"""

import argparse
import asyncio
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import chdir, contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import psutil
from aiohttp import ClientError, ClientSession, CookieJar
from timing import print_machine
from tui import Terminal

from gaitsim.experiment import load_experiment
from gaitsim.storage.creation import create_run
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.writer import RunWriter

MB = 1e6
TOKEN = "soak"
KEYS = ("\x1b[A", "\x1b[B", "\r", "\x1b", "\t", "?", "/", "a", " ", "\x1b[6~", "\x1b[C", "\x1b[D")


def gaitsim(*words: object) -> list[str]:
    """Return the command line of a gaitsim command."""
    return [sys.executable, "-m", "gaitsim", *map(str, words)]


def measure(process: psutil.Process) -> str:
    """Format the memory, descriptors and threads of a process, and its children's memory."""
    children = []
    for child in process.children(recursive=True):
        with suppress(psutil.NoSuchProcess):
            children.append(child.memory_info().rss / MB)
    return (
        f"{process.memory_info().rss / MB:7.1f} MB {process.num_fds():4} fds "
        f"{process.num_threads():3} threads; {len(children)} children, {sum(children):6.1f} MB"
    )


def disk(folder: Path) -> float:
    """Return the size of all files of a folder, MB."""
    return sum(file.stat().st_size for file in folder.rglob("*") if file.is_file()) / MB


@contextmanager
def running(command: list[str], folder: Path, **environment: str) -> Iterator[psutil.Process]:
    """Run a program in a folder; end it afterwards."""
    output = subprocess.DEVNULL if "--json" in command else None
    program = subprocess.Popen(command, cwd=folder, env=os.environ | environment, stdout=output)
    try:
        yield psutil.Process(program.pid)
    finally:
        program.terminate()
        print(f"ended with {program.wait(60)}")


class Users:
    """Clients of `gaitsim serve`: users who come and go, and strangers."""

    def __init__(self, port: int, seconds: float) -> None:
        self.port, self.address = port, f"http://127.0.0.1:{port}/"
        self.end = time.monotonic() + seconds
        self.counts: Counter[str] = Counter()
        self.starts: list[float] = []

    async def use(self, seed: int) -> None:
        """Open the app, press keys, and close the window or lose the connection."""
        chance = random.Random(seed)
        while time.monotonic() < self.end:
            async with ClientSession(cookie_jar=CookieJar(unsafe=True)) as session:
                try:
                    async with asyncio.timeout(90):
                        await self._use(session, chance)
                except (ClientError, ConnectionError, TimeoutError) as error:
                    self.counts[f"window: {type(error).__name__}"] += 1

    async def _use(self, session: ClientSession, chance: random.Random) -> None:
        await (await session.get(self.address, params={"token": TOKEN})).read()
        began, drawn = time.monotonic(), 0
        window = await session.ws_connect(f"{self.address}ws", origin=self.address.rstrip("/"))
        leaves = began + chance.uniform(2, 30)
        while time.monotonic() < leaves:
            with suppress(TimeoutError):
                async with asyncio.timeout(chance.uniform(0.05, 1)):
                    while True:
                        message = await window.receive()
                        if message.data is None or window.closed:
                            self.counts[f"closed by the server: {message.extra!r}"] += 1
                            return
                        if not drawn:
                            self.starts.append(time.monotonic() - began)
                        drawn += len(message.data)
            await window.send_json(["stdin", chance.choice(KEYS)])
            if chance.random() < 0.1:
                size = {"width": chance.randrange(20, 200), "height": chance.randrange(5, 60)}
                await window.send_json(["resize", size])
        self.counts["windows"] += 1
        self.counts["drawn, kB"] += drawn // 1000
        if chance.random() < 0.3:  # the connection is lost, without a goodbye
            window._response.connection.transport.abort()
        else:
            await window.close()

    async def guess(self) -> None:
        """Try wrong tokens."""
        while time.monotonic() < self.end:
            async with ClientSession() as session:
                with suppress(ClientError, ConnectionError):
                    found = await session.get(self.address, params={"token": str(random.random())})
                    self.counts[f"wrong token: {found.status}"] += 1
            await asyncio.sleep(0.2)

    async def loiter(self) -> None:
        """Send halves of requests, and leave or stay."""
        held: list[asyncio.StreamWriter] = []
        while time.monotonic() < self.end:
            with suppress(OSError):
                _, writer = await asyncio.open_connection("127.0.0.1", self.port)
                writer.write(b"GET /ws HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: Upgr")
                held.append(writer)
                self.counts["half requests"] += 1
            if len(held) > 100:
                for writer in held:
                    writer.close()
                held.clear()
            await asyncio.sleep(0.05)


async def _soak_server(process: psutil.Process, users: Users, folder: Path, every: float) -> None:
    work = [
        asyncio.create_task(one)
        for one in (users.use(1), users.use(2), users.guess(), users.guess(), users.loiter())
    ]
    began = time.monotonic()
    while time.monotonic() < users.end:
        await asyncio.sleep(every)
        starts = sorted(users.starts[-50:]) or [0.0]
        print(
            f"{(time.monotonic() - began) / 60:5.1f} min {measure(process)}; disk "
            f"{disk(folder):.2f} MB; first output {starts[len(starts) // 2]:.2f} s, at most "
            f"{starts[-1]:.2f} s; {dict(users.counts)}",
            flush=True,
        )
    await asyncio.gather(*work)
    await asyncio.sleep(20)  # apps end
    print(f"without users {measure(process)}")


def soak_server(folder: Path, options: argparse.Namespace) -> None:
    """Serve two users at once, who reconnect, beside wrong tokens and half-sent requests."""
    for seed in range(3):
        words = ("run", "millipede-mutation", "--seed", seed, "--generations", 100)
        subprocess.run(
            gaitsim(*words, "--out", f"runs/{seed}", "--json"),
            cwd=folder,
            check=True,
            stdout=subprocess.DEVNULL,
        )
    command = gaitsim("serve", "--port", options.port)
    with running(command, folder, GAITSIM_TOKEN=TOKEN) as process:
        time.sleep(5)
        users = Users(options.port, options.minutes * 60)
        asyncio.run(_soak_server(process, users, folder, options.every))


def print_command(folder: Path, *words: object) -> None:
    """Run a gaitsim command; print its times and the most memory that it took."""
    began, most, used = time.monotonic(), 0.0, 0.0
    with subprocess.Popen(gaitsim(*words), cwd=folder, stdout=subprocess.DEVNULL) as program:
        process = psutil.Process(program.pid)
        while program.poll() is None:
            with suppress(psutil.NoSuchProcess):
                most = max(most, process.memory_info().rss / MB)
                used = sum(process.cpu_times()[:2])
            time.sleep(0.05)
    seconds = time.monotonic() - began
    line = f"{seconds:6.1f} s ({used:5.1f} s of a core), {most:6.1f} MB, code {program.returncode}"
    print(f"gaitsim {' '.join(map(str, words)):<60} {line}", flush=True)


def print_home(folder: Path, name: str) -> None:
    """Print the seconds until the terminal UI shows its first screen and a run."""
    with chdir(folder):
        terminal = Terminal(gaitsim("tui", "runs"), 120, 40)
        drawn = terminal.wait_for(b"palette") - terminal.started
        listed = terminal.wait_for(name.encode()) - terminal.started
        memory = psutil.Process(terminal.process.pid).memory_info().rss / MB
        terminal.close()
    print(
        f"home: first screen {drawn:.1f} s, first run {listed:.1f} s, {memory:.1f} MB", flush=True
    )


TINY = "millipede-mutation"
TINY_OPTIONS = ("--set", "evolution.population=3", "--set", "organism.pairs=2", "--workers", 1)


def soak_generations(folder: Path, options: argparse.Namespace) -> None:
    """Evolve a tiny run, then record as many generations as asked, and open the run."""
    words = ("run", TINY, *TINY_OPTIONS, "--generations", 10**8, "--out", "runs/evolved")
    with running(gaitsim(*words, "--json"), folder) as process:
        for _ in range(4):
            time.sleep(options.minutes * 15)
            run = RunSnapshot(folder / "runs/evolved")
            print(f"evolved {run.generation:9,} generations: {measure(process)}", flush=True)
    experiment = load_experiment(TINY, {"evolution.population": 3, "organism.pairs": 2,
                                        "evolution.generations": options.count + 10})  # fmt: skip
    path = create_run(experiment, folder / "runs/recorded")
    began, own = time.monotonic(), psutil.Process()
    with RunWriter.open(path, workers=1) as writer:
        first = next(writer.evolve())
        for number in range(2, options.count + 1):
            progress = replace(first.progress, evaluations=3 * number, stagnation=number - 1)
            writer.record(replace(first, number=number, progress=progress))
            if number % (options.count // 10) == 0:
                seconds = time.monotonic() - began
                print(f"recorded {number:9,} in {seconds:6.1f} s: {measure(own)}", flush=True)
    for file in sorted(path.iterdir()):
        print(f"  {file.name:<28} {file.stat().st_size / MB:9.3f} MB")
    print_command(folder, "resume", "recorded", "--generations", options.count + 5, "--workers", 1)
    for command in ("show", "runs"):
        print_command(folder, command, *(["recorded"] if command == "show" else []))
    print_home(folder, "recorded")


def soak_runs(folder: Path, options: argparse.Namespace) -> None:
    """List a folder of many runs, in the command line and at home."""
    words = ("run", TINY, *TINY_OPTIONS, "--generations", 20, "--out", "runs/run-00000")
    subprocess.run(gaitsim(*words), cwd=folder, check=True, capture_output=True)
    for number in range(1, options.count):
        shutil.copytree(folder / "runs/run-00000", folder / f"runs/run-{number:05}")
    print(f"{options.count:,} runs, {disk(folder):.1f} MB")
    print_command(folder, "runs")
    print_command(folder, "runs", "--json")
    print_command(folder, "runs", "--where", "score>0 name:run-0000", "--sort", "-score")
    print_home(folder, "run-0")


def soak_worlds(folder: Path, options: argparse.Namespace) -> None:
    """Evaluate 1,000 individuals in 1,000 worlds each; then interrupt it."""
    words = ("run", "walker-worlds", "--set", "evolution.population=1000", "--set")
    words = (*words, "worlds.number=1000", "--out", "runs/worlds")
    with running(gaitsim(*words), folder) as process:
        began = time.monotonic()
        while time.monotonic() < began + options.minutes * 60 and process.is_running():
            time.sleep(options.every)
            print(f"{time.monotonic() - began:6.0f} s {measure(process)}", flush=True)
        asked = time.monotonic()
        for _ in range(2):  # after this generation, and at once
            process.send_signal(signal.SIGINT)
            time.sleep(0.5)
        with suppress(psutil.TimeoutExpired):
            process.wait(120)
        print(f"Ctrl-C took {time.monotonic() - asked:.1f} s")


STUDY = """
name = "many"
experiments = ["millipede-mutation", "millipede-double-mutation"]
set = { "evolution.generations" = 20 }
repeats = 2
[axes]
"evolution.population" = { from = 5, to = 103, step = 2 }
"organism.pairs" = { from = 2, to = 11, step = 1 }
"""


def soak_study(folder: Path, options: argparse.Namespace) -> None:
    """Run a study of 1,000 cells on a Dask cluster whose workers are killed, and without."""
    from distributed import LocalCluster

    (folder / "many.toml").write_text(STUDY)
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        address, kills = cluster.scheduler_address, 0
        words = ("study", "many.toml", "--dask", address, "--out", "killed")
        with running(gaitsim(*words), folder) as process:
            began = time.monotonic()
            while process.is_running() and process.status() != psutil.STATUS_ZOMBIE:
                time.sleep(options.every)
                pids = [one.pid for one in cluster.workers.values() if one.pid]
                with suppress(psutil.NoSuchProcess, IndexError):  # all may be restarting
                    psutil.Process(random.choice(pids)).kill()
                    kills += 1
                done = len([*(folder / "killed/cells").glob("*.npy")])
                print(f"{time.monotonic() - began:5.0f} s {measure(process)}; {done} cells, "
                      f"{kills} workers killed", flush=True)  # fmt: skip
    print_command(folder, "study", "many.toml", "--workers", 1, "--out", "whole")
    same = (folder / "killed/results.csv").read_bytes() == (
        folder / "whole/results.csv"
    ).read_bytes()
    print("the tables are equal" if same else "THE TABLES DIFFER")


SOAKS: dict[str, Callable[[Path, argparse.Namespace], None]] = {
    "serve": soak_server,
    "generations": soak_generations,
    "runs": soak_runs,
    "worlds": soak_worlds,
    "study": soak_study,
}


def main() -> None:
    """Print the figures of a soak."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("soak", choices=SOAKS)
    parser.add_argument("--minutes", type=float, default=60, help="duration; default: 60")
    parser.add_argument("--every", type=float, default=60, help="seconds between figures")
    parser.add_argument("--count", type=int, default=10_000, help="number of generations or runs")
    parser.add_argument("--port", type=int, default=8765, help="port of the server")
    options = parser.parse_args()
    print_machine()
    with TemporaryDirectory() as folder:
        SOAKS[options.soak](Path(folder), options)


if __name__ == "__main__":
    main()
