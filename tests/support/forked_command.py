"""A command that runs in a fork of `command_server.py`, with the files, the folder and the signals of this process.

A script calls it as `python -IS forked_command.py SOCKET MODULE ARGUMENTS...` instead of `python -m MODULE`: the
process waits for the end of the fork, and ends as that does.  It imports nothing of ours, so that it starts in 20 ms.
"""

import json
import os
import signal
import socket
import sys
from collections.abc import Mapping, Sequence

FORWARDED = tuple(getattr(signal, f"SIG{name}") for name in ("INT", "TERM", "HUP", "QUIT", "USR1", "USR2"))


def begin(
    server: str,
    module: str,
    arguments: Sequence[str],
    folder: str,
    environment: Mapping[str, str],
    files: Sequence[int],
) -> socket.socket:
    """Begin the command, with these open files as its standard input, output and errors.

    What is returned gives the number of its process and, at its end, its exit code, which is negative for a signal;
    `number_from` reads both.  Closing it before that kills the command.
    """
    connection = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    ignored = [number for number in FORWARDED if signal.getsignal(number) == signal.SIG_IGN]
    request = [module, [*arguments], folder, {**environment}, ignored]
    connection.connect(server)
    socket.send_fds(connection, [json.dumps(request).encode()], files)
    return connection


def number_from(connection: socket.socket) -> int:
    """Wait for the next number.  ValueError if the server has ended."""
    return int(connection.recv(16))


def main() -> int:
    server, module, *arguments = sys.argv[1:]
    folder = os.getcwd()  # noqa: PTH109 - the import of pathlib takes as long as all others
    connection = begin(server, module, arguments, folder, os.environ, (0, 1, 2))
    pid = number_from(connection)
    for number in FORWARDED:
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, lambda number, _frame: os.kill(pid, number))
    code = number_from(connection)
    if code < 0:
        signal.signal(-code, signal.SIG_DFL)
        os.kill(os.getpid(), -code)
    return code


if __name__ == "__main__":
    sys.exit(main())
