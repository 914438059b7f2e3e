"""The ring rig in real time under rough hands: its name plate by `fieldrig nameplate`, noise, kills in mid-motion."""

import os
import random
import signal
from collections.abc import Iterator
from contextlib import suppress
from threading import Thread

import pytest
from ring_process import CONFIGS, RingProcess
from running_rig import until

from fieldrig.errors import ControlError

pytestmark = [pytest.mark.system, pytest.mark.timeout(400)]

RIGHT = CONFIGS / "plates" / "sm-140-30-200-brake.yaml"
AXES = ("infeed", "jaw")


@pytest.fixture
def ring() -> Iterator[RingProcess]:
    with RingProcess() as ring:
        yield ring.until_ready().until_up()


def plate(ring: RingProcess, *words: str) -> str:
    done = ring.tool("nameplate", *words, "--port", str(ring.run / "jaw_line"))
    assert done.returncode == 0, done.stderr
    return done.stdout


def enable(ring: RingProcess, *names: str) -> None:
    for name in names:
        ring.set(f"max4/{name}.ControllerEnable", True)
    until(lambda: all(ring.get(f"max4/{name}.AxisState") == 3 for name in names))


def quit_until_right(ring: RingProcess) -> None:
    def is_right() -> bool:
        ring.do("quit")
        return bool(ring.get("max4/DiagCode") == 0 and ring.get("max4/ring.state") == "up")

    until(is_right)


@pytest.mark.manual("PD-170", "PD-171", "PD-172")
def test_plate_is_read_and_edited_while_axes_are_under_control(ring: RingProcess) -> None:
    """The drive goes on with what it has read, and finds another motor at its next start."""
    enable(ring, *AXES)
    assert "17130068-0002" in plate(ring, "read")
    assert "17130068-0002 -> 17-4711" in plate(ring, "edit", "--set", "serial_number=17-4711", "--set", "type=SM-OTHER")
    assert "SM-OTHER" in plate(ring, "read")
    assert (ring.get("max4/jaw.AxisState"), ring.get("jaw/motor_type")) == (3, "SM-140/30/200/P0/45/M1")
    os.kill(ring.pid("jaw"), signal.SIGKILL)
    ring.until_back("jaw")
    until(lambda: "found SM-OTHER, expected SM-140" in str(ring.get("jaw/plate")))

    def is_found() -> bool:
        ring.do("quit")
        return bool(ring.get("max4/DiagCode") == 1117)

    until(is_found)
    ring.set("max4/jaw.ControllerEnable", True)
    enable(ring, "infeed")
    assert ring.get("max4/jaw.AxisState") == 5
    assert "is in the encoder" in plate(ring, "write", str(RIGHT))
    quit_until_right(ring)
    enable(ring, *AXES)


def test_noise_on_the_encoders_line_is_harmless(ring: RingProcess) -> None:
    enable(ring, *AXES)
    noise = random.Random(3)
    descriptor = os.open(ring.run / "jaw_line", os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    try:
        for _ in range(20):
            os.write(descriptor, noise.randbytes(noise.randrange(1, 60)))
    finally:
        os.close(descriptor)
    until(lambda: ring.tool("nameplate", "read", "--port", str(ring.run / "jaw_line")).returncode == 0)
    assert ring.get("jaw_encoder/plate") == "SM-140/30/200/P0/45/M1, 17130068-0002"
    assert ring.get("max4/DiagCode") == 0
    assert [ring.get(f"max4/{name}.AxisState") for name in AXES] == [3, 3]


def save(ring: RingProcess, number: int) -> None:
    with suppress(ControlError, AssertionError):  # there may be no process left to answer
        ring.do(f"save log \\RUN{number}.LOG")


@pytest.mark.manual("PD-140", "PD-112")
def test_controller_killed_while_it_saves_loses_nothing_and_moves_nothing(ring: RingProcess) -> None:
    ring.do("save log \\BEFORE.LOG")
    for number in range(3):
        enable(ring, *AXES)
        pid = ring.pid("max4")
        saving = Thread(target=save, args=(ring, number))
        saving.start()
        os.kill(pid, signal.SIGKILL)
        saving.join()
        ring.until_back("max4", restarts=number + 1)
        ring.until_up()
        assert not any(ring.get(f"max4/{name}.ControllerEnable") for name in AXES), "nothing moves by itself"
        quit_until_right(ring)
    assert "\\BEFORE.LOG" in str(ring.get("max4/files"))
    assert ring.codes().count(8002) == 4
    assert ring.codes()[0] == 8002
    entries = [line.split("\t") for line in str(ring.get("max4/log")).splitlines()]
    assert [int(entry[0]) for entry in entries] == list(range(len(entries), 0, -1))
    assert all(len(entry) == 8 for entry in entries)


FAULTS = [
    ("ring", "break after=film"),
    ("ring", "distort after=infeed telegram=mdt"),
    ("ring", "off station=film"),
    ("ring", "late station=jaw"),
    ("film", "enable_lost"),
    ("film", "overtemperature"),
    ("film", "overtemperature of=amplifier"),
    ("film", "overload"),
    ("film", "dc_bus sort=undervoltage"),
    ("film", "encoder_memory"),
    ("film", "wrong_motor"),
    ("film", "stuck_brake"),
    ("jaw_encoder", "memory"),
    ("max4", "power_off duration_ms=200"),
]


def test_every_fault_is_given_shown_and_cleared_by_its_command(ring: RingProcess) -> None:
    for where, words in FAULTS:
        given = ring.tool("fault", where, *words.split())
        assert (given.returncode, given.stdout.strip().isdigit()) == (0, True), given.stderr
        assert words.split()[0] in ring.tool("fault", where).stdout
        assert ring.tool("fault", where, "--clear", given.stdout.strip()).returncode == 0
        assert words.split()[0] not in ring.tool("fault", where).stdout
    until(lambda: ring.get("max4/booted") is True)
    quit_until_right(ring)
    enable(ring, *AXES)
