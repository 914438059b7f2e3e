"""A process that has imported the modules of `fieldrig`, and runs commands in forks of itself.

It is called as `python command_server.py SOCKET`, and ends with its commands when its standard input is closed.  A
command that is started imports some 600 modules, for half a second of CPU time; a fork has them.  What a command has
imported of ours this process imports when it has ended, for those that follow.
"""

import atexit
import gc
import os
import runpy
import selectors
import signal
import socket
import sys
import threading
from collections.abc import Iterable
from contextlib import suppress
from importlib import import_module
from json import dumps, loads
from pathlib import Path
from typing import NoReturn

LONGEST_REQUEST = 1 << 18
MOST_FILES = 4096
"""Number behind the last file that this process may have open: a command has only those that it is given."""
MODULES = (
    "fieldrig.cli.outcome",
    "fieldrig.control.messages",
    "fieldrig.real.supervisor",
    "fieldrig.virtual.rig",
    "fieldrig_devices.languages.debugging.debug_command",
    "serial",
    "zenoh",
)
OURS = ("fieldrig", "fieldrig_bus", "fieldrig_devices", "fieldrig_page")
IMPORTED = 3
"""File in which a fork says what it has imported."""
FOREIGN = "pytest"
"""The only module beside ours that commands run."""
IS_IMPORTED = ("-W", "ignore:Module already imported so cannot be rewritten")
"""It would say so of each of its plugins that this process has imported, ours among them."""


class Server:
    def __init__(self, path: str) -> None:
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._listener.bind(f"{path}.new")
        self._listener.listen(64)
        Path(f"{path}.new").rename(path)  # who waits for the file may connect at once
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._listener, selectors.EVENT_READ, self._accept)
        self._selector.register(sys.stdin, selectors.EVENT_READ, self._end)
        self._pids: dict[socket.socket, int] = {}
        self._is_ended = False

    def run(self) -> None:
        while not self._is_ended:
            for key, _ in self._selector.select():
                key.data()
        for pid in self._pids.values():
            os.killpg(pid, signal.SIGKILL)
            os.waitpid(pid, 0)

    def _end(self) -> None:
        self._is_ended = True

    def _accept(self) -> None:
        connection = self._listener.accept()[0]
        request, files, _, _ = socket.recv_fds(connection, LONGEST_REQUEST, 3)
        if len(files) != 3:  # the process that asked has ended
            connection.close()
            return
        imported = os.memfd_create("imported")
        pid = os.fork()
        if pid == 0:
            _become([*files, imported], *loads(request))
        for file in files:
            os.close(file)
        with suppress(PermissionError):  # it has done so itself, and is another program now
            os.setpgid(pid, pid)
        self._pids[connection] = pid
        _send(connection, pid)
        end = os.pidfd_open(pid)
        self._selector.register(connection, selectors.EVENT_READ, lambda: self._kill(connection, pid))
        self._selector.register(end, selectors.EVENT_READ, lambda: self._ended(connection, pid, end, imported))

    def _kill(self, connection: socket.socket, pid: int) -> None:
        if connection not in self._pids:  # it ended at the same time
            return
        self._selector.unregister(connection)
        os.killpg(pid, signal.SIGKILL)

    def _ended(self, connection: socket.socket, pid: int, end: int, imported: int) -> None:
        code = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
        self._selector.unregister(end)
        os.close(end)
        with suppress(KeyError):
            self._selector.unregister(connection)
        _send(connection, code)
        del self._pids[connection]
        connection.close()
        with open(imported, "rb") as file:
            file.seek(0)
            take_in(loads(file.read() or "[]"))


def _send(connection: socket.socket, number: int) -> None:
    with suppress(OSError):  # the process that asked has ended
        connection.send(str(number).encode())


def _become(
    files: list[int], module: str, arguments: list[str], folder: str, environment: dict[str, str], ignored: list[int]
) -> NoReturn:
    """Be `python -m MODULE` in this fork, or `fieldrig` for the module of that name."""
    os.setpgid(0, 0)
    for number, file in enumerate(files):
        os.dup2(file, number, inheritable=number != IMPORTED)
    os.closerange(len(files), MOST_FILES)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    for number in ignored:
        signal.signal(number, signal.SIG_IGN)
    # As Python itself opens them.
    sys.stdin = sys.__stdin__ = os.fdopen(0)  # type: ignore[misc]
    sys.stdout = sys.__stdout__ = os.fdopen(1, "w", buffering=1 if os.isatty(1) else -1)  # type: ignore[misc]
    sys.stderr = sys.__stderr__ = os.fdopen(2, "w", buffering=1, errors="backslashreplace")  # type: ignore[misc]
    known = frozenset(sys.modules)
    code = _code_of(module, arguments, folder)
    new = [name for name in sys.modules if name not in known and name.partition(".")[0] in OURS]
    os.write(IMPORTED, dumps(new).encode())
    os._exit(code)


def _code_of(module: str, arguments: list[str], folder: str) -> int:
    """Run a module as the main program, and return its exit code."""
    code = 1
    sys.argv = [module, *arguments, *(IS_IMPORTED if module == FOREIGN else ())]
    sys.path[0] = folder if module == FOREIGN else str(Path(sys.prefix) / "bin")
    sys.path[1:1] = filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))
    try:
        if module == FOREIGN:
            runpy.run_module(module, run_name="__main__", alter_sys=True)
        else:
            import_module("fieldrig.cli").main()
        code = 0
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
    except BaseException:  # noqa: BLE001 - whatever it is, Python would show it
        sys.excepthook(*sys.exc_info())
    for finish in (threading._shutdown, atexit._run_exitfuncs, sys.stdout.flush, sys.stderr.flush):  # type: ignore[attr-defined]
        with suppress(OSError):
            finish()
    return code


def take_in(modules: Iterable[str]) -> None:
    """Import modules, so that all forks have them."""
    for module in modules:
        import_module(module)
    gc.collect()
    gc.freeze()


def main() -> None:
    take_in((*MODULES, FOREIGN))
    Server(sys.argv[1]).run()


if __name__ == "__main__":
    main()
