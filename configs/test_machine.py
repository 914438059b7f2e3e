"""The whole machine in virtual time: the ring comes up beside the film and the glue, and its program makes packs."""

from pathlib import Path

from fieldrig import RigMaker, S
from fieldrig_bus.modbus import ModbusRequest, ModbusResponse

RIG = Path(__file__).with_name("machine.yaml")


def test_the_ring_comes_up_beside_the_film_and_the_glue(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(RIG)
    rig.until(lambda: rig.get("max4/booted"), within=60 * S)
    rig.run_for(2 * S)
    assert (rig.get("max4/ring.state"), rig.get("max4/DiagCode")) == ("up", 0)
    assert rig.get("tank/level") == 0.5


def test_a_modbus_client_starts_the_wrapper_and_reads_its_packs(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(RIG)
    client = rig.attach("client").link("modbus")
    answers: list[bytes] = []
    client.on_receive(lambda message: answers.append(message.pdu) if isinstance(message, ModbusResponse) else None)
    rig.run_until(5 * S)
    rig.set("line/F33", True)  # the film starts
    rig.run_until(8 * S)
    client.send(ModbusRequest(1, bytes.fromhex("05 8000 ff00")))  # coil 32768
    rig.run_until(13 * S)
    client.send(ModbusRequest(1, bytes.fromhex("03 8001 0003")))  # registers 32769 to 32771
    rig.run_for(S)
    started, shown = answers
    assert started == bytes.fromhex("05 8000 ff00")
    state, packs = int.from_bytes(shown[2:4]), int.from_bytes(shown[4:6])
    assert (state, shown[6:]) == (3, bytes(2))
    assert 3 <= packs <= 5  # about one a second
