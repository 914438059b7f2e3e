"""`pppd call` with a peers file and a chat script as an engineer writes them; only inside user-mode Linux, as root."""

import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from pppd import SECRETS
from running_rig import until

PEERS, CHATS = Path("/etc/ppp/peers"), Path("/etc/chatscripts")
NAME = "wrapper"
HANG_UP_S = 30
CHAT = """
ABORT BUSY
ABORT ERROR
ABORT 'NO CARRIER'
ABORT 'NO DIALTONE'
ABORT 'NO ANSWER'
TIMEOUT 60
'' ATZ
OK ATE0
OK ATDT4711
CONNECT ''
"""
# A pty carries no DCD, so echoes of LCP notice that the call is lost.  A host that is busy with other tests may stand
# still for some seconds.
OPTIONS = """
{line}
38400
local
nodetach
nocrtscts
noauth
noipdefault
debug
user {user}
lcp-echo-interval 6
lcp-echo-failure 3
lcp-max-terminate 1
connect "chat -v -s -f {chat}"
"""


@dataclass(frozen=True, slots=True)
class Call:
    """A running pppd."""

    process: subprocess.Popen[bytes]
    log: Path

    def output(self) -> str:
        """Return what pppd and chat have written."""
        return self.log.read_text(errors="replace")

    def is_up(self) -> bool:
        return "remote IP address" in self.output()

    def until_up(self) -> "Call":
        until(lambda: self.is_up() or self.process.poll() is not None)
        assert self.is_up(), self.output()
        return self

    def ended(self) -> int:
        """Wait for the end, and return the exit code (pppd(8), EXIT STATUS)."""
        until(lambda: self.process.poll() is not None)
        return self.process.returncode

    def hang_up(self) -> int:
        self.process.terminate()
        return self.ended()


def write_peer(line: Path, user: str, password: str) -> None:
    """Write the peers file, its chat script, and the password."""
    PEERS.mkdir(parents=True, exist_ok=True)
    CHATS.mkdir(parents=True, exist_ok=True)
    (CHATS / NAME).write_text(CHAT)
    (PEERS / NAME).write_text(OPTIONS.format(line=line, user=user, chat=CHATS / NAME))
    SECRETS.write_text(f"{user} * {password} *\n")


@contextmanager
def pppd_call(folder: Path) -> Iterator[Call]:
    """Dial with `pppd call`; a call that is still there afterwards is hung up, as the next one needs the line."""
    log = folder / "pppd.log"
    with log.open("wb") as output, subprocess.Popen(["pppd", "call", NAME], stdout=output, stderr=output) as process:
        call = Call(process, log)
        try:
            yield call
        except BaseException as fault:
            fault.add_note(
                f"pppd, which has {'ended' if process.poll() is not None else 'not ended'}, said:\n{call.output()}"
            )
            raise
        finally:
            process.terminate()
            try:
                process.wait(HANG_UP_S)
            finally:
                process.kill()
