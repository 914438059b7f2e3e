"""The lines that `fieldrig up` prints to be copied: each does what it says, run as printed."""

import re
import shutil

import pytest
from lab_masters import CanopenMaster
from lab_process import LabProcess
from running_rig import until
from terminal import Terminal

pytestmark = pytest.mark.real

# What each prints, by part and label.
SAYS = {
    "mb_tcp mbpoll": r"\[0\]: \t0",
    "mb_tcp pymodbus": r"ReadCoilsResponse",
    "mb_rtu mbpoll": r"\[0\]: \t0",
    "mb_rtu pymodbus": r"ReadCoilsResponse",
    "io what it is": r"^IO32$",
    "io start it": r"^$",
    "sensor what it is": r"^Level sensor$",
    "sensor start it": r"^$",
    "drive coils: run, alarm_reset": r"\[1\]: \t0",
    "drive discrete inputs: running, high_level": r"\[1\]: \t0",
    "drive holding registers: speed_set, ramp_time, level_limit, location": r"\[2\]: \t1800",
    "drive input registers: level, speed": r"\[0\]: \t500",
    "drive input registers: flow": r"\[2\]: \t0",
    "drive input registers: drive_temperature": r"\[4\]: \t315",
    "drive run on": r"Written 1 reference",
}
STAYS = {"can0 watch": "q", "can0 log": "\x03", "can0 log by slcan": "\x03"}
"""Tools that run until the user presses a key."""
NEEDS_ROOT = ("can0 network device",)


def skip_without_mbpoll() -> None:
    if shutil.which("mbpoll") is None:
        pytest.skip("mbpoll is not installed")


def test_every_line_is_known_here(lab: LabProcess) -> None:
    assert sorted(lab.lines()) == sorted([*SAYS, *STAYS, *NEEDS_ROOT])


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
        ("drive run on", "drive/run", True),
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
