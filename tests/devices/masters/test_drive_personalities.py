"""python canopen's `BaseNode402`, unchanged, at a drive of each personality: what it manages, and where it fails.

Source: docs/devices/drive-personalities.md, whose table of masters says the same; all in virtual time.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import canopen
import pytest
from canopen.profiles.p402 import BaseNode402
from canopen.sdo.exceptions import SdoError

from fieldrig import Bus, Delivery, Rig, from_dict, virtual_time
from fieldrig_bus.can import CanFrame
from fieldrig_devices.cia402 import EDS

pytestmark = [pytest.mark.lean, pytest.mark.long, pytest.mark.timeout(120)]

NODE, TURN = 3, 1_000_000
PP, VL, CSP = "PROFILED POSITION", "VELOCITY", "CYCLIC SYNCHRONOUS POSITION"
ON, QUICK = "OPERATION ENABLED", "QUICK STOP ACTIVE"
TIMED_OUT, ABORTED = "RuntimeError", "SdoAbortedError"

MASTER: Any = BaseNode402


class Words:
    """The control words that the master sends by RPDO 1."""

    def __init__(self) -> None:
        self.sent: list[int] = []

    def __call__(self, bus: Bus[Any], delivery: Delivery[Any]) -> None:
        if isinstance(delivery.message, CanFrame) and delivery.message.identifier == 0x200 + NODE:
            self.sent.append(int.from_bytes(delivery.message.data[:2], "little"))


@contextmanager
def master(words: Words, **keys: Any) -> Iterator[Any]:
    """The master with its node in pre-operational, and its state machine set up; in virtual time."""
    drive = {"kind": "cia402.drive", "node_id": NODE, "links": {"can": "can0"}, **keys}
    rig_file = {
        "time": "virtual",
        "buses": {"can0": {"kind": "can.virtual", "bitrate": 1_000_000}},
        "devices": {"axis": drive},
    }
    with Rig(from_dict(rig_file), words) as rig, virtual_time(rig, limit_s=100):
        network: Any = canopen.Network()
        network.connect(interface="fieldrig", channel="can0")
        axis = MASTER(NODE, str(EDS))
        network.add_node(axis)
        try:
            axis.nmt.wait_for_bootup(10)
            yield axis
        finally:
            network.disconnect()


def begin(axis: Any) -> None:
    axis.setup_402_state_machine()
    axis.nmt.state = "OPERATIONAL"
    time.sleep(0.1)


def tried(act: Callable[[], Any]) -> Any:
    """Return what it returns, or the name of the exception."""
    try:
        return act()
    except (RuntimeError, TypeError, SdoError) as error:
        return type(error).__name__


def mode_of(axis: Any, mode: str) -> Any:
    def set_mode() -> Any:
        axis.op_mode = mode
        return axis.op_mode

    return tried(set_mode)


def state_of(axis: Any, state: str) -> Any:
    def set_state() -> Any:
        axis.state = state
        return axis.state

    return tried(set_state)


def moved(axis: Any) -> int:
    """Return the position at which a move of a turn ends."""
    axis.sdo[0x607A].raw = TURN
    axis.controlword = 0x1F
    time.sleep(0.2)
    axis.controlword = 0x0F
    time.sleep(3)
    return int(axis.sdo[0x6064].raw)


# Personality, mode, what the change of the mode gives before enabling, what enabling gives.
ENABLING = [
    (None, PP, PP, ON),
    ("step-by-step", PP, "NO MODE", ON),
    ("runs-ahead", PP, PP, ON),
    ("mains-inverter", VL, VL, ON),
    ("robot-joint", CSP, "NO MODE", TIMED_OUT),
    ("own-units", PP, PP, ON),
    ("late-and-thin", PP, ABORTED, ON),
]


@pytest.mark.parametrize(("name", "mode", "shown", "state"), ENABLING)
def test_choosing_a_mode_and_enabling(name: str | None, mode: str, shown: str, state: str) -> None:
    """It waits 0.5 s for 6061h, which comes after enabling; NMT start without a reset is in vain; 6502h is missing."""
    with master(Words(), personality=name) as axis:
        if name == "robot-joint":
            assert tried(lambda: axis.sdo[0x1000].raw) == "SdoCommunicationError"
        begin(axis)
        assert mode_of(axis, mode) == shown
        assert state_of(axis, ON) == state


def test_a_robot_joint_starts_after_a_reset_of_the_node() -> None:
    with master(Words(), personality="robot-joint") as axis:
        axis.nmt.send_command(0x81)
        axis.nmt.wait_for_bootup(10)
        assert tried(lambda: axis.sdo[0x1000].raw) == "SdoCommunicationError"
        begin(axis)
        assert mode_of(axis, CSP) == CSP
        assert state_of(axis, ON) == ON


MOVES = [(None, TURN), ("step-by-step", TURN), ("runs-ahead", TURN), ("own-units", 0), ("late-and-thin", 0)]


@pytest.mark.parametrize(("name", "end"), MOVES)
def test_a_move_of_a_turn(name: str | None, end: int) -> None:
    """607Dh 0/0 of own-units allows position 0 only, and late-and-thin has no mode without 6502h."""
    with master(Words(), personality=name) as axis:
        begin(axis)
        mode_of(axis, PP)
        assert state_of(axis, ON) == ON
        assert moved(axis) == pytest.approx(end, abs=20)


@pytest.mark.parametrize(
    ("name", "reached", "words"),
    [
        (None, QUICK, [0x02]),
        ("step-by-step", QUICK, [0x02]),
        ("runs-ahead", QUICK, [0x02]),
        ("mains-inverter", TIMED_OUT, [0x02, 0x06, 0x07, 0x0F, 0x02]),
        ("own-units", QUICK, [0x02]),
        ("late-and-thin", TIMED_OUT, [0x02, 0x06, 0x07, 0x0F, 0x02]),
    ],
)
def test_a_quick_stop_at_rest_may_enable_the_drive_again(name: str | None, reached: str, words: list[int]) -> None:
    """A master that misses 'quick stop active' goes the whole way to it again, through 'operation enabled'."""
    sent = Words()
    with master(sent, personality=name) as axis:
        begin(axis)
        mode_of(axis, PP)
        assert state_of(axis, ON) == ON
        sent.sent.clear()
        assert state_of(axis, QUICK) == reached
        assert sent.sent == words


@pytest.mark.parametrize(
    ("name", "homed"),
    [
        (None, True),
        ("step-by-step", True),
        ("runs-ahead", True),
        ("own-units", True),
        ("mains-inverter", ABORTED),
        ("late-and-thin", ABORTED),
    ],
)
def test_a_homing_where_the_axis_is(name: str | None, homed: bool | str) -> None:
    def home(axis: Any) -> Any:
        axis.sdo[0x6098].raw = 35 if name == "step-by-step" else 37
        return axis.homing(timeout=5)

    with master(Words(), personality=name) as axis:
        begin(axis)
        assert tried(lambda: home(axis)) == homed


@pytest.mark.parametrize(
    ("behaviour", "state"),
    [({}, ON), ({"resets": 2}, "FAULT"), ({"reset_lock_ms": 15_000}, "FAULT"), ({"fault_reset": "level"}, ON)],
)
def test_a_fault_reset(behaviour: dict[str, Any], state: str) -> None:
    """It sets bit 7 once, waits for 0.4 s, and enables whether the fault is gone or not."""
    with master(Words(), behaviour=behaviour, faults=[{"what": "error", "start_ms": 50, "duration_ms": 100}]) as axis:
        begin(axis)
        time.sleep(0.2)
        assert axis.state == "FAULT"
        tried(axis.reset_from_fault)
        assert axis.state == state
