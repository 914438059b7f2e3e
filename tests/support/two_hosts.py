"""Two hosts with a line between them, in network namespaces that end with the test: nothing leads out of them.

The line is `slow_line.py`, a program between two TUN devices that delays, loses or stops each IP packet.  `tc netem`
does the same where the kernel has it, which those of containers and small virtual machines often have not.
"""

import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Final

from network_namespace import inside, new_network

LINE: Final = Path(__file__).with_name("slow_line.py")
ADDRESSES: Final = ("10.77.0.1", "10.77.0.2")


class Host:
    """A network with an address of its own."""

    def __init__(self, network: int, address: str) -> None:
        self.network, self.address = network, address

    def start(self, command: Sequence[str], folder: Path, output: Path) -> subprocess.Popen[bytes]:
        """Start a program on this host, in a process group of its own."""
        with inside(self.network), output.open("ab") as log:
            return subprocess.Popen(
                command, cwd=folder, stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True
            )

    def run(self, command: Sequence[str], folder: Path | None = None) -> subprocess.CompletedProcess[str]:
        """Run a program on this host to its end."""
        with inside(self.network):
            return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120, check=False)


class Line:
    """The line between the hosts; each change is in effect when its call returns."""

    def __init__(self, program: "subprocess.Popen[str]") -> None:
        self._program = program

    @property
    def pid(self) -> int:
        return self._program.pid

    def delay(self, ms: float) -> None:
        """Let each packet take this time."""
        self._tell(f"delay {ms}")

    def loss(self, percent: float) -> None:
        self._tell(f"loss {percent}")

    def cut(self) -> None:
        self._tell("cut")

    def mend(self) -> None:
        self._tell("mend")

    def _tell(self, words: str) -> None:
        assert self._program.stdin is not None
        assert self._program.stdout is not None
        self._program.stdin.write(f"{words}\n")
        self._program.stdin.flush()
        assert self._program.stdout.readline() == "done\n", f"the line has ended: {words}"


@contextmanager
def two_hosts() -> Iterator[tuple[Host, Host, Line]]:
    """Make two hosts and a line without delay or loss."""
    with ExitStack() as stack:
        hosts = [Host(stack.enter_context(new_network()), address) for address in ADDRESSES]
        networks = [host.network for host in hosts]
        program = subprocess.Popen(
            [sys.executable, str(LINE), *map(str, networks)],
            pass_fds=networks,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        stack.callback(_end, program)
        line = Line(program)
        line.mend()  # the devices are there now
        for host in hosts:
            for words in (f"address add {host.address}/24 dev line", "link set line up", "link set lo up"):
                assert host.run(["ip", *words.split()]).returncode == 0, words
        yield hosts[0], hosts[1], line


def _end(program: "subprocess.Popen[str]") -> None:
    program.terminate()
    program.communicate()
