"""`fieldrig arp` on cards that run in processes of their own, at a pty, at TCP, and at RFC 2217."""

import json
import os
import shlex
import shutil
import signal
import subprocess
import zlib
from collections.abc import Iterator
from typing import Any

import forked_cli
import pytest
from patience import PATIENCE_S
from running_rig import RunningRig
from terminal import Terminal

from fieldrig.real.live_rig import FIELDRIG
from fieldrig.testing import free_port
from fieldrig_devices.arp.language.compiler import compile_text
from fieldrig_devices.arp.language.files import encode
from fieldrig_devices.arp.user_port.client import ArpPort, RefusedByCardError
from fieldrig_devices.arp.user_port.messages import BLOCK, LARGEST_BLOCK, WHOLE, Command, ProgramCode

pytestmark = pytest.mark.system

COUNT = """\
COUNT EQU V1
BEG MAIN
LOOP:
COUNT += 1
CALL TWICE
WAIT 0.01
GOTO LOOP
END
BEG TWICE
V2 == COUNT * 2
END
"""
CTRL_C, CTRL_D = "\x03", "\x04"
LONG = "BEG MAIN\nL:\n" + "".join(f"V{number} == {number} * V1\n" for number in range(1, 300)) + "GOTO L\nEND\n"


class Cards(RunningRig):
    """Cards 1 to 3, with Enable closed."""

    def __init__(self) -> None:
        tcp, rfc2217 = f"127.0.0.1:{free_port()}", f"127.0.0.1:{free_port()}"
        common = "inputs: {I108: true}, user_port: {baud: 115200}, on_exit: restart"
        super().__init__(
            f"""
time: real
buses:
  pty: {{kind: serial.pty, baud: 115200}}
  tcp: {{kind: serial.tcp, listen: "{tcp}", baud: 115200}}
  rfc2217: {{kind: serial.rfc2217, listen: "{rfc2217}", baud: 115200}}
devices:
  card1: {{kind: arp, number: 1, links: {{user: pty}}, {common}}}
  card2: {{kind: arp, number: 2, links: {{user: tcp}}, {common}}}
  card3: {{kind: arp, number: 3, links: {{user: rfc2217}}, {common}}}
""",
            None,
        )
        self.ports = {1: str(self.run / "serial/pty"), 2: f"socket://{tcp}", 3: f"rfc2217://{rfc2217}"}
        for number in self.ports:
            (self.folder / f"count.I{number:02}").write_text(COUNT)
        (self.folder / "long.I01").write_text(LONG)

    def port(self, number: int) -> ArpPort:
        return ArpPort.open(self.ports[number], number, 115200)

    def arp(self, number: int, *arguments: str, script: str | None = None) -> subprocess.CompletedProcess[str]:
        port = ("--port", self.ports[number], "--baud", "115200")
        return forked_cli.run(("arp", *arguments, *port), self.folder, self.environment, script or "", PATIENCE_S)

    def said(self, number: int, *arguments: str) -> str:
        """Return the output of a command that succeeds."""
        found = self.arp(number, *arguments)
        assert found.returncode == 0, found.stderr
        return found.stdout

    def fresh(self, number: int) -> None:
        """Reset, with the counting program in it, which is held."""
        self.said(number, "reset")
        self.said(number, "download", f"count.I{number:02}")

    def told(self, number: int) -> dict[str, Any]:
        state: dict[str, Any] = json.loads(self.said(number, "state", "--json"))
        return state


@pytest.fixture(scope="module")
def cards() -> Iterator[Cards]:
    with Cards() as running:
        running.until_ready()
        yield running


def test_lines_to_copy_reach_the_cards(cards: Cards) -> None:
    lines = cards.lines()
    for number in (1, 2, 3):
        said = cards.tool(*lines[f"card{number} USER port"].split()[1:])
        assert (said.returncode, said.stdout.splitlines()[0][:8]) == (0, f"card {number:02}:"), said.stderr


def test_lines_to_copy_find_a_rig_that_is_not_where_rigs_are(cards: Cards) -> None:
    """Run as printed, in a shell that knows nothing of the rig."""
    command = cards.lines()["card2 state"].split()
    environment = {key: value for key, value in os.environ.items() if key not in ("FIELDRIG_CONTROL", "PATH")}
    program = cards.folder / command[0] if "/" in command[0] else shutil.which(command[0])
    done = subprocess.run(
        [str(program), *command[1:]], cwd=cards.folder, env=environment, capture_output=True, text=True
    )
    assert (done.returncode, done.stdout[:12]) == (0, "card2/state "), done.stderr


