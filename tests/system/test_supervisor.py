"""Processes of a rig in real time: they start in order, are started again, and leave nothing behind."""

import os
import re
import shlex
import signal
import stat
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from lamp_rig import KINDS, lamp_rig
from running_rig import RunningRig, is_running, until
from terminal import Terminal

from fieldrig.real.live_rig import FIELDRIG
from fieldrig.testing import free_port

pytestmark = pytest.mark.system

LAMP = lamp_rig()


def with_device(entry: str) -> str:
    return f"{LAMP}  extra: {{{entry}}}\n"


@pytest.fixture
def rig() -> Iterator[RunningRig]:
    with RunningRig(LAMP, KINDS) as rig:
        yield rig.until_ready()


def pids(rig: RunningRig) -> dict[str, int]:
    return {name: process["pid"] for name, process in rig.status()["processes"].items()}


def assert_nothing_is_left(rig: RunningRig, processes: dict[str, int]) -> None:
    assert not [name for name, pid in processes.items() if is_running(pid)]
    left = [path for path in rig.run.rglob("*") if path.is_symlink() or stat.S_ISSOCK(path.lstat().st_mode)]
    assert not left


def switch(rig: RunningRig, is_on: bool) -> None:
    assert rig.tool("set", f"switch/on={str(is_on).lower()}").returncode == 0
    until(lambda: rig.value("lamp/on") is is_on)


def test_every_device_and_the_hub_run_in_processes_of_their_own_and_talk(rig: RunningRig) -> None:
    processes = pids(rig)
    assert set(processes) == {"wires", "lamp", "switch"}
    assert len({*processes.values(), rig.process.pid}) == 4
    switch(rig, True)
    assert "ready in" in rig.output()


def test_sigterm_leaves_no_process_no_socket_and_no_pty() -> None:
    text = LAMP.replace("devices:", "  can0: {kind: can.hub, slcan: {path: slcan}}\ndevices:")
    with RunningRig(text, KINDS) as rig:
        processes = pids(rig.until_ready())
        assert (rig.run / "slcan").is_symlink()
        assert (rig.run / "wires.sock").is_socket()
        assert rig.end(signal.SIGTERM) == 0
        assert_nothing_is_left(rig, processes)


def test_ctrl_c_while_it_starts_leaves_nothing_either() -> None:
    with RunningRig(with_device('kind: "lamp_kinds:Stuck"'), KINDS) as rig:
        rig.until_there()
        processes = pids(rig)
        assert rig.end(signal.SIGINT) == 0
        assert_nothing_is_left(rig, processes)


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
def test_a_signal_as_soon_as_there_is_a_process_leaves_none(number: signal.Signals) -> None:
    with RunningRig(LAMP, KINDS) as rig:
        children = Path(f"/proc/{rig.process.pid}/task/{rig.process.pid}/children")
        until(lambda: bool(children.read_text(encoding="utf-8")) or rig.process.poll() is not None)
        born = [int(pid) for pid in children.read_text(encoding="utf-8").split()]
        rig.end(number)
        assert born
        assert not [pid for pid in born if Path(f"/proc/{pid}").exists()]


@pytest.mark.skipif(sys.platform != "linux", reason="only there processes are forked")
def test_a_signal_that_python_drops_while_the_rig_starts_still_ends_it() -> None:
    rig_file = """
time: real
buses:
  wires: {kind: wires.hub}
devices:
  idle: {kind: "interrupted_kinds:Idle", links: {wires: wires}}
"""
    with RunningRig(rig_file, KINDS.with_name("interrupted_kinds.py")) as rig:
        assert rig.ended() == 0
        assert "KeyboardInterrupt" in rig.output()


def test_a_terminal_shows_how_busy_the_buses_are(tmp_path: Path) -> None:
    (tmp_path / "lab.yaml").write_text("time: real\nbuses: {can0: {kind: can.hub}}\n")
    line = f"{shlex.join(FIELDRIG)} up lab.yaml --control tcp/127.0.0.1:{free_port()}"
    with Terminal(line, tmp_path) as terminal:
        terminal.until_shown("can0 0 frames/s 0 %")
        assert terminal.press("\x03") == 0


