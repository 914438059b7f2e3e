"""`fieldrig iec` and `fieldrig debug` with a MAx-4 and an ARP card in processes of their own, and DAP over stdio.

The client of the Debug Adapter Protocol is a small one of our own; `tests/real` has a foreign one.
"""

import json
import shlex
import signal
import subprocess
from collections.abc import Iterator
from types import TracebackType
from typing import Any, Self
from xml.etree import ElementTree as ET

import pytest
from patience import PATIENCE_S
from running_rig import AskedRig
from terminal import Terminal

from fieldrig.real.live_rig import FIELDRIG

pytestmark = pytest.mark.system

CTRL_C, CTRL_D = "\x03", "\x04"
COUNT = """\
FUNCTION Twice : INT
VAR_INPUT x : INT; END_VAR
Twice := x * 2;
END_FUNCTION
PROGRAM PLC_PRG
VAR a : INT; b : INT; t : UDINT; END_VAR
a := a + 1;
b := Twice(a);
t := PacDriveM.Timer1;
END_PROGRAM
"""
IN_FUNCTION, FIRST, CALL = 3, 7, 8
BASIC = """\
COUNT EQU V1
BEG MAIN
LOOP:
COUNT += 1
WAIT 0.01
GOTO LOOP
END
"""


class Machine(AskedRig):
    """A controller without drives, and a card with Enable closed."""

    def __init__(self) -> None:
        super().__init__(
            """
time: real
buses:
  wires: {kind: wires.hub}
devices:
  controller: {kind: max4, links: {wires: wires}}
  card: {kind: arp, number: 1, program: count.I01, inputs: {I108: true}, links: {wires: wires}}
""",
            None,
        )

    def up(self, *options: str) -> subprocess.Popen[bytes]:
        (self.folder / "count.st").write_text(COUNT)
        (self.folder / "count.I01").write_text(BASIC)
        return super().up(*options)

    def said(self, *arguments: str) -> str:
        done = self.tool(*arguments)
        assert done.returncode == 0, done.stderr
        return done.stdout

    def debug(self, device: str, *lines: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [*FIELDRIG, "debug", device],
            cwd=self.folder,
            env=self.environment,
            input="".join(f"{line}\n" for line in lines),
            capture_output=True,
            text=True,
            timeout=PATIENCE_S,
            check=False,
        )

    def loaded(self) -> None:
        """Start again with the counting program."""
        self.said("iec", "download", "controller", "count.st", "--start")

    def is_left_alone(self) -> None:
        """Assert that no session has left a breakpoint, or a program that stands."""
        ask = self.control.ask
        assert ask("device/controller/debug", {"command": "breakpoints"}) == {"breakpoints": []}
        assert ask("device/controller/debug", {"command": "state"})["state"] == "running"


@pytest.fixture(scope="module")
def machine() -> Iterator[Machine]:
    with Machine() as running:
        running.until_ready()
        yield running


def answers(done: subprocess.CompletedProcess[str]) -> dict[str, list[str]]:
    """Return what a script's commands have said, by the command."""
    assert done.returncode == 0, done.stderr
    found: dict[str, list[str]] = {}
    command = ""
    for line in done.stdout.splitlines():
        if line.startswith("(debug) "):
            command = line.removeprefix("(debug) ")
            found[command] = []
        elif command:
            found[command].append(line)
    return found


# ---- fieldrig iec


def test_a_download_runs_and_changes_online(machine: Machine) -> None:
    assert "count.st downloaded; the program is running" in machine.said(
        "iec", "download", "controller", "count.st", "--start"
    )
    (machine.folder / "faster").mkdir(exist_ok=True)
    (machine.folder / "faster/count.st").write_text(COUNT.replace("a + 1", "a + 1000"))
    before = int(answers(machine.debug("controller", "print PLC_PRG.t"))["print PLC_PRG.t"][0].split()[-1])
    assert "changed online" in machine.said("iec", "download", "controller", "faster", "--online")
    found = answers(machine.debug("controller", "break 7 if a > 2000", "run 60", "print PLC_PRG.t"))
    assert int(found["print PLC_PRG.t"][0].split()[-1]) > before


