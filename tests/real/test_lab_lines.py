"""The lines that `fieldrig help` prints to be copied: each does what it says, run as printed."""

import re
import shutil

import pytest
from lab_masters import CanopenMaster
from lab_process import LabProcess
from running_rig import until
from terminal import Terminal

pytestmark = pytest.mark.real

# What each prints, by part and label.
OF_THE_DRIVE = {
    "coils: run, alarm_reset": r"\[1\]: \t0",
    "discrete inputs: running, high_level": r"\[1\]: \t0",
    "holding registers: speed_set, ramp_time, level_limit, location": r"\[2\]: \t1800",
    "input registers: level, speed": r"\[0\]: \t500",
    "input registers: flow": r"\[2\]: \t0",
    "input registers: drive_temperature": r"\[4\]: \t315",
    "all registers with pymodbus": r"ReadInputRegistersResponse\(.*registers=\[315\]",
    "run on": r"Written 1 reference",
    "run on with pymodbus": r"WriteSingleCoilResponse\(.*bits=\[True\]",
}
SAYS = {
    **{f"drive {label} by {bus}": said for bus in ("mb_tcp", "mb_rtu") for label, said in OF_THE_DRIVE.items()},
    **{f"{part} all values": rf"^{part}/" for part in ("tank", "io", "sensor", "drive")},
    **{f"{part} its faults": r"^none$" for part in ("tank", "io", "sensor", "drive")},
    "io what it is": r"^IO32$",
    "io start it": r"^$",
    "sensor what it is": r"^Level sensor$",
    "sensor start it": r"^$",
}
STAYS = {"can0 watch": "q", "can0 log": "\x03", "can0 log by slcan": "\x03", "can0 every message": "\x03"}
"""Tools that run until the user presses a key."""
NEEDS_ROOT = ("can0 network device",)
SILENT = ("mb_tcp every message", "mb_rtu every message", "wires every message")
"""Tools that show nothing while the lab is at rest."""


def skip_without_mbpoll() -> None:
    if shutil.which("mbpoll") is None:
        pytest.skip("mbpoll is not installed")


def test_every_line_is_known_here(lab: LabProcess) -> None:
    assert sorted(lab.lines()) == sorted([*SAYS, *STAYS, *NEEDS_ROOT, *SILENT])


@pytest.mark.parametrize("label", SAYS)
def test_line_says_what_it_should(lab: LabProcess, label: str) -> None:
    line = lab.lines()[label]
    if line.startswith("mbpoll"):
        skip_without_mbpoll()
    assert re.search(SAYS[label], lab.do(line), re.MULTILINE)


@pytest.mark.parametrize(
    ("label", "point", "value"),
    [
        ("io start it", "io/nmt.state", "operational"),
        ("sensor start it", "sensor/nmt.state", "operational"),
        ("drive run on by mb_tcp", "drive/run", True),
        ("drive run on by mb_rtu", "drive/run", True),
        ("drive run on with pymodbus by mb_rtu", "drive/run", True),
    ],
)
def test_line_starts_what_it_says(
    lab: LabProcess, master: CanopenMaster, label: str, point: str, value: str | bool
) -> None:
    assert lab.get(point) != value
    line = lab.lines()[label]
    if line.startswith("mbpoll"):
        skip_without_mbpoll()
    lab.do(line)
    until(lambda: lab.get(point) == value)


@pytest.mark.parametrize("label", STAYS)
def test_line_that_stays_shows_the_heartbeats_until_its_key(lab: LabProcess, label: str) -> None:
    with Terminal(lab.lines()[label], lab.folder) as terminal:
        terminal.until_shown("705", "706")
        assert terminal.press(STAYS[label]) == 0, terminal.shown
