"""LSS slave, CiA 305: identity 00000000h, 00000020h, 00010000h, 00000001h of the I/O module."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from canopen_bench import IO32, LEVEL_SENSOR, CanopenBench, parse
from full_store import FullStore
from pydantic import ValidationError

from fieldrig.clock import MS
from fieldrig.config.rig_file import from_dict
from fieldrig.storage.store import MemoryStore, Store
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen.node import CanopenSettings

CONFIGURE, WAIT = "04 01 00 00 00 00 00 00", "04 00 00 00 00 00 00 00"
NODE_ID_7 = "11 07 00 00 00 00 00 00"
STORE = "17 00 00 00 00 00 00 00"
INQUIRE_NODE_ID = "5e 00 00 00 00 00 00 00"
SELECT = ["40 00 00 00 00", "41 20 00 00 00", "42 00 00 01 00", "43 01 00 00 00"]
IDENTIFY = ["46 00 00 00 00", "47 20 00 00 00", "48 00 00 00 00", "49 00 00 01 00", "4a 01 00 00 00", "4b ff 00 00 00"]
SELECTED, IDENTIFIED, NON_CONFIGURED = (f"7E4#{byte} 00 00 00 00 00 00 00" for byte in ("44", "4f", "50"))


def lss(bench: CanopenBench, *requests: str) -> list[str]:
    """Return a function that sends requests, padded to 8 bytes, and returns the answers."""
    return bench.send(*("7E5#" + bytes.fromhex(request).ljust(8, b"\x00").hex(" ") for request in requests))


def non_configured(**settings: Any) -> CanopenBench:
    return CanopenBench(node_id=None, **settings)


def test_waiting_slave_tells_nothing(bench: CanopenBench) -> None:
    assert lss(bench, INQUIRE_NODE_ID, "5a", NODE_ID_7, STORE, "13 00 02", "15 00 00") == []


def test_identity_and_node_id_are_told(bench: CanopenBench) -> None:
    assert lss(bench, CONFIGURE, "5a", "5b", "5c", "5d", "5e") == [
        "7E4#5a 00 00 00 00 00 00 00",
        "7E4#5b 20 00 00 00 00 00 00",
        "7E4#5c 00 00 01 00 00 00 00",
        "7E4#5d 01 00 00 00 00 00 00",
        "7E4#5e 05 00 00 00 00 00 00",
    ]
    assert lss(bench, WAIT, "5e") == []


def test_whole_identity_selects(bench: CanopenBench) -> None:
    assert lss(bench, *SELECT[:3]) == []
    assert bench.point("lss.state") == "waiting"
    assert lss(bench, SELECT[3]) == [SELECTED]
    assert bench.point("lss.state") == "configuration"


@pytest.mark.parametrize(
    "requests",
    [
        [SELECT[0], SELECT[1], SELECT[2], "43 02 00 00 00"],
        [SELECT[0], "41 21 00 00 00", SELECT[2], SELECT[3]],
        [SELECT[1], SELECT[0], SELECT[2], SELECT[3]],
        [SELECT[1], SELECT[2], SELECT[3]],
        [SELECT[3]],
    ],
)
def test_another_identity_or_order_does_not(bench: CanopenBench, requests: list[str]) -> None:
    assert lss(bench, *requests) == []
    assert bench.point("lss.state") == "waiting"


def test_slave_within_the_ranges_is_identified(bench: CanopenBench) -> None:
    assert lss(bench, *IDENTIFY) == [IDENTIFIED]
    assert lss(bench, IDENTIFY[5]) == []


@pytest.mark.parametrize(
    ("step", "request_"),
    [
        (0, "46 01 00 00 00"),
        (1, "47 21 00 00 00"),
        (2, "48 01 00 01 00"),
        (3, "49 ff ff 00 00"),
        (4, "4a 02 00 00 00"),
        (5, "4b 00 00 00 00"),
    ],
)
def test_slave_outside_of_a_range_is_not(bench: CanopenBench, step: int, request_: str) -> None:
    assert lss(bench, *IDENTIFY[:step], request_, *IDENTIFY[step + 1 :]) == []


@pytest.mark.long
def test_new_node_id_takes_effect_with_the_reset_of_communication(bench: CanopenBench) -> None:
    assert lss(bench, CONFIGURE, NODE_ID_7) == ["7E4#11 00 00 00 00 00 00 00"]
    lss(bench, WAIT)
    assert bench.sdo("40 00 10 00 00 00 00 00") != ""
    assert bench.send("000#82 05") == ["707#00"]
    assert bench.send("607#40 00 18 01 00 00 00 00") == ["587#43 00 18 01 87 01 00 40"]
    assert bench.sdo("40 00 10 00 00 00 00 00") == ""
    assert bench.interest[:4] == [0x000, 0x080, 0x100, 0x207]


def test_reset_of_the_node_brings_the_old_one_back_if_the_new_was_not_stored(bench: CanopenBench) -> None:
    lss(bench, CONFIGURE, NODE_ID_7)
    assert bench.send("000#82 00") == ["707#00"]
    assert bench.send("000#81 00") == ["705#00"]


def test_stored_node_id_outlasts_power_off(bench: CanopenBench) -> None:
    assert lss(bench, CONFIGURE, NODE_ID_7, STORE)[1:] == ["7E4#17 00 00 00 00 00 00 00"]
    assert bench.send("000#81 00") == ["707#00"]
    again = CanopenBench(store=bench.store)
    assert again.take() == ["707#00"]
    assert again.point("1800:01") == 0x4000_0187


def test_node_id_changed_in_the_configuration_goes_before_a_stored_one(bench: CanopenBench) -> None:
    lss(bench, CONFIGURE, NODE_ID_7, STORE)
    assert CanopenBench(store=bench.store, node_id=9).take() == ["709#00"]


@pytest.mark.parametrize(("node_id", "error"), [("00", "01"), ("80", "01"), ("fe", "01"), ("01", "00"), ("ff", "00")])
def test_node_ids_that_are_none_are_refused(bench: CanopenBench, node_id: str, error: str) -> None:
    assert lss(bench, CONFIGURE, f"11 {node_id}") == [f"7E4#11 {error} 00 00 00 00 00 00"]


def test_store_that_fails_is_told() -> None:
    bench = CanopenBench(store=FullStore())
    bench.take()
    assert lss(bench, CONFIGURE, NODE_ID_7, STORE)[1:] == ["7E4#17 02 00 00 00 00 00 00"]
    assert bench.send("000#81 00") == ["705#00"]


# Unconfigured nodes


def test_node_without_a_node_id_waits_silently() -> None:
    bench = non_configured(objects={"1017:00": 100})
    assert bench.after(1000) == []
    assert bench.interest == [0x7E5]
    assert bench.send("000#01 00", "000#81 00", "000#82 00", "605#40 00 10 00 00 00 00 00", "080#") == []
    assert (bench.point("node_id"), bench.point("nmt.state")) == (255, "initialising")


def test_node_boots_up_when_it_has_got_one() -> None:
    bench = non_configured(objects={"1017:00": 100})
    assert lss(bench, CONFIGURE, INQUIRE_NODE_ID) == ["7E4#5e ff 00 00 00 00 00 00"]
    assert lss(bench, NODE_ID_7) == ["7E4#11 00 00 00 00 00 00 00"]
    assert lss(bench, WAIT) == ["707#00"]
    assert bench.after(100) == ["707#7f"]
    assert bench.send("607#40 14 10 00 00 00 00 00") == ["587#43 14 10 00 87 00 00 00"]
    assert lss(bench, WAIT) == []


def test_node_without_a_node_id_stays_so_without_one() -> None:
    bench = non_configured()
    assert lss(bench, CONFIGURE, WAIT) == []
    assert lss(bench, CONFIGURE, "11 ff", WAIT) == ["7E4#11 00 00 00 00 00 00 00"]


def test_node_can_lose_its_node_id(bench: CanopenBench) -> None:
    lss(bench, CONFIGURE, "11 ff", WAIT)
    assert bench.send("000#82 05") == []
    assert bench.interest == [0x7E5]


def test_non_configured_slaves_are_identified(bench: CanopenBench) -> None:
    assert lss(non_configured(), "4c") == [NON_CONFIGURED]
    assert lss(bench, "4c") == []


def scan(number: int, bit: int, part: int, following: int) -> str:
    return (b"\x51" + number.to_bytes(4, "little") + bytes((bit, part, following))).hex(" ")


def test_fastscan_finds_each_bit_of_the_identity() -> None:
    """A bit without an answer is 1, as it is in a master."""
    bench = non_configured()
    assert lss(bench, scan(0, 0x80, 0, 0)) == [IDENTIFIED]
    found = [0, 0, 0, 0]
    for part in range(4):
        for bit in reversed(range(32)):
            if not lss(bench, scan(found[part], bit, part, part)):
                found[part] |= 1 << bit
        assert lss(bench, scan(found[part], 0, part, (part + 1) & 3)) == [IDENTIFIED]
    assert found == [0, 0x20, 0x10000, 1]
    assert bench.point("lss.state") == "configuration"


@pytest.mark.parametrize(
    "request_", [scan(0, 32, 0, 0), scan(0, 0x81, 0, 0), scan(0, 5, 4, 0), scan(0, 5, 0, 4), scan(0, 5, 1, 1)]
)
def test_fastscan_that_makes_no_sense_gets_no_answer(request_: str) -> None:
    assert lss(non_configured(), request_) == []


def test_configured_slave_takes_no_part_in_fastscan(bench: CanopenBench) -> None:
    assert lss(bench, scan(0, 0x80, 0, 0)) == []


def test_null_needs_an_eds_with_lss() -> None:
    with pytest.raises(ValidationError, match="needs LSS, but the EDS has LSS_Supported=0; expected a number"):
        CanopenSettings.model_validate({"node_id": None, "eds": str(LEVEL_SENSOR)})
    CanopenSettings.model_validate({"node_id": None, "eds": str(IO32)})


# Bit timing


@pytest.mark.parametrize(
    ("request_", "error"),
    [("13 00 00", "00"), ("13 00 08", "00"), ("13 00 05", "01"), ("13 00 09", "01"), ("13 01 02", "01")],
)
def test_bit_timings_are_those_of_the_eds(bench: CanopenBench, request_: str, error: str) -> None:
    assert lss(bench, CONFIGURE, request_) == [f"7E4#13 {error} 00 00 00 00 00 00"]


def test_activated_bit_timing_is_kept_and_silence_before_and_after(bench: CanopenBench) -> None:
    bench.write("2b 17 10 00 0a 00 00 00")
    lss(bench, CONFIGURE, "13 00 03", STORE)
    assert lss(bench, "15 64 00") == []
    assert bench.after(99) == [] == bench.can.bit_rates
    assert bench.after(1) == []
    assert bench.can.bit_rates == [250_000]
    assert bench.after(99) == []
    assert lss(bench, INQUIRE_NODE_ID) == []
    assert bench.after(50)[:1] == ["705#7f"]
    assert bench.point("lss.bit_rate") == 250_000
    again = CanopenBench(store=bench.store)
    assert again.point("lss.bit_rate") == 250_000
    assert again.can.bit_rates == [250_000]


def test_bit_rate_stays_that_of_the_bus_until_lss_says_another(bench: CanopenBench) -> None:
    lss(bench, CONFIGURE, "15 00 00")
    assert bench.send("000#81 05") == ["705#00"]
    assert bench.can.bit_rates == []


@pytest.mark.parametrize(
    "frame", ["7E5#", "7E5#R", "7E5#04", "7E5#04 01 00 00 00 00 00", "7E5#ff 01 00 00 00 00 00 00"]
)
def test_anything_else_is_ignored(bench: CanopenBench, frame: str) -> None:
    assert bench.send(frame) == []
    assert bench.point("lss.state") == "waiting"


def test_without_lss_in_the_eds_there_is_none() -> None:
    assert 0x7E5 not in CanopenBench(LEVEL_SENSOR).interest


class DeafOrNot:
    """The I/O module on a bus of 500 kbit/s, with a client."""

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        self._master = rig.attach("master").link("can0")
        self._answers: list[CanFrame] = []
        self._master.on_receive(self._answers.append, [[0x580, 0x780], [0x7E4, 0x7FF]])

    def ask(self, *frames: str, ms: int = 5) -> int:
        """Send a request, and return the number of answers."""
        self._answers.clear()
        for frame in frames:
            self._master.send(parse(frame))
            self._rig.run_until(self._rig.now_ns + ms * MS)
        return len(self._answers)


READ_DEVICE_TYPE = "605#40 00 10 00 00 00 00 00"


@pytest.fixture
def on_a_bus() -> Iterator[Callable[[Store], Rig]]:
    rigs: list[Rig] = []

    def make(store: Store) -> Rig:
        node = {"kind": "canopen.node", "node_id": 5, "eds": str(IO32), "links": {"can": "can0"}}
        buses = {"can0": {"kind": "can.virtual", "bitrate": 500_000, "acknowledge": "always"}}
        config = from_dict({"time": "virtual", "buses": buses, "devices": {"io": node}})
        rigs.append(Rig(config, stores={"io": store}))
        return rigs[-1]

    yield make
    for rig in rigs:
        rig.close()


def test_node_with_another_bit_rate_than_the_bus_is_deaf_until_it_is_switched_off(
    on_a_bus: Callable[[Store], Rig],
) -> None:
    store = MemoryStore()
    bus = DeafOrNot(on_a_bus(store))
    assert bus.ask(READ_DEVICE_TYPE) == 1
    for request in (CONFIGURE, "13 00 03"):
        bus.ask("7E5#" + bytes.fromhex(request).ljust(8, b"\0").hex(" "))
    assert bus.ask("7E5#15 0a 00 00 00 00 00 00", ms=50) == 0
    assert bus.ask(READ_DEVICE_TYPE) == 0
    assert DeafOrNot(on_a_bus(store)).ask(READ_DEVICE_TYPE) == 1


def test_stored_bit_rate_holds_from_power_on(on_a_bus: Callable[[Store], Rig]) -> None:
    store = MemoryStore()
    bus = DeafOrNot(on_a_bus(store))
    for request in (CONFIGURE, "13 00 03", STORE):
        bus.ask("7E5#" + bytes.fromhex(request).ljust(8, b"\0").hex(" "))
    assert bus.ask(READ_DEVICE_TYPE) == 1  # not activated yet
    assert DeafOrNot(on_a_bus(store)).ask(READ_DEVICE_TYPE) == 0


def test_bit_rate_of_the_bus_may_be_activated(on_a_bus: Callable[[Store], Rig]) -> None:
    bus = DeafOrNot(on_a_bus(MemoryStore()))
    for request in (CONFIGURE, "13 00 02", "15 0a 00"):
        bus.ask("7E5#" + bytes.fromhex(request).ljust(8, b"\0").hex(" "))
    assert bus.ask(READ_DEVICE_TYPE) == 0  # the switch delay
    assert bus.ask("080#", READ_DEVICE_TYPE, ms=20) == 1
