"""A terminal window for programs that need one, and a user who looks at it and presses keys."""

import fcntl
import os
import pty
import select
import struct
import subprocess
import termios
from pathlib import Path
from typing import Self

from running_rig import until


class Terminal:
    """A terminal window with a command in it."""

    def __init__(self, line: str, folder: Path) -> None:
        self.shown = ""
        self._screen, theirs = pty.openpty()
        fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("4H", 40, 120, 0, 0))
        self._process = subprocess.Popen(
            ["setsid", "--ctty", "--wait", "bash", "-c", line],
            cwd=folder,
            env={**os.environ, "TERM": "xterm"},
            stdin=theirs,
            stdout=theirs,
            stderr=theirs,
        )
        os.close(theirs)

    def until_shown(self, *words: str) -> None:
        until(lambda: self._look() and all(word in self.shown for word in words))

    def type(self, text: str) -> None:
        os.write(self._screen, text.encode())

    def press(self, key: str) -> int:
        """The exit code of what ends then."""
        self.type(key)
        until(lambda: self._look() and self._process.poll() is not None)
        self._look()  # it may have said more between the look and its end
        return self._process.returncode

    def _look(self) -> bool:
        while select.select([self._screen], [], [], 0)[0]:
            try:
                self.shown += os.read(self._screen, 65536).decode(errors="replace")
            except OSError:  # everybody has closed it
                break
        return True

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        os.close(self._screen)
        self._process.kill()
        self._process.wait()
