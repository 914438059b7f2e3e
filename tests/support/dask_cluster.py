"""A Dask cluster on this machine: a scheduler and workers, each a process that a test may kill."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import NamedTuple

from fieldrig.testing import free_port, return_port


class Cluster(NamedTuple):
    address: str
    workers: list["subprocess.Popen[bytes]"]
    """The workers, or their nannies, which start them again: `dask worker` has one unless `--no-nanny` is given."""
    have_nannies: bool

    def kill_worker(self) -> None:
        """Kill the first worker, with what it is doing."""
        pid = self.workers[0].pid
        os.kill(_child_of(pid, "spawn_main") if self.have_nannies else pid, signal.SIGKILL)


@contextmanager
def cluster(workers: int, folder: Path, *, have_nannies: bool = False) -> Iterator[Cluster]:
    """Start the processes; they find each other by themselves."""
    port = free_port()
    address = f"tcp://127.0.0.1:{port}"
    with ExitStack() as stack:
        stack.callback(return_port, port)
        place = ["--host", "127.0.0.1", "--no-dashboard"]
        stack.enter_context(_started(folder, "scheduler", "--port", str(port), *place))
        one_thread = ["--nthreads", "1", "--nanny" if have_nannies else "--no-nanny", "--local-directory", str(folder)]
        started = [
            stack.enter_context(_started(folder, "worker", address, *place, *one_thread)) for _ in range(workers)
        ]
        yield Cluster(address, started, have_nannies)


def _child_of(pid: int, what: str) -> int:
    """Return the child of a process, started by any of its threads, whose command line has this word."""
    for thread in Path(f"/proc/{pid}/task").iterdir():
        for child in (thread / "children").read_text(encoding="utf-8").split():
            if what in Path(f"/proc/{child}/cmdline").read_text(encoding="utf-8"):
                return int(child)
    raise LookupError(f"process {pid} has no child {what}")


@contextmanager
def _started(folder: Path, what: str, *options: str) -> Iterator["subprocess.Popen[bytes]"]:
    command = [sys.executable, "-m", f"distributed.cli.dask_{what}", *options]
    with (folder / f"{what}.log").open("ab") as log:
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=log)
    try:
        yield process
    finally:
        process.terminate()
        process.wait(60)