@pytest.mark.manual("ARP-004", "ARP-117")
@pytest.mark.parametrize("number", [1, 2, 3])
def test_from_a_source_to_a_program_that_runs(cards: Cards, number: int) -> None:
    cards.said(number, "reset")
    assert f"in card {number:02}, which runs it" in cards.said(
        number, "download", f"count.I{number:02}", "--stop", "--run"
    )
    state = cards.told(number)
    assert (state["number"], state["name"], state["state"], state["program"]) == (number, "count", "RUN", "running")
    rows = [json.loads(line) for line in cards.said(number, "watch", "V1", "STATE", "-n", "3", "--json").splitlines()]
    counts = [row["V1"] for row in rows]
    assert counts == sorted(set(counts))
    assert {row["STATE"] for row in rows} == {"RUN"}
    stopped = cards.said(number, "stop")
    assert stopped.startswith(f"card {number:02}: STOPPED")
    assert "program count: stopped, line " in stopped
    assert cards.said(number, "set", "V1=7.5", "F5=on") == "V1 = 7.5\nF5 = 1\n"
    assert cards.said(number, "get", "V1", "F5", "FLAG1") == "V1 = 7.5\nF5 = 1\n@FLAG1 = H00000010\n"
    assert cards.said(number, "run").startswith(f"card {number:02}: RUN")
    assert cards.said(number, "reset").startswith(f"card {number:02}: RESET_COMMAND")


@pytest.mark.parametrize("name", ["card1", "card2", "card3"])
def test_a_card_is_found_by_its_rig(cards: Cards, name: str) -> None:
    found = cards.tool("arp", "state", "--json", "--rig", str(cards.file), "--card", name)
    assert found.returncode == 0, found.stderr
    assert json.loads(found.stdout)["number"] == int(name[-1])


def test_a_trace_as_csv(cards: Cards) -> None:
    cards.fresh(2)
    cards.said(2, "run")
    head, *lines = cards.said(2, "watch", "V1", "POS1", "--loops", "5", "--csv", "-n", "20").splitlines()
    assert head == "time,loop,lost,V1,@POS1"
    loops = [int(line.split(",")[1]) for line in lines]
    assert [loop - loops[0] for loop in loops] == list(range(0, 100, 5))


def test_parameters_are_changed_in_ram_and_for_good(cards: Cards) -> None:
    cards.said(3, "params", "write", "PAR1.11=3")
    cards.said(3, "params", "write", "PAR1.12=4", "--flash")
    found = json.loads(cards.said(3, "params", "read", "PAR1", "--json"))
    assert (found["@PAR1[11]"], found["@PAR1[12]"]) == ({"ram": 3, "flash": 1}, {"ram": 4, "flash": 4})
    assert cards.said(3, "params", "save") == "@PAR1[11] = 3 in flash, was 1\n1 parameter saved\n"
    assert cards.tool("restart", "card3").returncode == 0
    found = json.loads(cards.said(3, "params", "read", "PAR1", "--json"))
    assert (found["@PAR1[11]"], found["@PAR1[12]"]) == ({"ram": 3, "flash": 3}, {"ram": 4, "flash": 4})


# ---- what goes wrong


def test_a_program_that_can_not_be_compiled_changes_nothing(cards: Cards) -> None:
    cards.fresh(1)
    (cards.folder / "wrong.I01").write_text("BEG M\nV1001 == 1\nEND\n")
    found = cards.arp(1, "download", "wrong.I01", "--stop")
    assert found.returncode == 2
    assert "wrong.I01:2:1" in found.stderr
    assert cards.told(1)["name"] == "count"


def test_a_program_for_another_card_is_refused(cards: Cards) -> None:
    found = cards.arp(1, "download", "count.I02")
    assert (found.returncode, "number 01, not 02" in found.stderr) == (6, True)
    assert "NAME.I01" in found.stderr


@pytest.mark.manual("ARP-117")
def test_a_running_program_is_not_replaced_unless_it_is_to_be_stopped(cards: Cards) -> None:
    cards.fresh(1)
    cards.said(1, "run")
    found = cards.arp(1, "download", "long.I01")
    assert (found.returncode, "--stop" in found.stderr) == (6, True)
    assert cards.told(1)["name"] == "count"
    cards.said(1, "download", "long.I01", "--stop")
    assert cards.told(1)["name"] == "long"


def test_a_port_without_a_card_and_no_port(cards: Cards) -> None:
    found = cards.tool("arp", "state", "--port", "socket://127.0.0.1:1")
    assert (found.returncode, "expected a device" in found.stderr) == (3, True)
    found = cards.tool("arp", "state")
    assert (found.returncode, "--port PORT" in found.stderr) == (2, True)
    found = cards.tool("arp", "state", "--rig", str(cards.file))
    assert (found.returncode, "--card card1 or card2 or card3" in found.stderr) == (3, True)
    found = cards.tool("arp", "watch", "X1", "--port", "/dev/null")
    assert (found.returncode, "V1, F3" in found.stderr) == (2, True)


