"""`fieldrig` in forks of one process that has imported its modules: the same output for a tenth of the CPU time.

For tests of what a command says and does, not of how it starts.
"""

import os
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from multiprocessing import get_context
from pathlib import Path
from typing import Final

_CONTEXT: Final = get_context("forkserver")  # a fork of this process would have its half of Zenoh, and no threads
_CONTEXT.set_forkserver_preload(
    [
        "pytest",  # which each fork imports as the main module of this process
        "fieldrig.cli.outcome",
        "fieldrig.cli.app",
        "fieldrig.control.messages",
        "fieldrig_devices.arp.commands",
        "fieldrig_devices.arp.user_port.client",
        "fieldrig_devices.languages.debugging.debug_command",
        "serial",
        "zenoh",
    ]
)


def run(
    arguments: Sequence[str], folder: Path, environment: Mapping[str, str], script: str = "", limit_s: float = 120.0
) -> subprocess.CompletedProcess[str]:
    """Run `fieldrig` with these arguments in a folder, with `script` as its standard input, to its end."""
    with files_in_memory("in", "out", "err") as files:
        files[0].write_text(script, encoding="utf-8")
        process = _CONTEXT.Process(target=_command, args=([*arguments], str(folder), {**environment}, files))
        process.start()
        process.join(limit_s)
        if process.is_alive():
            process.kill()
            process.join()
            raise subprocess.TimeoutExpired(["fieldrig", *arguments], limit_s)
        assert process.exitcode is not None
        output, errors = (file.read_text(encoding="utf-8") for file in files[1:])
        return subprocess.CompletedProcess(["fieldrig", *arguments], process.exitcode, output, errors)


@contextmanager
def files_in_memory(*names: str) -> Iterator[list[Path]]:
    """Return files that need no disk, as some tests fill theirs."""
    opened = [os.memfd_create(name) for name in names]
    try:
        yield [Path(f"/proc/{os.getpid()}/fd/{number}") for number in opened]
    finally:
        for number in opened:
            os.close(number)


def _command(arguments: list[str], folder: str, environment: dict[str, str], files: list[Path]) -> None:
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    for number, file in enumerate(files):
        os.dup2(os.open(file, os.O_RDWR), number)
    sys.stdin, sys.stdout = os.fdopen(0), os.fdopen(1, "w")
    sys.stderr = os.fdopen(2, "w", buffering=1, errors="backslashreplace")  # as Python itself opens it
    sys.argv = ["fieldrig", *arguments]
    from fieldrig.cli import main

    main()
