"""`fieldrig` in forks of one process that has imported its modules: the same output for a tenth of the CPU time.

For tests of what a command says and does, not of how it starts.
"""

import os
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from select import select
from shlex import join
from tempfile import TemporaryDirectory
from typing import Final

from forked_command import begin, number_from

HERE: Final = Path(__file__).parent
NETWORK: Final = Path("/proc/thread-self/ns/net")


class Server:
    """Processes that are forked, one for each network.  One starts with the first command in its network."""

    def __init__(self) -> None:
        self._processes: dict[str, tuple[subprocess.Popen[bytes], TemporaryDirectory[str]]] = {}

    def path(self) -> str:
        """Return the path of the socket of the one in the network of this thread, once it listens there."""
        network = NETWORK.readlink().name if NETWORK.exists() else ""
        if network not in self._processes:
            folder = TemporaryDirectory(prefix="forks")
            command = [sys.executable, str(HERE / "command_server.py"), _socket(folder)]
            # A session of its own: Ctrl-C reaches the tests, which end their commands.
            process = subprocess.Popen(command, stdin=subprocess.PIPE, start_new_session=True)
            self._processes[network] = process, folder
            while not Path(_socket(folder)).exists():
                assert process.poll() is None, "the server of the commands has ended"
                time.sleep(0.02)
        return _socket(self._processes[network][1])

    def end(self) -> None:
        """End the processes with their commands; the next command starts another."""
        while self._processes:
            process, folder = self._processes.popitem()[1]
            process.communicate()
            folder.cleanup()


def _socket(folder: TemporaryDirectory[str]) -> str:
    return f"{folder.name}/socket"


USUAL: Final = Server()


class ForkedProcess(subprocess.Popen[bytes]):
    """A command that runs in a fork, as `subprocess.Popen` would have it."""

    def __init__(
        self,
        arguments: Sequence[str],
        folder: Path,
        environment: Mapping[str, str],
        files: Sequence[int],
        module: str = "fieldrig",
        server: Server = USUAL,
    ) -> None:
        """Start it, with these open files as its standard input, output and errors."""
        self.args, self.returncode = [module, *arguments], None
        self._connection = begin(server.path(), module, arguments, str(folder), environment, files)
        self.pid = number_from(self._connection)

    def poll(self) -> int | None:
        with suppress(subprocess.TimeoutExpired):
            self.wait(0.0)
        return self.returncode

    def wait(self, timeout: float | None = None) -> int:
        if self.returncode is None:
            if not select([self._connection], [], [], timeout)[0]:
                raise subprocess.TimeoutExpired(self.args, timeout or 0.0)
            self.returncode = number_from(self._connection)
            self._connection.close()
        return self.returncode

    def send_signal(self, sig: int) -> None:
        if self.poll() is None:
            os.kill(self.pid, sig)


def run(
    arguments: Sequence[str],
    folder: Path,
    environment: Mapping[str, str],
    script: str = "",
    limit_s: float = 120.0,
    module: str = "fieldrig",
    server: Server = USUAL,
) -> subprocess.CompletedProcess[str]:
    """Run `fieldrig`, or `python -m pytest`, with these arguments in a folder, to its end.

    `script` is its standard input.
    """
    with files_in_memory("in", "out", "err") as files:
        Path(f"/proc/self/fd/{files[0]}").write_text(script, encoding="utf-8")
        process = ForkedProcess(arguments, folder, environment, files, module, server)
        try:
            code = process.wait(limit_s)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            raise
        output, errors = (Path(f"/proc/self/fd/{file}").read_text(encoding="utf-8") for file in files[1:])
        return subprocess.CompletedProcess([module, *arguments], code, output, errors)


def start(
    arguments: Sequence[str], folder: Path | None, environment: Mapping[str, str], output: int
) -> subprocess.Popen[bytes]:
    """Start `fieldrig` in a folder, or in the current one, with both outputs into one open file and no input."""
    with Path(os.devnull).open("rb") as nothing:
        files = (nothing.fileno(), output, output)
        return ForkedProcess(arguments, folder or Path.cwd(), environment, files)


def save_commands(folder: Path) -> None:
    """Save the commands `fieldrig` and `python` in a folder, for the PATH of a shell.

    `python` is only another one for `python -m pytest`.
    """
    folder.mkdir()
    fork = join([sys.executable, "-IS", str(HERE / "forked_command.py"), USUAL.path()])
    _save_program(folder / "fieldrig", f'exec {fork} fieldrig "$@"\n')
    text = f'if [ "$1 $2" = "-m pytest" ]; then shift 2; exec {fork} pytest "$@"; fi\nexec {sys.executable} "$@"\n'
    _save_program(folder / "python", text)


def _save_program(file: Path, text: str) -> None:
    file.write_text(f"#!/bin/sh\n{text}", encoding="utf-8")
    file.chmod(0o755)


@contextmanager
def files_in_memory(*names: str) -> Iterator[list[int]]:
    """Return open files that need no disk, as some tests fill theirs."""
    opened = [os.memfd_create(name) for name in names]
    try:
        yield opened
    finally:
        for number in opened:
            os.close(number)
