"""A ring between processes: as a user runs it, breaks it, kills its drives, and looks at it."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from running_rig import RunningRig, until

from fieldrig.control.messages import Client

pytestmark = pytest.mark.system

KINDS = Path(__file__).with_name("echo_kinds.py")
RIG = """
time: real
buses:
  ring0: {kind: KIND}
devices:
  max4: {kind: "echo_kinds:Metronome", links: {ring: ring0}}
  belt: {kind: "echo_kinds:Echo", address: 3, links: {ring: ring0}}
  lift: {kind: "echo_kinds:Echo", address: 1, links: {ring: ring0}, process: rack}
  knife: {kind: "echo_kinds:Echo", address: 2, links: {ring: ring0}, process: rack}
  door: {kind: "echo_kinds:Echo", address: 4, links: {ring: ring0}, process: max4}
"""


@pytest.fixture(params=["ring.shm", "ring.zenoh"])
def ring(request: pytest.FixtureRequest) -> Iterator[RunningRig]:
    with RunningRig(RIG.replace("KIND", request.param), KINDS) as rig:
        rig.until_ready()
        until(lambda: is_whole(rig))
        yield rig


def is_whole(rig: RunningRig) -> bool:
    return bool(rig.value("max4/heard") == "3 1 2 4")


def statistics(rig: RunningRig) -> dict[str, Any]:
    answer: dict[str, Any] = rig.ask("bus/ring0/status")
    return answer


def test_all_are_heard_in_the_order_of_the_file_and_miss_nothing(ring: RunningRig) -> None:
    begin = ring.value("max4/number")
    until(lambda: ring.value("max4/number") > begin + 100)
    assert [ring.value(f"{name}/gaps") for name in ("belt", "lift", "knife", "door")] == [0, 0, 0, 0]
    assert statistics(ring)["stations"] == 4


def test_faults_are_given_and_cleared_while_it_runs(ring: RunningRig) -> None:
    assert ring.json("fault", "ring0", "break", "after=lift") == {"number": 1}
    until(lambda: ring.value("max4/closed") is False)
    assert statistics(ring)["ring_closed"] == 0
    told = ring.value("knife/told")
    until(lambda: ring.value("belt/told") > told + 10)
    assert ring.value("knife/told") <= told + 1  # one may have been under way
    assert "break" in ring.tool("fault", "ring0").stdout
    ring.json("fault", "ring0", "--clear", "1")
    until(lambda: is_whole(ring))
    refused = ring.tool("fault", "ring0", "break", "after=bolt")
    assert refused.returncode != 0
    assert "no station 'bolt'" in refused.stderr


@pytest.mark.parametrize("point", ["max4/number", "belt/told"])
def test_a_fault_begins_when_a_point_of_any_process_has_a_value(ring: RunningRig, point: str) -> None:
    at = ring.value(point) + 200
    ring.json("fault", "ring0", "break", "after=lift", f"when={point} > {at}")
    until(lambda: ring.value("max4/closed") is False)
    assert ring.value(point) >= at
    ring.json("fault", "ring0", "--clear", "1")
    until(lambda: is_whole(ring))


@pytest.mark.manual("PD-140")
def test_a_drive_that_is_killed_opens_the_ring_until_it_is_back(ring: RunningRig) -> None:
    before = statistics(ring)["cycles"]
    os.kill(ring.pid("belt"), signal.SIGKILL)
    until(lambda: ring.value("max4/closed") is False)
    ring.until_back("belt")
    until(lambda: is_whole(ring))
    assert statistics(ring)["cycles"] > before


def test_a_fault_in_the_code_of_a_drive_ends_its_process_and_is_reported(ring: RunningRig) -> None:
    ring.ask("device/belt/set", {"values": {"wrong": True}})
    ring.until_back("belt")
    assert "belt died: exit code 70: a device's code failed (RuntimeError: lost the count, " in ring.output()
    assert "in device belt, with a message of bus ring0, at " in ring.output()
    assert "Traceback" in ring.log("belt")
    until(lambda: is_whole(ring))


def test_a_master_that_is_killed_finds_its_drives_again(ring: RunningRig) -> None:
    os.kill(ring.pid("max4"), signal.SIGKILL)
    ring.until_back("max4")
    until(lambda: is_whole(ring))
    assert statistics(ring)["stations"] == 4


def test_a_process_that_stands_still_is_late_and_delays_no_other(ring: RunningRig) -> None:
    pid, before = ring.pid("rack"), statistics(ring)
    os.kill(pid, signal.SIGSTOP)
    try:
        number = ring.value("max4/number")
        until(lambda: ring.value("max4/number") > number + 60)
        until(lambda: ring.value("max4/heard") == "3 4")
        late = statistics(ring)
        assert all(late[name] - before.get(name, 0) >= 50 for name in ("late.lift", "late.knife"))
        assert late["most_cycles_late"] >= 50
    finally:
        os.kill(pid, signal.SIGCONT)
    until(lambda: is_whole(ring))


def test_status_and_watch_show_the_ring(ring: RunningRig) -> None:
    shown = ring.tool("status")
    assert "ring_closed 1" in shown.stdout, shown.stdout
    with Client(ring.endpoint) as client:
        told = (told for told in client.inbox(["watch/ring0"]) if told is not None)
        _, batch = next(told)
    senders = {sender for _, sender, _ in batch["entries"]}
    assert senders == {"ring", "max4"}
    assert any("ATs 03" in text for _, _, text in batch["entries"])
