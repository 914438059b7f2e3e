"""The meters in virtual time: a Modbus master reads values that change, and sets what a meter keeps."""

import struct
from collections.abc import Callable
from pathlib import Path

import pytest

from fieldrig import MS, Rig, RigMaker, S
from fieldrig_bus.modbus import ModbusRequest, ModbusResponse

RIG = Path(__file__).with_name("energy-meter.yaml")

Ask = Callable[[int, str], bytes]


def master_of(rig: Rig, bus: str) -> Ask:
    """A master on a bus of the rig, which asks a unit and waits for the data of its response."""
    link = rig.attach("master").link(bus)
    answers: list[bytes] = []
    link.on_receive(lambda message: answers.append(message.pdu) if isinstance(message, ModbusResponse) else None)

    def ask(unit: int, pdu: str) -> bytes:
        link.send(ModbusRequest(unit, bytes.fromhex(pdu)))
        rig.run_for(100 * MS)
        return answers[-1]

    return ask


@pytest.mark.parametrize("bus", ["meters_tcp", "meters_rtu"])
def test_energy_grows_by_what_an_hour_adds(fieldrig_rig: RigMaker, bus: str) -> None:
    rig = fieldrig_rig(RIG)
    ask = master_of(rig, bus)
    before = _energy(ask(1, "04 0006 0004"))
    rig.run_for(3600 * S)
    assert _energy(ask(1, "04 0006 0004")) - before == pytest.approx(16.25 * 3600, abs=3)


def test_each_meter_has_voltages_of_its_own_within_the_limits(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(RIG)
    rig.run_for(3600 * S)
    voltages = [rig.get(f"meters/{unit}/voltage_l{phase}") for unit in (1, 2, 3) for phase in (1, 2, 3)]
    assert len(set(voltages)) > 3
    assert all(225 <= float(voltage) <= 236 for voltage in voltages)


def test_the_current_is_scaled_by_the_ratio_that_the_master_sets(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(RIG)
    ask = master_of(rig, "meters_tcp")
    assert ask(2, "04 0003 0001")[2:] == struct.pack(">H", 2125)  # 85 A by 40
    ask(2, "06 0000 0050")
    rig.run_for(1 * S)
    assert rig.get("meters/2/current_l1") == pytest.approx(85.9, abs=0.1)
    (current,) = struct.unpack(">H", ask(2, "04 0003 0001")[2:])
    assert current == pytest.approx(85.9 / 0.001 / 80, abs=2)


def test_the_tariff_has_names(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(RIG)
    rig.set("meters/3/tariff", "night")
    assert master_of(rig, "meters_tcp")(3, "03 0001 0001") == bytes.fromhex("0302 0002")
    assert rig.get("meters/1/tariff") == "day"


def _energy(pdu: bytes) -> int:
    """The number of four registers, the low one first."""
    words = struct.unpack(">4H", pdu[2:])
    return sum(word << 16 * place for place, word in enumerate(words))