NEW = encode(compile_text(LONG), "long", 1)


def send_blocks(card: ArpPort, count: int) -> None:
    card.request(Command.DOWNLOAD_BEGIN, WHOLE.pack(len(NEW), zlib.crc32(NEW)))
    for offset in range(0, len(NEW), LARGEST_BLOCK)[:count]:
        card.request(Command.DOWNLOAD_BLOCK, BLOCK.pack(offset) + NEW[offset : offset + LARGEST_BLOCK])


@pytest.mark.parametrize(("blocks", "is_committed"), [(0, False), (3, False), (1_000, False), (1_000, True)])
def test_kill_9_leaves_the_old_program_until_the_download_is_committed(
    cards: Cards, blocks: int, is_committed: bool
) -> None:
    cards.fresh(1)
    restarts = cards.status()["processes"]["card1"]["restarts"]
    with cards.port(1) as card:
        old = card.upload()
        send_blocks(card, blocks)
        if is_committed:
            card.request(Command.DOWNLOAD_COMMIT, patience_s=PATIENCE_S)
        os.kill(cards.pid("card1"), signal.SIGKILL)
    cards.until_back("card1", restarts + 1)
    with cards.port(1) as card:
        assert card.upload() == (NEW if is_committed else old)
        assert card.condition().program == ProgramCode.RUNNING


@pytest.mark.parametrize("blocks", [3, 1_000])
def test_a_pc_that_goes_away_leaves_the_old_program(cards: Cards, blocks: int) -> None:
    cards.fresh(1)
    with cards.port(1) as card:
        send_blocks(card, blocks)
    with cards.port(1) as card, pytest.raises(RefusedByCardError, match="out of order"):
        card.request(Command.DOWNLOAD_COMMIT)
    assert cards.told(1)["name"] == "count"


# ---- on a terminal


def test_a_live_table_on_a_terminal(cards: Cards) -> None:
    cards.fresh(2)
    cards.said(2, "run")
    with Terminal(
        shlex.join([*FIELDRIG, "arp", "watch", "V1", "STATE", "--port", cards.ports[2]]), cards.folder
    ) as shown:
        shown.until_shown("V1", "STATE", "RUN")
        assert shown.press(CTRL_C) == 0


def test_a_download_on_a_terminal_shows_how_far_it_is(cards: Cards) -> None:
    cards.fresh(1)
    line = shlex.join([*FIELDRIG, "arp", "download", "long.I01", "--port", cards.ports[1], "--baud", "9600"])
    with Terminal(f"{line}; read done", cards.folder) as shown:
        shown.until_shown("to card 01", "%", "long.I01: ")
        assert shown.press("\n") == 0
    assert cards.told(1)["name"] == "long"


# ---- debug

SCRIPT = "break TWICE\nrun\nwhere\nprint COUNT\nnext\nstep\ndelete\ncontinue 0\n"


def test_a_debugger_for_scripts(cards: Cards) -> None:
    cards.fresh(2)
    found = cards.arp(2, "debug", "count.I02", script=SCRIPT)
    said = found.stdout.splitlines()
    assert "(arp) run" in said
    assert "paused at TWICE, line 10: V2 == COUNT * 2" in said
    assert "returns to MAIN, line 6: WAIT 0.01" in said
    assert "paused at MAIN, line 6: WAIT 0.01" in said
    assert any(line.startswith("COUNT (V1) = ") for line in said)
    assert (found.returncode, "still runs after 0 s" in found.stderr) == (6, True)  # nothing stops it
    found = cards.arp(2, "debug", script="list 4\nquit\n")
    assert (found.returncode, "   4  V1 += 1" in found.stdout) == (0, True)  # without the source: from the card
    assert cards.arp(2, "debug", script="frobnicate\n").returncode == 2


def test_a_debugger_on_a_terminal(cards: Cards) -> None:
    cards.fresh(2)
    line = shlex.join([*FIELDRIG, "arp", "debug", "count.I02", "--port", cards.ports[2]])
    with Terminal(line, cards.folder) as terminal:
        terminal.until_shown("(arp) ")
        terminal.type("help\n")
        terminal.until_shown("To begin")
        terminal.type("run\n")
        terminal.until_shown("Ctrl-C pauses it")
        terminal.type(CTRL_C)
        terminal.until_shown("paused at ")
        terminal.type("step x\n")
        terminal.until_shown("expected 1 to 1000")
        assert terminal.press(CTRL_D) == 0
        assert "the program continues" in terminal.shown