def test_a_second_ctrl_c_waits_for_no_process() -> None:
    with RunningRig(with_device('kind: "lamp_kinds:Clinging"'), KINDS) as rig:
        processes = pids(rig.until_ready())
        rig.process.send_signal(signal.SIGINT)
        until(lambda: "stopping" in rig.output())
        assert rig.end(signal.SIGINT) == 0
        assert "at once" in rig.output()
        assert_nothing_is_left(rig, processes)


def test_when_the_supervisor_is_killed_its_processes_end_and_the_next_rig_starts(rig: RunningRig) -> None:
    processes = pids(rig)
    rig.end(signal.SIGKILL)
    until(lambda: not any(is_running(pid) for pid in processes.values()))
    rig.process = rig.up()
    rig.until_ready()
    switch(rig, True)


def test_a_killed_device_comes_back_with_its_memory_while_the_others_go_on(rig: RunningRig) -> None:
    switch(rig, True)
    before = pids(rig)
    signal_to(before["lamp"], signal.SIGKILL)
    rig.until_back("lamp")
    after = pids(rig)
    assert after["lamp"] != before["lamp"]
    assert {after["wires"], after["switch"]} == {before["wires"], before["switch"]}
    assert rig.value("lamp/times") >= 1
    switch(rig, False)
    assert "lamp died: killed by SIGKILL" in rig.output()


def test_devices_find_their_hub_again_when_it_was_killed(rig: RunningRig) -> None:
    before = pids(rig)
    signal_to(before["wires"], signal.SIGKILL)
    rig.until_back("wires")

    def goes_through() -> bool:
        is_on = not rig.value("switch/on")
        rig.tool("set", f"switch/on={str(is_on).lower()}")
        return rig.value("lamp/on") is is_on

    until(goes_through)
    after = pids(rig)
    assert {after["lamp"], after["switch"]} == {before["lamp"], before["switch"]}


def test_a_fault_in_a_devices_code_is_in_its_log_and_it_is_started_again() -> None:
    with RunningRig(with_device('kind: "lamp_kinds:Fragile"'), KINDS) as rig:
        rig.until_ready()
        rig.tool("set", "extra/hit=true")
        rig.until_back("extra")
        assert "RuntimeError: hit too hard" in rig.log("extra")
        assert re.search(
            r"extra died: exit code 70: a device's code failed \(RuntimeError: hit too hard, "
            r"in device extra, in a timer or call of its own, at \d+ ns\); starting it again",
            rig.output(),
        )


def test_an_exception_inside_a_device_names_the_device_the_bus_and_the_time() -> None:
    shy = 'kind: "lamp_kinds:Shy", links: {wires: wires}, process: pair'
    with RunningRig(with_device(shy).replace("switch: {", "switch: {process: pair, "), KINDS) as rig:
        rig.until_ready()
        rig.tool("set", "switch/on=true")
        until(lambda: rig.status()["processes"]["pair"]["restarts"] > 0)
        assert re.search(r"too bright\nin device extra, with a message of bus wires, at \d+ ns\n", rig.log("pair"))


def test_on_exit_stop_ends_the_rig() -> None:
    with RunningRig(with_device('kind: "lamp_kinds:Fragile", on_exit: stop'), KINDS) as rig:
        processes = pids(rig.until_ready())
        rig.tool("set", "extra/hit=true")
        assert rig.ended() == 5
        assert "hit too hard" in rig.output()  # the end of its log
        assert_nothing_is_left(rig, processes)


def test_on_exit_ignore_lets_the_rest_go_on() -> None:
    with RunningRig(with_device('kind: "lamp_kinds:Fragile", on_exit: ignore'), KINDS) as rig:
        rig.until_ready()
        rig.tool("set", "extra/hit=true")
        until(lambda: rig.status()["processes"]["extra"]["state"] == "gone")
        switch(rig, True)
        assert rig.status()["processes"]["extra"]["pid"] is None