def test_a_program_with_mistakes_is_listed_and_changes_nothing(machine: Machine) -> None:
    machine.loaded()
    (machine.folder / "wrong.st").write_text(COUNT.replace("b := Twice(a);", "b := Twice(c);"))
    done = machine.tool("iec", "download", "controller", "wrong.st")
    assert (done.returncode, f"wrong.st:{CALL}:12: c is not declared" in done.stderr) == (2, True), done.stderr
    state = machine.control.ask("device/controller/debug", {"command": "state"})
    assert state["state"] == "running"
    assert machine.control.ask("device/controller/debug", {"command": "files"}) == {"files": ["count.st"]}


def test_the_cycles_go_on_while_a_large_program_is_compiled(machine: Machine) -> None:
    machine.loaded()
    blocks = "".join(
        f"FUNCTION_BLOCK Block{number}\nVAR_INPUT x : INT; END_VAR\nVAR y : INT; END_VAR\n"
        f"IF x > {number} THEN\n  y := y + x;\nELSE\n  y := 0;\nEND_IF\nEND_FUNCTION_BLOCK\n"
        for number in range(400)
    )
    (machine.folder / "large.st").write_text(blocks + COUNT)
    command = [*FIELDRIG, "iec", "download", "controller", "large.st"]
    with subprocess.Popen(command, cwd=machine.folder, env=machine.environment, stdout=subprocess.PIPE) as download:
        seen = []
        while download.poll() is None:
            progress, cycles = (machine.get(f"controller/{point}") for point in ("plc/progress", "cycles"))
            if progress:
                seen.append(cycles)
    assert download.returncode == 0
    assert len(seen) > 5
    assert seen[-1] > seen[0]


def test_what_refuses_a_download(machine: Machine) -> None:
    assert machine.tool("iec", "download", "nobody", "count.st").returncode == 6
    refused = machine.tool("iec", "download", "card", "count.st")
    assert (refused.returncode, "the program is running" in refused.stderr) == (6, True)
    assert machine.tool("iec", "download", "controller", "missing.st").returncode == 2


def test_the_symbols_of_a_running_controller(machine: Machine) -> None:
    machine.loaded()
    machine.said("iec", "symbols", "count.xml", "--device", "controller")
    names = {node.get("name") for node in ET.parse(machine.folder / "count.xml").iter()}
    assert names >= {"PLC_PRG", "a", "b", "t"}
    assert machine.tool("iec", "symbols", "card.xml", "--device", "card").returncode == 6


@pytest.mark.parametrize("words", [("count.st",), ("count.st", "count.st"), ("project.xml", "project.xml")])
def test_no_source_is_replaced_by_a_list_of_symbols(machine: Machine, words: tuple[str, ...]) -> None:
    (machine.folder / "project.xml").write_text("<project/>")
    before = [(machine.folder / name).read_text() for name in ("count.st", "project.xml")]
    done = machine.tool("iec", "symbols", *words)
    assert (done.returncode, "is a source file" in done.stderr) == (2, True)
    assert [(machine.folder / name).read_text() for name in ("count.st", "project.xml")] == before


def test_a_check_for_the_controller_of_the_rig_file(machine: Machine) -> None:
    assert machine.tool("iec", "check", "count.st").returncode == 2
    assert "Code Size" in machine.said("iec", "check", "count.st", "--rig", "lab.yaml", "--device", "controller")


# ---- fieldrig debug


