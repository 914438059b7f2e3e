"""A Dask cluster on this machine: a scheduler and workers, each a process that a test may kill."""

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


@contextmanager
def cluster(workers: int, folder: Path) -> Iterator[Cluster]:
    """Start the processes; they find each other by themselves."""
    port = free_port()
    address = f"tcp://127.0.0.1:{port}"
    with ExitStack() as stack:
        stack.callback(return_port, port)
        place = ["--host", "127.0.0.1", "--no-dashboard"]
        stack.enter_context(_started(folder, "scheduler", "--port", str(port), *place))
        one_thread = ["--nthreads", "1", "--no-nanny", "--local-directory", str(folder)]
        started = [
            stack.enter_context(_started(folder, "worker", address, *place, *one_thread)) for _ in range(workers)
        ]
        yield Cluster(address, started)


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
