"""`fieldrig fault`: faults of a bus of a running rig, given, shown and cleared."""

import json
import os
import re
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from running_rig import RunningRig, until

from fieldrig import MS, US
from fieldrig.testing import free_port

pytestmark = pytest.mark.system

KINDS = Path(__file__).with_name("fault_kinds.py")
REAL = """
time: real
seed: 42
buses:
  can0: {kind: can.hub}
  free: {kind: can.hub, bitrate: null, process: can0}
  wires: {kind: wires.hub, process: can0}
  soil: {kind: "fault_kinds:Soil"}
devices:
  io: {kind: "fault_kinds:Beacon", links: {can: can0}}
  bean: {kind: "fault_kinds:Seedling", links: {soil: soil}}
"""
OUTSIDE = """
time: real
buses:
  can0: {{kind: can.udp, port: {port}, faults: [{{what: drop, identifier: 7}}]}}
devices:
  one: {{kind: "fault_kinds:Beacon", links: {{can: can0}}}}
  two: {{kind: "fault_kinds:Beacon", links: {{can: can0}}}}
"""
PERIOD_NS = 10 * MS
"""Time from one frame of a beacon to its next, which begins at power-on."""
VIRTUAL = """
time: virtual
speed: 1
buses:
  can0: {kind: can.virtual, acknowledge: always}
devices:
  io: {kind: "fault_kinds:Beacon", links: {can: can0}}
"""


@pytest.fixture(scope="module")
def real() -> Iterator[RunningRig]:
    with RunningRig(REAL, KINDS, "--trace", "all.jsonl") as rig:
        yield rig.until_ready()


def faults(rig: RunningRig) -> dict[str, Any]:
    found: dict[str, Any] = rig.ask("bus/can0/faults")
    return found


def test_a_fault_is_added_applied_shown_and_cleared(real: RunningRig) -> None:
    words = "drop identifier=0x185 count=3 probability=0.9 duration_ms=60000"
    number = real.tool("fault", "can0", *words.split()).stdout.strip()
    until(lambda: faults(real)[number]["applied"] == 3)
    assert real.json("fault", "can0")[number] == {
        "what": "drop",
        "identifier": 0x185,
        "probability": 0.9,
        "count": 3,
        "duration_ms": 60000,
        "state": "over",
        "applied": 3,
    }
    line = real.tool("fault", "can0").stdout.splitlines()[1]
    assert line.split() == [number, *words.split(), "over", "3"]
    assert real.tool("fault", "can0", "--clear", number).stdout == f"cleared: {number}\n"
    assert real.tool("fault", "can0").stdout == "none\n"


def test_a_device_takes_faults_too(real: RunningRig) -> None:
    number = real.tool("fault", "io", "mute").stdout.strip()
    assert real.json("fault", "io") == {number: {"what": "mute", "state": "on", "applied": 1}}
    assert real.tool("fault", "io", "--clear", "all").stdout == f"cleared: {number}\n"
    assert real.tool("fault", "io").stdout == "none\n"


def test_a_device_is_switched_off_and_on(real: RunningRig) -> None:
    number = real.tool("fault", "io", "power_off").stdout.strip()
    done = real.tool("get", "io")
    assert (done.returncode, "io is switched off" in done.stderr) == (6, True)
    assert real.json("fault", "io")[number] == {"what": "power_off", "state": "on", "applied": 1}
    drop = str(real.json("fault", "can0", "drop", "node=io")["number"])
    assert real.tool("fault", "io", "--clear", number).stdout == f"cleared: {number}\n"
    until(lambda: faults(real)[drop]["applied"] > 0)
    real.tool("fault", "can0", "--clear", "all")


def test_what_a_fault_does_is_in_the_trace(real: RunningRig) -> None:
    number = real.json("fault", "can0", "replace", "xor=10", "node=io")["number"]
    until(lambda: faults(real)[str(number)]["applied"] > 0)
    lines = real.tool("watch", "can0", "-n", "6").stdout
    assert f"fault {number}: data replaced, was 01" in lines
    assert "185 [1] 11" in lines
    assert real.json("fault", "can0", "--clear", "all") == {"cleared": [number]}
    assert real.json("fault", "can0", "--clear", "all") == {"cleared": []}