def test_a_session_with_the_controller(machine: Machine) -> None:
    machine.loaded()
    found = answers(
        machine.debug(
            "controller",
            f"break {CALL}",
            "run 60",
            "set PLC_PRG.a=40",
            "step",
            "where",
            "print x",
            "out",
            "next",
            "print a b",
            "delete",
            "force PLC_PRG.b=7",
            "forced",
            "release",
            "trace PLC_PRG.a depth 3 csv",
        )
    )
    assert found["step"] == [f"PLC_PRG paused at Twice, count.st:{IN_FUNCTION}: Twice := x * 2;"]
    assert found["where"][1].startswith(f"called at PLC_PRG, count.st:{CALL}")
    assert (found["print x"], found["print a b"]) == (["x = 40"], ["PLC_PRG.a = 40", "PLC_PRG.b = 80"])
    assert found["forced"] == ["PLC_PRG.b = 7 (forced)"]
    assert found["trace PLC_PRG.a depth 3 csv"][0] == "time/s,PLC_PRG.a"


def test_a_session_with_the_card(machine: Machine) -> None:
    found = answers(
        machine.debug("card", "break 4 if COUNT % 10 = 0", "stop", "run 60", "where", "print COUNT", "list")
    )
    assert found["where"] == ["MAIN, count.I01:4: COUNT += 1"]
    assert int(found["print COUNT"][0].split()[2]) % 10 == 0
    assert ">*    4  COUNT += 1" in found["list"]
    assert machine.control.ask("device/card/debug", {"command": "state"})["state"] == "running"


def test_a_script_ends_at_its_first_mistake(machine: Machine) -> None:
    machine.loaded()
    wrong = machine.debug("controller", "dance", "state")
    assert (wrong.returncode, "'dance' is not a command" in wrong.stderr, "(debug) state" in wrong.stdout) == (
        2,
        True,
        False,
    )
    assert machine.debug("controller", "print PLC_PRG.c").returncode == 2
    assert machine.debug("controller", "reset hot").returncode == 6
    unknown = machine.debug("controller", "trace PLC_PRG.c depth 3")
    assert (unknown.returncode, "not a variable" in unknown.stderr) == (6, True)
    slow = machine.debug("controller", "break 7 if a = -5", "run 0.1")
    assert (slow.returncode, "the program still runs after 0.1 s" in slow.stderr) == (6, True)
    stopped = machine.debug("controller", "break 8", "run", "dance")
    assert "PLC_PRG paused" in stopped.stdout
    machine.is_left_alone()
    assert machine.debug("nobody", "state").returncode == 6


def test_a_terminal_where_ctrl_c_pauses_the_program(machine: Machine) -> None:
    machine.loaded()
    line = shlex.join([*FIELDRIG, "debug", "controller", "--control", machine.endpoint])
    with Terminal(line, machine.folder) as terminal:
        terminal.until_shown("(debug) ")
        terminal.type("help\n")
        terminal.until_shown("To begin")
        terminal.type("break 7 if a = -5\n")
        terminal.until_shown("breakpoint at count.st:7")
        terminal.type("run\n")
        terminal.until_shown("Ctrl-C pauses it")
        terminal.type(CTRL_C)
        terminal.until_shown("PLC_PRG paused")
        terminal.type("step x\n")
        terminal.until_shown("expected 1 to 1000")
        assert terminal.press(CTRL_D) == 0
        assert "the program continues" in terminal.shown


# ---- the Debug Adapter Protocol


