"""The file arp-card.eds: valid, consistent with the card, and readable by python canopen."""

from typing import Any

import canopen
import pytest
from arp_face import NODE_ID, FaceBench, OutsideCard
from canopen.sdo.exceptions import SdoAbortedError

from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.arp.can import objects
from fieldrig_devices.arp.can.face import EDS
from fieldrig_devices.arp.parameters import PARAMETERS
from fieldrig_devices.canopen.eds import reader as eds
from fieldrig_devices.canopen.eds.check import check_eds

DICTIONARY = eds.load(EDS, NODE_ID)


class Wire(canopen.Network):
    """A network of function calls: the card's answers arrive at once."""

    def __init__(self, bench: FaceBench) -> None:
        super().__init__()
        self._bench = bench

    def send_message(self, can_id: int, data: bytes, remote: bool = False) -> None:
        self._bench.can.deliver(CanFrame(can_id, bytes(data), is_remote=remote))
        self.run(0)

    def run(self, ms: int) -> None:
        self._bench.clock.advance_to(self._bench.clock.now_ns() + ms * 1_000_000)
        for frame in self._bench.can.take():
            self.notify(frame.identifier, bytearray(frame.data), 0.0)


@pytest.fixture
def bench() -> FaceBench:
    bench = FaceBench()
    bench.start()
    return bench


@pytest.fixture
def node(bench: FaceBench) -> Any:
    return Wire(bench).add_node(NODE_ID, str(EDS))


def test_the_check_finds_nothing() -> None:
    assert [finding for finding in check_eds(EDS) if "no clear mapping direction" not in finding.what] == []


def test_every_object_of_the_manufacturer_has_something_behind_it() -> None:
    described = {(entry.index, entry.subindex) for entry in DICTIONARY if 0x2000 <= entry.index < 0x6000}
    counts = {(index, 0) for index, subindex in described if subindex > 0}
    orders = {(objects.COMMAND, 0), (objects.CONTROL, 0)}
    assert {(cell.index, cell.subindex) for cell in objects.cells(OutsideCard())} == described - counts - orders


def test_what_can_be_written_has_a_taker() -> None:
    for cell in objects.cells(OutsideCard()):
        assert DICTIONARY.find(cell.index, cell.subindex).access.is_writable == (cell.write is not None), cell


def test_values_have_the_size_of_their_type(bench: FaceBench) -> None:
    for cell in objects.cells(bench.card):
        size = DICTIONARY.find(cell.index, cell.subindex).type.size
        assert size in (None, len(cell.read())), cell


@pytest.mark.parametrize("group", [0, 1, 2])
def test_limits_defaults_and_names_of_parameters(group: int) -> None:
    table, lowest, highest = PARAMETERS[group], -(1 << 31), (1 << 31) - 1
    assert {entry.subindex for entry in DICTIONARY.members(objects.GROUPS[group])} == set(table)
    for number, parameter in table.items():
        variable = DICTIONARY.find(objects.GROUPS[group], number)
        assert (variable.low or lowest, variable.high or highest) == (parameter.low or lowest, parameter.high)
        assert variable.value == parameter.default
        assert variable.name == f"@Par{group or ''}[{number:02d}] {parameter.name}"


def test_all_can_be_mapped_but_the_program_and_the_number_of_the_card() -> None:
    for cell in objects.cells(OutsideCard()):
        variable = DICTIONARY.find(cell.index, cell.subindex)
        is_name = cell.index in (objects.PROGRAM_NAME, objects.CARD_NUMBER)
        assert variable.is_mappable != is_name, variable.key


def test_python_canopen_reads_and_writes_by_name(bench: FaceBench, node: Any) -> None:
    bench.card.V[750] = -1
    assert node.sdo["Variables V501 to V750"][250].raw == -1
    node.sdo["Parameters of axis 1"]["@Par1[11] KP"].raw = 2500
    assert bench.card.parameters.ram[1][11] == 2500
    assert node.sdo["Name of the program"].raw == "WINDER"
    node.sdo["Command"].raw = 3
    assert bench.card.asked == ["reset"]
    with pytest.raises(SdoAbortedError) as refused:
        node.sdo["General parameters"][6].raw = 200_000
    assert refused.value.code == 0x0609_0030


@pytest.mark.long
def test_python_canopen_hears_pdos_and_sends_them(bench: FaceBench, node: Any) -> None:
    node.tpdo.read()
    node.rpdo.read()
    node.network.send_message(0, bytes((1, NODE_ID)))
    bench.card.positions[1] = 1500
    bench.face.refresh()
    node.network.run(0)
    assert node.tpdo[2]["Position.Position of axis 1"].raw == 1500
    node.rpdo[2][0].raw = 7  # V1
    node.rpdo[2].transmit()
    assert bench.card.V[1] == 7


def test_the_card_gives_its_eds(bench: FaceBench, node: Any) -> None:
    assert node.sdo.upload(0x1021, 0) == EDS.read_bytes()