def test_restart_is_a_power_cycle_of_a_device_or_another_process_of_a_bus(rig: RunningRig) -> None:
    before = pids(rig)
    switch(rig, True)
    assert rig.tool("restart", "lamp").returncode == 0
    assert "lamp was switched off and on" in rig.log("lamp")
    assert pids(rig) == before
    assert rig.tool("restart", "wires").returncode == 0
    rig.until_back("wires")
    after = pids(rig)
    assert (after["wires"] != before["wires"], after["lamp"]) == (True, before["lamp"])
    switch(rig, False)
    switch(rig, True)
    refused = rig.tool("restart", "bell")
    assert refused.returncode == 6
    assert "there are: wires, lamp, switch" in refused.stderr


def test_a_device_that_cannot_start_is_named_with_the_end_of_its_log() -> None:
    with RunningRig(with_device('kind: "lamp_kinds:Broken"'), KINDS) as rig:
        assert rig.ended() == 5
        assert "extra ended while it started: exit code 70" in rig.output()
        assert "RuntimeError: the fuse is blown" in rig.output()
        assert not list(rig.run.glob("*.sock"))


def test_a_device_that_never_gets_ready_is_named() -> None:
    with RunningRig(with_device('kind: "lamp_kinds:Stuck"') + "start_timeout_s: 1.5\n", KINDS) as rig:
        assert rig.ended() == 5
        assert "extra made no progress while it started: for 1.5 s (its last step: starting extra)" in rig.output()
        assert "set start_timeout_s: 3 in the rig file" in rig.output()


def test_a_process_that_hangs_when_it_is_started_again_is_reported_even_if_quiet_and_comes_back() -> None:
    entry = 'kind: "lamp_kinds:Hanging", links: {wires: wires}'
    with RunningRig(with_device(entry) + "start_timeout_s: 3\n", KINDS, "--quiet") as rig:
        signal_to(pids(rig.until_ready())["extra"], signal.SIGKILL)
        rig.until_back("extra", restarts=2)
        for said in (
            "extra died: killed by SIGKILL; starting it again",
            "s (its last step: starting extra); killing it",
            "on a busy host set start_timeout_s: ",
            "extra is back",
        ):
            assert said in rig.output()
        assert "supervisor: late: made no progress" in rig.log("extra")


def test_a_taken_port_is_named_with_its_remedy(free_port: int) -> None:
    import socket

    text = LAMP.replace("devices:", f'  can0: {{kind: can.hub, socketcand: "127.0.0.1:{free_port}"}}\ndevices:')
    with socket.create_server(("127.0.0.1", free_port)), RunningRig(text, KINDS) as rig:
        assert rig.ended() == 3
        assert str(free_port) in rig.output()
        assert "choose another port" in rig.output()


def test_a_second_rig_on_the_same_endpoint_or_folder_is_refused(rig: RunningRig) -> None:
    assert rig.up().wait(30) == 3
    assert f"cannot listen on the control endpoint {rig.endpoint}" in rig.output()
    elsewhere = rig.up("--control", f"unixsock-stream/{rig.folder}/c")
    assert elsewhere.wait(30) == 3
    assert f"another rig runs in {rig.run} (process {rig.process.pid})" in rig.output()
    switch(rig, True)  # the first one has not been disturbed


def signal_to(pid: int, number: signal.Signals) -> None:
    import os

    os.kill(pid, number)


@pytest.mark.skipif(sys.platform != "linux", reason="stops a process")
def test_a_process_that_the_host_makes_late_is_told_of_with_figures_in_output_status_and_log() -> None:
    with RunningRig(lamp_rig("period_ms: 20, "), KINDS, "--quiet") as rig:
        switch = rig.until_ready().pid("switch")
        os.kill(switch, signal.SIGSTOP)
        assert re.search("switch +no answer ", rig.tool("status").stdout)  # once, it was said to be ready
        os.kill(switch, signal.SIGCONT)
        until(lambda: "switch" in rig.status()["late"])
        words = r"timers are up to [0-9,]+ ms late; load [0-9]+ on [0-9]+ cores"
        assert re.fullmatch(words, rig.status()["late"]["switch"])
        shown = rig.tool("status").stdout
        assert re.search(f"the host is late for switch: {words}", shown)
        assert re.search(r"it was [0-9,]+ ms late for [a-z]+; a fault of a device at that time", shown)
        assert re.search(f"the host is late: {words}", rig.log("switch"))
        assert re.search(f"warning: the host is late: {words}", rig.output())
