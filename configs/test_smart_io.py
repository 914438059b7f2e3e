"""The Smart-IO node in virtual time: a motor with its plant, moved from Modbus and from CANopen."""

from collections.abc import Callable
from pathlib import Path

import pytest

from fieldrig import MS, Rig, RigMaker, S
from fieldrig_bus.can import CanFrame
from fieldrig_bus.modbus import ModbusRequest, ModbusResponse

RIG = Path(__file__).with_name("smart-io.yaml")
TIMEOUT, UNEXPECTED, LOST, DOES_NOT_STOP = 0x1, 0x4000, 0x2000, 0x8000
Ask = Callable[[str], str]


def client_of(rig: Rig) -> Ask:
    """A Modbus client of the node."""
    link = rig.attach("client").link("panel")
    answers: list[str] = []
    link.on_receive(lambda message: answers.append(message.pdu.hex()) if isinstance(message, ModbusResponse) else None)
    exchanges = iter(range(1, 1000))

    def ask(pdu: str) -> str:
        link.send(ModbusRequest(1, bytes.fromhex(pdu), next(exchanges)))
        rig.run_for(20 * MS)
        return answers[-1]

    return ask


def zeroed(fieldrig_rig: RigMaker) -> tuple[Rig, Ask]:
    """The rig after zero_position(DEC, HIGH), by registers."""
    rig = fieldrig_rig(RIG)
    ask = client_of(rig)
    ask("10 0011 0004 08 ffff ffff 0001 0000")
    assert ask("06 0010 0006") == "0600100006"
    rig.run_for(S)
    assert rig.get("io/motor1.ready")
    return rig, ask


def test_the_motor_finds_its_zero_and_moves_to_a_position(fieldrig_rig: RigMaker) -> None:
    rig, ask = zeroed(fieldrig_rig)
    assert rig.get("io/motor1.position") == pytest.approx(-2, abs=1), "it coasts"
    ask("10 0011 0002 04 0064 0000")
    ask("06 0010 0001")
    rig.run_for(2 * S)
    assert ask("02 0140 0001") == "020101", "ready"
    assert ask("04 0010 0004") == "0408" + "00640000" + "00000000"
    assert rig.get("rail/position") == pytest.approx(100, abs=1.5)


def test_a_canopen_master_moves_it_too(fieldrig_rig: RigMaker) -> None:
    rig, _ = zeroed(fieldrig_rig)
    master = rig.attach("master").link("can4")
    seen: list[str] = []
    master.on_receive(lambda frame: seen.append(frame.data.hex()) if frame.identifier == 0x49F else None)
    master.send(CanFrame(0x000, b"\x01\x1f"))
    rig.run_for(10 * MS)
    master.send(CanFrame(0x51F, bytes.fromhex("3200000001")))  # 50, absolute move
    rig.run_for(2 * S)
    assert seen[-1] == "3200000001"


@pytest.mark.parametrize(
    ("fault", "order", "error"),
    [
        ({"what": "blocked"}, "3", TIMEOUT),
        ({"what": "no_pulses"}, "3", TIMEOUT),
        ({"what": "pushed"}, "0", UNEXPECTED | LOST),
    ],
)
def test_what_is_wrong_with_the_motor_is_in_its_error_word(
    fieldrig_rig: RigMaker, fault: dict[str, object], order: str, error: int
) -> None:
    rig, ask = zeroed(fieldrig_rig)
    rig.add_fault("rail", fault)
    ask("10 0011 0002 04 0001 0000")
    ask(f"06 0010 000{order}")
    rig.run_for(2 * S)
    assert rig.get("io/motor1.error") == error


def test_a_welded_contact_is_a_motor_that_does_not_stop(fieldrig_rig: RigMaker) -> None:
    rig, ask = zeroed(fieldrig_rig)
    rig.add_fault("rail", {"what": "welded"})
    ask("10 0011 0002 04 0005 0000")
    ask("06 0010 0001")
    rig.run_for(2 * S)
    assert rig.get("io/motor1.error") == DOES_NOT_STOP | LOST
    assert rig.get("io/error_word") == DOES_NOT_STOP | LOST
