"""The card's remote I/O: two CiA 401 modules (our own, from the EDS of an I/O module) as nodes 1 and 2."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from canopen_bench import IO32, parse, show

from fieldrig.clock import MS, VirtualClock
from fieldrig.config.rig_file import from_dict
from fieldrig.testing import RecordedLink
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.notices import BitRate, BusState, CanState
from fieldrig_devices.arp.can.bit_rate import take_bit_rate
from fieldrig_devices.arp.can.remote_io import RemoteIo
from fieldrig_devices.arp.card_errors import CardErrors
from fieldrig_devices.arp.parameters import Par, Parameters
from fieldrig_devices.arp.readings import Readings
from fieldrig_devices.canopen.managed_slave import watch_over

SCHEDULER_NS = 20 * MS  # @Par[16]
CAN_ERROR = 106


class CardPart:
    """Inputs, outputs and errors of a card, its remote I/O, and a scheduler."""

    def __init__(self, clock: Any, can: Any, node_ids: tuple[int | None, ...] = (1, 2), **options: Any) -> None:
        self.I, self.O = [0] * 333, [0] * 333  # the manual's letters
        self.errors = CardErrors(lambda code: None)
        self.io = RemoteIo(clock, can, node_ids, self.I, self.O, self.errors, 100, **options)
        self._clock = clock
        self.io.start()
        self._pass()

    def inputs(self, first: int) -> list[int]:
        """Numbers of the elements that are 1, for the module that begins at `first`."""
        return [number for number in range(first, first + 32) if self.I[number]]

    def _pass(self) -> None:
        self.io.refresh()
        self._clock.call_at(self._clock.now_ns() + SCHEDULER_NS, self._pass)


class Cell:
    """A card and two modules on a bus."""

    def __init__(self, rig: Rig, **options: Any) -> None:
        self.rig = rig
        member = rig.attach("card")
        self.link: Any = member.link("can0")
        self.card = CardPart(member.clock, self.link, **options)

    def run(self, ms: int) -> None:
        self.rig.run_until(self.rig.now_ns + ms * MS)

    def enabled(self) -> "Cell":
        self.card.io.release()
        self.run(500)
        return self

    def outputs(self, module: str) -> list[int]:
        return [int(self.rig.get(module, f"6200:0{byte}")) for byte in (1, 2, 3, 4)]

    def set_inputs(self, module: str, byte: int, value: int) -> None:
        self.rig.set(module, f"6000:0{byte}", value)

    def pull_plug(self, module: str, ms: int) -> None:
        for end in ({"node": module}, {"receivers": [module]}):
            self.rig.add_fault("can0", {"what": "drop", "duration_ms": ms, **end})


Make = Callable[..., Cell]


@pytest.fixture
def make() -> Iterator[Make]:
    rigs: list[Rig] = []

    def cell(**options: Any) -> Cell:
        modules = {
            f"io{number}": {"kind": "canopen.node", "node_id": number, "eds": str(IO32), "links": {"can": "can0"}}
            for number in (1, 2)
        }
        buses = {"can0": {"kind": "can.virtual", "bitrate": 500_000}}
        rigs.append(Rig(from_dict({"time": "virtual", "buses": buses, "devices": modules})))
        return Cell(rigs[-1], **options)

    yield cell
    for rig in rigs:
        rig.close()


@pytest.fixture
def cell(make: Make) -> Cell:
    return make().enabled()


@pytest.mark.manual("ARP-040", "ARP-003")
def test_card_starts_its_modules_and_has_no_error(cell: Cell) -> None:
    assert [cell.rig.get(module, "nmt.state") for module in ("io1", "io2")] == ["operational"] * 2
    assert cell.card.errors.error == 0
    assert not cell.card.io.is_lost


@pytest.mark.manual("ARP-040")
@pytest.mark.parametrize(("module", "first"), [("io1", 201), ("io2", 301)])
def test_inputs_of_a_node_are_its_32(cell: Cell, module: str, first: int) -> None:
    cell.set_inputs(module, 1, 0b0000_0101)
    cell.set_inputs(module, 4, 0b1000_0000)
    cell.run(50)
    assert cell.card.inputs(first) == [first, first + 2, first + 31]
    assert cell.card.inputs(502 - first) == []  # the other node's inputs
    cell.set_inputs(module, 1, 0)
    cell.run(50)
    assert cell.card.inputs(first) == [first + 31]


@pytest.mark.manual("ARP-040")
@pytest.mark.parametrize(("module", "first"), [("io1", 201), ("io2", 301)])
def test_outputs_of_a_node_are_its_32(cell: Cell, module: str, first: int) -> None:
    for number in (first, first + 9, first + 31):
        cell.card.O[number] = 1
    cell.run(50)
    assert cell.outputs(module) == [0x01, 0x02, 0x00, 0x80]
    assert cell.outputs({"io1": "io2", "io2": "io1"}[module]) == [0, 0, 0, 0]
    cell.card.O[first + 9] = 0
    cell.run(50)
    assert cell.outputs(module) == [0x01, 0x00, 0x00, 0x80]


@pytest.mark.manual("ARP-041")
def test_outputs_are_0_while_the_card_is_disabled(cell: Cell) -> None:
    cell.card.O[201] = 1
    cell.run(50)
    cell.card.io.freeze()
    cell.run(1)
    assert cell.outputs("io1") == [0, 0, 0, 0]
    cell.run(100)
    assert cell.outputs("io1") == [0, 0, 0, 0]
    cell.card.io.release()
    cell.run(50)
    assert cell.outputs("io1") == [1, 0, 0, 0]


def test_outputs_wait_for_the_card_to_be_enabled(make: Make) -> None:
    cell = make()
    cell.card.O[201] = 1
    cell.run(500)
    assert cell.outputs("io1") == [0, 0, 0, 0]
    cell.enabled()
    assert cell.outputs("io1") == [1, 0, 0, 0]


def test_inputs_that_were_on_before_the_card_are_there(make: Make) -> None:
    cell = make()
    cell.set_inputs("io1", 2, 0b11)
    cell.enabled()
    assert cell.card.inputs(201) == [209, 210]


@pytest.mark.manual("ARP-050")
def test_lost_module_is_error_106_and_its_inputs_are_0(cell: Cell) -> None:
    cell.set_inputs("io1", 1, 0xFF)
    cell.set_inputs("io2", 1, 0x01)
    cell.run(50)
    cell.pull_plug("io1", 5000)
    cell.run(90)
    assert (cell.card.errors.error, len(cell.card.inputs(201))) == (0, 8)
    cell.run(150)  # twice the heartbeat time after the last heartbeat, and a pass of the scheduler
    assert (cell.card.errors.error, cell.card.inputs(201), cell.card.inputs(301)) == (CAN_ERROR, [], [301])


def test_inputs_of_a_lost_module_may_be_held(make: Make) -> None:
    cell = make(readings=Readings(lost_io="hold")).enabled()
    cell.set_inputs("io1", 1, 0x01)
    cell.run(50)
    cell.pull_plug("io1", 5000)
    cell.run(1000)
    assert (cell.card.errors.error, cell.card.inputs(201)) == (CAN_ERROR, [201])


@pytest.mark.manual("ARP-050", "ARP-049")
def test_module_that_is_back_works_again_and_the_error_waits_for_enable(cell: Cell) -> None:
    cell.card.O[201] = 1
    cell.pull_plug("io1", 1000)
    cell.run(500)
    cell.card.O[202] = 1
    cell.set_inputs("io1", 1, 0x04)  # the frame is lost
    cell.run(3000)
    assert cell.outputs("io1") == [3, 0, 0, 0]
    assert cell.card.inputs(201) == [203]
    assert cell.card.errors.error == CAN_ERROR
    cell.card.errors.clear()
    cell.card.io.release()
    cell.run(500)
    assert cell.card.errors.error == 0


@pytest.mark.manual("ARP-050")
def test_what_is_missing_when_the_card_is_enabled_is_an_error_again(cell: Cell) -> None:
    cell.pull_plug("io1", 100_000)
    cell.run(500)
    cell.card.io.freeze()
    cell.card.errors.clear()
    cell.run(5000)
    assert cell.card.errors.error == 0  # ERROR now shows the card's own state
    cell.card.io.release()
    assert cell.card.errors.error == CAN_ERROR


@pytest.mark.manual("ARP-050")
def test_module_that_never_comes_is_an_error(make: Make) -> None:
    cell = make(node_ids=(1, 3))
    cell.card.io.release()
    cell.run(1000)
    assert cell.card.errors.error == CAN_ERROR
    cell.set_inputs("io1", 1, 1)
    cell.run(50)
    assert cell.card.inputs(201) == [201]


@pytest.mark.long
def test_module_that_reboots_is_an_error_and_is_started_again(cell: Cell) -> None:
    other = cell.rig.attach("other").link("can0")
    cell.card.O[201] = 1
    cell.run(100)
    other.send(CanFrame(0, b"\x81\x01"))
    cell.run(500)
    assert cell.card.errors.error == CAN_ERROR
    assert (cell.rig.get("io1", "nmt.state"), cell.outputs("io1")) == ("operational", [1, 0, 0, 0])


@pytest.mark.long
@pytest.mark.manual("ARP-050")
def test_bus_off_is_error_106(cell: Cell) -> None:
    cell.set_inputs("io1", 1, 1)
    cell.card.O[201] = 1
    cell.run(100)
    number = cell.rig.add_fault("can0", {"what": "short", "level": "recessive"})
    cell.card.O[202] = 1
    cell.run(60)
    assert (cell.card.errors.error, cell.card.inputs(201)) == (CAN_ERROR, [])
    cell.rig.clear_fault("can0", number)
    cell.run(5000)
    assert (cell.outputs("io1"), cell.card.inputs(201)) == ([3, 0, 0, 0], [201])
    assert not cell.card.io.is_lost


@pytest.mark.manual("ARP-010")
def test_modules_may_watch_the_card_by_its_node_id(make: Make) -> None:
    cell = make(configuration=[watch_over(10, 300)]).enabled()
    assert cell.rig.get("io1", "1016:01") == 0x000A_012C
    card = cell.rig.attach("face of the card").link("can0")
    card.send(CanFrame(0x70A, b"\x05"))
    cell.run(400)
    assert cell.rig.get("io1", "emcy.code") == 0x8130


# On a bench.


class Bench:
    def __init__(self, *node_ids: int | None, **options: Any) -> None:
        self.clock, self.can = VirtualClock(), RecordedLink[CanFrame]()
        self.card = CardPart(self.clock, self.can, node_ids or (1,), **options)
        self.card.io.release()

    def hear(self, *messages: Any) -> list[str]:
        for message in messages:
            self.can.deliver(parse(message) if isinstance(message, str) else message)
        self.clock.advance_to(self.clock.now_ns() + SCHEDULER_NS)
        return [show(frame) for frame in self.can.take()]

    def started(self) -> "Bench":
        self.hear("581#60 17 10 00 00 00 00 00")
        for byte in (1, 2, 3, 4):
            self.hear(f"581#4f 00 60 0{byte} 00 00 00 00")
        return self


def test_frames_are_those_of_the_predefined_connection_set() -> None:
    bench = Bench()
    assert bench.hear() == ["000#80 01", "601#2b 17 10 00 64 00 00 00"]
    assert bench.hear("581#60 17 10 00 00 00 00 00") == [
        "000#01 01",
        "601#40 00 60 01 00 00 00 00",
        "201#00 00 00 00",
    ]
    bench.card.O[201] = bench.card.O[232] = 1
    assert bench.hear() == ["201#01 00 00 80"]
    assert bench.hear() == []  # only changes are sent


@pytest.mark.parametrize(
    ("tpdo", "inputs"),
    [
        ("181#01 00 00 80", [201, 232]),
        ("181#03", [201, 202]),
        ("181#00 01 00 00 ff ff ff ff", [209]),
        ("181#", []),
        ("181#R", []),
        ("182#ff ff ff ff", []),
        ("00000181#ff ff ff ff", []),
    ],
)
def test_tpdo1_is_taken_as_far_as_it_goes(tpdo: str, inputs: list[int]) -> None:
    bench = Bench().started()
    bench.hear(tpdo)
    assert bench.card.inputs(201) == inputs


def test_module_with_fewer_inputs_refuses_the_rest() -> None:
    bench = Bench()
    bench.hear("581#60 17 10 00 00 00 00 00")
    bench.hear("581#4f 00 60 01 81 00 00 00")
    assert bench.hear("581#80 00 60 02 11 00 09 06") == ["601#40 00 60 03 00 00 00 00"]
    assert bench.card.inputs(201) == [201, 208]
    assert bench.card.errors.error == 0


def test_only_the_second_node_may_be_fitted() -> None:
    bench = Bench(None, 2)
    bench.hear("582#60 17 10 00 00 00 00 00", "182#01 00 00 00")
    assert (bench.card.inputs(201), bench.card.inputs(301)) == ([], [301])


def test_nodes_may_have_other_ids() -> None:
    bench = Bench(33)
    assert bench.hear() == ["000#80 21", "621#2b 17 10 00 64 00 00 00"]


def test_bus_off_without_a_loss_sends_outputs_again() -> None:
    bench = Bench().started()
    off: Any = BusState(CanState.BUS_OFF, 256, 0)
    active: Any = BusState(CanState.ACTIVE, 0, 0)
    bench.hear("181#01")
    assert bench.hear(off) == []
    assert (bench.card.errors.error, bench.card.inputs(201)) == (CAN_ERROR, [])
    assert bench.hear(active) == ["601#40 00 60 01 00 00 00 00", "201#00 00 00 00"]
    assert bench.hear(active) == []


# The bit rate.


@pytest.mark.manual("ARP-011")
@pytest.mark.parametrize("kbaud", [125, 250, 500, 1000])
def test_bit_rate_is_parameter_6_as_it_was_at_the_start(kbaud: int) -> None:
    parameters, can = Parameters(), RecordedLink[Any]()
    parameters.flash[0][Par.CAN_KBAUD] = kbaud * 1000
    parameters.load()
    take_bit_rate(can, parameters)
    assert can.sent == [BitRate(kbaud * 1000)]


@pytest.mark.long
@pytest.mark.manual("ARP-011")
def test_card_with_another_bit_rate_than_its_bus_has_no_remote_io(make: Make) -> None:
    cell = make()
    parameters = Parameters()
    parameters.flash[0][Par.CAN_KBAUD] = 250_000
    parameters.load()
    take_bit_rate(cell.link, parameters)
    cell.enabled()
    assert cell.card.errors.error == CAN_ERROR
    assert cell.rig.get("io1", "nmt.state") == "pre_operational"