class Editor:
    """A client of the Debug Adapter Protocol that starts `fieldrig debug-adapter`, as an editor does."""

    def __init__(self, machine: Machine, device: str) -> None:
        self._process = subprocess.Popen(
            [*FIELDRIG, "debug-adapter", device],
            cwd=machine.folder,
            env=machine.environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )
        self._sequence = 0
        self._events: list[dict[str, Any]] = []

    def request(self, command: str, **arguments: Any) -> Any:
        """Send a request, and return the body of its response; events that come before it are kept."""
        self._sequence += 1
        message = {"seq": self._sequence, "type": "request", "command": command, "arguments": arguments}
        body = json.dumps(message).encode()
        assert self._process.stdin is not None
        self._process.stdin.write(b"Content-Length: %d\r\n\r\n" % len(body) + body)
        self._process.stdin.flush()
        while (heard := self._read())["type"] != "response":
            self._events.append(heard)
        assert (heard["request_seq"], heard["success"]) == (self._sequence, True), heard
        return heard["body"]

    def event(self, name: str) -> dict[str, Any]:
        """Wait for an event, and return its body; events before it are dropped."""
        while True:
            heard = self._events.pop(0) if self._events else self._read()
            if heard["event"] == name:
                body: dict[str, Any] = heard["body"]
                return body

    def end(self, number: signal.Signals) -> None:
        self._process.send_signal(number)

    def die(self) -> None:
        """Close both streams, as an editor that has crashed."""
        for stream in (self._process.stdin, self._process.stdout):
            assert stream is not None
            stream.close()

    def ended(self) -> int:
        return self._process.wait(PATIENCE_S)

    def _read(self) -> dict[str, Any]:
        stream = self._process.stdout
        assert stream is not None
        size = 0
        while line := stream.readline().strip():
            name, _, value = line.partition(b":")
            if name.lower() == b"content-length":
                size = int(value)
        assert size, "the adapter has ended"
        message: dict[str, Any] = json.loads(stream.read(size))
        return message

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, fault: BaseException | None, tb: TracebackType | None) -> None:
        self._process.kill()
        self._process.wait()
        for stream in (self._process.stdin, self._process.stdout):
            assert stream is not None
            stream.close()


def test_an_editor_debugs_over_standard_input_and_output(machine: Machine) -> None:
    machine.loaded()
    with Editor(machine, "controller") as editor:
        assert editor.request("initialize", adapterID="fieldrig")["supportsConditionalBreakpoints"] is True
        editor.event("initialized")
        editor.request("attach", sources=str(machine.folder))
        source = {"path": str(machine.folder / "count.st")}
        set_ = editor.request("setBreakpoints", source=source, breakpoints=[{"line": CALL, "condition": "a > 5"}])
        assert set_["breakpoints"] == [{"id": 1, "verified": True, "line": CALL}]
        editor.request("configurationDone")
        stopped = editor.event("stopped")
        assert stopped["reason"] == "breakpoint"
        thread = stopped["threadId"]
        (frame,) = editor.request("stackTrace", threadId=thread)["stackFrames"]
        assert (frame["line"], frame["source"]["path"]) == (CALL, source["path"])
        assert int(editor.request("evaluate", expression="a", frameId=frame["id"])["result"]) > 5
        editor.request("stepIn", threadId=thread)
        assert editor.event("stopped")["reason"] == "step"
        frames = editor.request("stackTrace", threadId=thread)["stackFrames"]
        assert [(one["name"], one["line"]) for one in frames] == [("Twice", IN_FUNCTION), ("PLC_PRG", CALL)]
        forced = editor.request("fieldrig.force", values={"PLC_PRG.b": 3})["variables"]
        assert forced[0]["is_forced"] is True
        editor.request("fieldrig.release", names=["PLC_PRG.b"])
        editor.request("disconnect")
        assert editor.ended() == 0
    assert machine.control.ask("device/controller/debug", {"command": "state"})["state"] == "running"


@pytest.mark.parametrize("how", ["crash", "signal"])
def test_an_editor_that_dies_leaves_nothing_behind(machine: Machine, how: str) -> None:
    machine.loaded()
    with Editor(machine, "controller") as editor:
        editor.request("initialize", adapterID="fieldrig")
        editor.request("attach", sources=str(machine.folder))
        source = {"path": str(machine.folder / "count.st")}
        editor.request("setBreakpoints", source=source, breakpoints=[{"line": CALL}])
        editor.event("stopped")
        if how == "crash":
            editor.die()
        else:
            editor.end(signal.SIGTERM)
        editor.ended()
    machine.is_left_alone()
