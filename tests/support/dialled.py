"""`fieldrig dial` as a process."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

LOGIN = ("--user", "service", "--password", "secret")


@dataclass
class Dialled:
    """A running `fieldrig dial`."""

    process: "subprocess.Popen[str]"
    lines: list[str] = field(default_factory=list)

    def until(self, text: str) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.lines.append(line)
            if text in line:
                return
        raise AssertionError("".join(self.lines))

    def end(self) -> tuple[int, str]:
        rest, _ = self.process.communicate(timeout=60)
        return self.process.returncode, rest


@contextmanager
def dialled(path: str, *arguments: str) -> Iterator[Dialled]:
    command = [sys.executable, "-m", "fieldrig", "dial", path, "4711", *arguments]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        try:
            yield Dialled(process)
        finally:
            process.kill()
