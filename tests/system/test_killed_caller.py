"""A caller that is killed closes its serial port, so its modem hangs up, and the next caller is answered."""

import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from dialled import LOGIN, Dialled, dialled
from running_rig import AskedRig, until

from fieldrig.testing import free_port

pytestmark = pytest.mark.system

OFFLINE, ONLINE = 6, 7  # Com1UserState
RIG = """
time: real
buses:
  com1: {kind: serial.line, baud: 38400, process: modems}
  caller: {kind: serial.pty, path: modem, baud: 38400, process: modems}
  telephone: {kind: telephone.exchange, numbers: {machine: "4711", laptop: "4712"}, process: modems}
devices:
  max4:
    kind: max4
    links: {com1: com1}
    com1: {modem: Modem}
    parameters: {MAx-4.Com1User: 1, Modem.UserName: service, Modem.Password: secret}
  machine: {kind: modem, training_ms: 100, links: {line: com1, telephone: telephone}, process: modems}
  laptop: {kind: modem, training_ms: 100, links: {line: caller, telephone: telephone}, process: modems}
"""


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[AskedRig]:
    file = tmp_path / "lab.yaml"
    file.write_text(RIG)
    with AskedRig(file, None) as rig:
        yield rig.until_ready()


def up(dial: Dialled, rig: AskedRig) -> None:
    dial.until("Ctrl-C hangs up.")
    assert rig.get("laptop/dtr") is True
    assert rig.get("max4/Com1UserState") == ONLINE


def test_the_line_is_free_after_a_caller_was_killed(rig: AskedRig) -> None:
    line, way = str(rig.folder / "run/lab/modem"), f"{free_port()}:80"
    until(lambda: rig.get("max4/Com1UserState") == OFFLINE)
    assert rig.get("laptop/dtr") is False
    with dialled(line, *LOGIN, "--forward", way) as dial:
        up(dial, rig)
        dial.process.kill()
    until(lambda: rig.get("laptop/call") == "idle")
    until(lambda: rig.get("max4/Com1UserState") == OFFLINE)
    with dialled(line, *LOGIN, "--forward", way) as dial:
        up(dial, rig)
        dial.process.send_signal(signal.SIGINT)
        assert dial.end() == (0, "The call has ended.\n")