@pytest.mark.parametrize(
    ("arguments", "code", "what", "remedy"),
    [
        ("can0 dorp", 6, "can0: there is no fault 'dorp'", "did you mean drop?"),
        ("can0 drop identifer=3", 6, "can0: identifer: there is no such key", "did you mean identifier?"),
        ("can0 drop count=0", 6, "can0: count: 0 doesn't fit", "expected a whole number of at least 1"),
        ("can0 delay", 6, "can0: delay_ms: this key is missing", "expected a number"),
        ("can0 --clear 99", 6, "can0: there is no fault 99", "there are "),
        ("free short", 6, "free: short: only on a bus with a bitrate", "give the bus one"),
        ("wires drop", 6, "wires: there is no fault 'drop'", "did you mean drop_out?"),
        (
            "soil drop",
            6,
            "soil: fault_kinds:Soil takes no faults, because its medium is outside the rig",
            "add the fault",
        ),
        ("can0 drop node=oi", 6, "node: there is no device 'oi'", "there are: io, bean"),
        ("can0 drop receivers=[io,baen]", 6, "receivers: there is no device 'baen'", "did you mean bean?"),
        ("can1", 6, "lab has no bus or device 'can1'", "did you mean can0?"),
        ("io dumb", 6, "io: there is no fault 'dumb'", "there are: mute"),
        ("io --clear 7", 6, "io: there is no fault 7", "there are none"),
        ("bean mute", 6, "bean: there is no fault 'mute'", "there are: power_off"),
        ("can0 drop 0x185", 2, "'0x185' is no key of a fault", "write it like probability=0.1"),
        ("can0 drop count=1 count=2", 2, "count is there twice", ""),
        ("can0 drop --clear 1", 2, "not both at once", ""),
        ("can0 --clear some", 2, "'some' is no fault", "or all"),
    ],
)
def test_what_cannot_be_is_refused_with_what_would_be_right(
    real: RunningRig, arguments: str, code: int, what: str, remedy: str
) -> None:
    done = real.tool("fault", *arguments.split())
    said = " ".join(done.stderr.replace("│", " ").split())
    assert (done.returncode, what in said, remedy in said) == (code, True, True), done.stderr
    assert "Traceback" not in done.stderr


def test_a_bus_whose_medium_is_not_the_rigs_takes_faults_at_every_end() -> None:
    with RunningRig(OUTSIDE.format(port=free_port()), KINDS) as rig:
        rig.until_ready()
        assert rig.json("fault", "can0") == {"1": {"what": "drop", "identifier": 0x7, "state": "on", "applied": 0}}
        assert rig.tool("fault", "can0", "replace", "data=77", "node=two").stdout == "2\n"
        until(lambda: rig.json("fault", "can0")["2"]["applied"] > 0)

        def is_shown(line: str) -> bool:  # what each process has sent comes in bundles
            return re.search(line, rig.tool("watch", "can0", "-n", "6").stdout) is not None

        until(lambda: is_shown(r"can0 +two +fault 2: data replaced, was 01"))
        until(lambda: is_shown(r"can0 +two +185 \[1\] 77"))
        until(lambda: is_shown(r"can0 +one +185 \[1\] 01"))
        refused = rig.tool("fault", "can0", "corrupt")
        assert (refused.returncode, "there are: drop, delay, duplicate, replace" in refused.stderr) == (6, True)
        assert rig.tool("fault", "can0", "--clear", "9").returncode == 6
        assert rig.json("fault", "can0", "--clear", "2") == {"cleared": [2]}
        assert rig.tool("fault", "can0", "drop").stdout == "3\n"
        assert rig.json("fault", "can0", "--clear", "all") == {"cleared": [1, 3]}
        assert rig.tool("fault", "can0").stdout == "none\n"


def test_under_virtual_time_a_fault_starts_at_the_present_instant() -> None:
    with RunningRig(VIRTUAL, KINDS) as rig:
        rig.until_ready()
        rig.json("pause")
        number = str(rig.json("fault", "can0", "drop", "duration_ms=1000")["number"])
        assert faults(rig)[number]["state"] == "on"
        rig.json("step", "2s")
        assert rig.json("fault", "can0")[number] == {
            "what": "drop",
            "duration_ms": 1000,
            "state": "over",
            "applied": 100,
        }
        assert rig.json("fault", "can0", "--clear", number) == {"cleared": [int(number)]}
        late_ns = rig.json("step", "1ms")["now_ns"] % PERIOD_NS
        rig.json("step", f"{(PERIOD_NS * 3 // 2 - late_ns) // US}us")  # no frame is on the bus there
        before = rig.ask("bus/can0/status")["frames"]
        rig.tool("restart", "io")
        rig.json("step", "1ms")
        assert rig.ask("bus/can0/status")["frames"] == before + 1  # at power-on, and not when it was due
        unknown = rig.tool("restart", "oi")
        assert (unknown.returncode, "no device 'oi'" in unknown.stderr) == (6, True)
        refused = rig.tool("fault", "can0", "drop", "identifer=3")
        assert (refused.returncode, "did you mean identifier?" in refused.stderr) == (6, True)


def test_an_end_of_a_direct_bus_gets_the_seed_of_its_rig(real: RunningRig) -> None:
    def told() -> list[str]:
        messages = map(json.loads, (real.folder / "all.jsonl").read_text().splitlines())
        return [bytes.fromhex(message["data"]).decode() for message in messages if message["bus"] == "soil"]

    until(lambda: told() != [])
    assert told() == ['["seed",42,""]']


def test_a_bus_without_a_process_is_distinguished_from_a_bus_that_takes_no_faults() -> None:
    with RunningRig(REAL.replace("can: can0}}", "can: can0}, process: can0, on_exit: ignore}"), KINDS) as rig:
        os.kill(rig.until_ready().pid("can0"), signal.SIGKILL)
        until(lambda: rig.status()["processes"]["can0"]["state"] == "gone")
        done = rig.tool("fault", "can0")
        assert (done.returncode, "can0 does not answer" in done.stderr) == (6, True), done.stderr
