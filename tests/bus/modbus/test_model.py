"""The messages that members of a Modbus bus receive, and their instants."""

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.bus import BusModel, Delivery
from fieldrig.clock import MS, S
from fieldrig_bus.modbus.framing import LineTiming, Mode
from fieldrig_bus.modbus.line_model import LineModel
from fieldrig_bus.modbus.message import (
    CONNECTIONS,
    ClientConnected,
    LineState,
    ModbusMessage,
    ModbusRequest,
    ModbusResponse,
)
from fieldrig_bus.modbus.model import ModbusModel
from fieldrig_bus.modbus.routing import MOST_OPEN

READ = bytes.fromhex("03 0000 0001")
VALUE = bytes.fromhex("03 02 0001")
TIMING = LineTiming("rtu", 9600, 11)
REQUEST_NS = TIMING.frame_ns(5) + TIMING.silence_ns
RESPONSE_NS = TIMING.frame_ns(4) + TIMING.silence_ns


def joined(model: BusModel[Any], **interests: list[Any] | None) -> BusModel[Any]:
    for member, interest in interests.items():
        model.join(member)
        model.listen(0, member, interest)
    return model


def all_of(model: BusModel[Any], now_ns: int = 10**15) -> list[Delivery[ModbusMessage]]:
    return model.collect(now_ns)


def test_a_request_goes_to_the_servers_of_its_unit_and_the_response_to_its_client() -> None:
    model = joined(ModbusModel(), first=[1], second=[2, 3], all=None, master=[], other=[])
    model.submit(5, "master", ModbusRequest(3, READ, 77))
    (asked,) = all_of(model)
    assert (asked.time_ns, asked.sender, asked.receivers) == (5, "master", ("second", "all"))
    model.submit(9, "second", ModbusResponse(3, VALUE, asked.message.exchange))
    assert all_of(model) == [Delivery(9, "second", ModbusResponse(3, VALUE, 77), ("master",))]


def test_exchange_numbers_of_two_masters_do_not_mix() -> None:
    model = joined(ModbusModel(), drive=[1], a=[], b=[])
    for master in ("a", "b"):
        model.submit(0, master, ModbusRequest(1, READ, 1))
    first, second = all_of(model)
    assert first.message.exchange != second.message.exchange
    for asked in (second, first):
        model.submit(1, "drive", ModbusResponse(1, VALUE, asked.message.exchange))
    assert [delivery.receivers for delivery in all_of(model)] == [("b",), ("a",)]


def test_an_answer_without_a_request_is_dropped() -> None:
    model = joined(ModbusModel(), drive=[1], master=[])
    model.submit(0, "master", ModbusRequest(1, READ))
    (asked,) = all_of(model)
    answer = ModbusResponse(1, VALUE, asked.message.exchange)
    model.leave("master")
    model.submit(1, "drive", answer)
    model.submit(1, "drive", ModbusResponse(1, VALUE, 999))
    assert all_of(model) == []
    assert model.statistics(0)["responses without a request"] == 2


def test_a_server_that_is_silent_fills_no_memory() -> None:
    model = joined(ModbusModel(), drive=[1], master=[])
    for _ in range(MOST_OPEN + 1):
        model.submit(0, "master", ModbusRequest(1, READ))
    first, *_, last = all_of(model)
    for asked in (first, last):
        model.submit(1, "drive", ModbusResponse(1, VALUE, asked.message.exchange))
    assert len(all_of(model)) == 1


@pytest.mark.parametrize(
    ("unit", "direct_unit", "units", "heard_as"),
    [
        (0, None, [7], 7),
        (255, None, [7], 7),
        (0, None, [7, 8], None),
        (255, 8, [7, 8], 8),
        (6, None, [7], None),
    ],
)
def test_on_tcp_units_0_and_255_mean_the_only_unit(
    unit: int, direct_unit: int | None, units: list[int], heard_as: int | None
) -> None:
    model = joined(ModbusModel(direct_unit=direct_unit), drive=units, master=[])
    model.submit(0, "master", ModbusRequest(unit, READ))
    (asked,) = all_of(model)
    assert (asked.message.unit if asked.receivers else None) == heard_as
    if heard_as is not None:
        model.submit(0, "drive", ModbusResponse(heard_as, VALUE, asked.message.exchange))
        assert all_of(model)[0].message.unit == unit


def test_a_gateway_answers_for_a_unit_that_is_not_there() -> None:
    model = joined(ModbusModel(answers_for_unknown_units=True), drive=[1], master=[])
    model.submit(3, "master", ModbusRequest(2, READ, 9))
    _, answer = all_of(model)
    assert answer == Delivery(3, "gateway", ModbusResponse(2, bytes.fromhex("83 0B"), 9), ("master",))


def test_a_server_that_left_is_not_there() -> None:
    model = joined(ModbusModel(answers_for_unknown_units=True), drive=[1], master=[])
    model.submit(0, "master", ModbusRequest(1, READ))
    assert len(all_of(model)) == 1
    model.leave("drive")
    model.submit(1, "master", ModbusRequest(1, READ))
    assert all_of(model)[1].message.pdu == bytes.fromhex("83 0B")


def test_what_was_asked_for_earlier_arrives_earlier_unless_it_is_too_late() -> None:
    model = joined(ModbusModel(), drive=[1], master=[])
    for instant_ns in (20, 10, 30):
        model.submit(instant_ns, "master", ModbusRequest(1, READ, instant_ns))
    assert model.next_ns() == 10
    assert [delivery.time_ns for delivery in all_of(model, 20)] == [10, 20]
    model.submit(5, "master", ModbusRequest(1, READ))
    assert [delivery.time_ns for delivery in all_of(model)] == [20, 30]
    assert model.next_ns() is None


def test_a_broadcast_on_a_line_goes_to_every_server() -> None:
    model = joined(ModbusModel("rtu"), first=[1], second=[2], master=[])
    model.submit(0, "master", ModbusRequest(0, READ, 0, LineState(1)))
    assert all_of(model)[0].receivers == ("first", "second")


def test_a_frame_on_a_line_takes_the_time_of_its_characters() -> None:
    model = joined(LineModel(TIMING, 1 * S), drive=[1], master=[])
    model.submit(0, "master", ModbusRequest(1, READ, 5))
    assert model.next_ns() == REQUEST_NS == 9_166_666 + 4_010_416  # 8 and 3.5 characters of 11 bits
    (asked,) = all_of(model, REQUEST_NS)
    assert asked.message == ModbusRequest(1, READ, asked.message.exchange, LineState(1, 0, False))
    model.submit(REQUEST_NS + 2 * MS, "drive", ModbusResponse(1, VALUE, asked.message.exchange))
    (answer,) = all_of(model)
    assert answer == Delivery(REQUEST_NS + 2 * MS + RESPONSE_NS, "drive", ModbusResponse(1, VALUE, 5), ("master",))


def test_a_line_carries_one_exchange_at_a_time() -> None:
    model = joined(LineModel(TIMING, 1 * S), drive=[1], a=[], b=[])
    model.submit(0, "a", ModbusRequest(1, READ))
    model.submit(0, "b", ModbusRequest(1, READ))
    (asked,) = all_of(model, REQUEST_NS)
    answered_ns = REQUEST_NS + 2 * MS + RESPONSE_NS
    model.submit(REQUEST_NS + 2 * MS, "drive", ModbusResponse(1, VALUE, asked.message.exchange))
    answer, following = all_of(model)
    assert (answer.time_ns, answer.receivers) == (answered_ns, ("a",))
    assert (following.time_ns, following.sender) == (answered_ns + REQUEST_NS, "b")


def test_without_an_answer_the_next_request_waits_for_the_response_timeout() -> None:
    model = joined(LineModel(TIMING, 100 * MS), drive=[1], a=[], b=[])
    model.submit(0, "a", ModbusRequest(9, READ))
    model.submit(0, "b", ModbusRequest(1, READ))
    model.submit(0, "b", ModbusRequest(1, READ))
    lost, _, asked = all_of(model)
    assert lost.receivers == ()
    assert asked.time_ns == 2 * (REQUEST_NS + 100 * MS) + REQUEST_NS


def test_an_answer_after_the_next_request_is_lost() -> None:
    model = joined(LineModel(TIMING, 100 * MS), drive=[1], a=[], b=[])
    model.submit(0, "a", ModbusRequest(1, READ))
    model.submit(0, "b", ModbusRequest(1, READ))
    asked, again = all_of(model)
    model.submit(again.time_ns, "drive", ModbusResponse(1, VALUE, asked.message.exchange))
    assert all_of(model) == []
    assert model.statistics(0)["answers too late"] == 1


def test_a_broadcast_is_not_answered_so_no_client_waits() -> None:
    model = joined(LineModel(TIMING, 100 * MS), drive=[1], a=[])
    model.submit(0, "a", ModbusRequest(0, READ))
    model.submit(0, "a", ModbusRequest(1, READ))
    assert [delivery.time_ns for delivery in all_of(model)] == [REQUEST_NS, 2 * REQUEST_NS]


def test_a_client_that_leaves_takes_its_exchange_along() -> None:
    model = joined(LineModel(TIMING, 1 * S), drive=[1], a=[], b=[])
    model.submit(0, "a", ModbusRequest(1, READ))
    model.submit(0, "a", ModbusRequest(1, READ))
    model.submit(0, "b", ModbusRequest(1, READ))
    assert len(all_of(model, REQUEST_NS)) == 1
    model.leave("a")
    (asked,) = all_of(model)
    assert (asked.sender, asked.time_ns) == ("b", 2 * REQUEST_NS)


def test_a_client_that_asks_anew_has_given_up_what_it_asked_before() -> None:
    model = joined(LineModel(TIMING, 1 * S), drive=[1], a=[])
    model.submit(0, "a", ModbusRequest(1, READ))
    (asked,) = all_of(model, REQUEST_NS)
    model.submit(REQUEST_NS + 100 * MS, "a", ModbusRequest(1, READ, 8))
    (again,) = all_of(model)
    assert again.time_ns == 2 * REQUEST_NS + 100 * MS
    model.submit(again.time_ns, "drive", ModbusResponse(1, VALUE, asked.message.exchange))
    assert all_of(model) == []
    model.submit(again.time_ns, "drive", ModbusResponse(1, VALUE, again.message.exchange))
    assert [delivery.message.exchange for delivery in all_of(model)] == [8]


SERVER = "server:192.168.1.5:502"


def with_server(model: BusModel[Any], units: list[int], **interests: list[Any] | None) -> BusModel[Any]:
    joined(model, **interests)
    for outsider, interest in ((SERVER, units), ("tcp:1", [])):
        model.join(outsider)
        model.listen(0, outsider, interest)
    return model


@pytest.mark.parametrize(
    ("unit", "client", "servers"),
    [
        (7, "plc", (SERVER,)),
        (7, "tcp:1", ()),  # the bus does not connect outside programs with each other
        (1, "tcp:1", ("drive", "plc")),
        (1, "drive", ("plc",)),  # units of the rig take precedence over those outside
        (1, "plc", ("drive",)),
        (2, "plc", (SERVER,)),
        (2, "tcp:1", ("plc",)),
        (0, "tcp:1", ()),
        (9, "plc", ()),
    ],
)
def test_servers_outside_are_for_devices(unit: int, client: str, servers: tuple[str, ...]) -> None:
    model = with_server(ModbusModel(), [1, 2, 7], drive=[1], plc=[1, 2])
    model.submit(0, client, ModbusRequest(unit, READ, 5))
    (asked,) = all_of(model)
    assert asked.receivers == servers


def test_to_masters_a_server_outside_is_no_unit_of_the_rig() -> None:
    model = with_server(ModbusModel(answers_for_unknown_units=True), [7], drive=[3])
    for unit in (255, 7):
        model.submit(0, "tcp:1", ModbusRequest(unit, READ, 5))
    direct, hidden, answer = all_of(model)
    assert (direct.message.unit, direct.receivers, hidden.receivers) == (3, ("drive",), ())
    assert answer.message == ModbusResponse(7, bytes.fromhex("83 0B"), 5)


def test_an_answer_from_outside_has_had_its_time_on_the_line() -> None:
    model = with_server(LineModel(TIMING, 1 * S, 100 * MS), [7], plc=[])
    model.submit(0, "plc", ModbusRequest(7, READ, 5))
    (asked,) = all_of(model)
    assert (asked.time_ns, asked.receivers) == (REQUEST_NS, (SERVER,))
    model.submit(REQUEST_NS + 3 * MS, SERVER, ModbusResponse(7, VALUE, asked.message.exchange))
    assert all_of(model) == [Delivery(REQUEST_NS + 3 * MS, SERVER, ModbusResponse(7, VALUE, 5), ("plc",))]


def test_after_a_broadcast_the_line_is_silent_for_the_turnaround_time() -> None:
    model = with_server(LineModel(TIMING, 1 * S, 100 * MS), [7], plc=[], drive=[1])
    for unit in (0, 7):
        model.submit(0, "plc", ModbusRequest(unit, READ))
    broadcast, asked = all_of(model)
    assert broadcast.receivers == ("drive", SERVER)
    assert (broadcast.time_ns, asked.time_ns) == (REQUEST_NS, 2 * REQUEST_NS + 100 * MS)


def test_a_port_that_keeps_the_time_itself_gets_a_request_when_it_begins() -> None:
    model = with_server(LineModel(TIMING, 100 * MS, is_paced=False), [7], plc=[], drive=[1])
    for unit in (7, 7):
        model.submit(0, "plc", ModbusRequest(unit, READ))
    asked, again = all_of(model)
    assert (asked.time_ns, again.time_ns) == (0, REQUEST_NS + 100 * MS)


@pytest.mark.parametrize("line", [None, "rtu"])
def test_connections_are_delivered_only_on_request(line: Mode | None) -> None:
    model = joined(ModbusModel(line), plc=[1, CONNECTIONS], all=None, drive=[1], master=[])
    model.submit(5, "tcp:1", ClientConnected("10.0.0.9"))
    deliveries: list[Delivery[Any]] = [*all_of(model)]
    assert deliveries == [Delivery(5, "tcp:1", ClientConnected("10.0.0.9"), ("plc",))]
    model.leave("plc")
    model.submit(6, "tcp:2", ClientConnected("10.0.0.9"))
    model.submit(7, "master", ModbusRequest(1, READ))
    assert [delivery.receivers for delivery in all_of(model)] == [(), ("all", "drive")]


def test_a_line_with_times_knows_no_connections() -> None:
    model = joined(LineModel(TIMING, 1 * S), plc=[1, CONNECTIONS])
    model.submit(5, "tcp:1", ClientConnected("10.0.0.9"))
    assert all_of(model) == []


members = st.sampled_from(["drive", "meter", "a", "b"])
steps = st.lists(
    st.tuples(members, st.integers(0, 255), st.booleans(), st.integers(0, 5), st.integers(-3 * MS, 30 * MS)),
    max_size=30,
)


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(steps, st.booleans())
def test_deliveries_are_in_order_of_time_and_nothing_hangs(
    wanted: list[tuple[str, int, bool, int, int]], is_line: bool
) -> None:
    model = joined(LineModel(TIMING, 20 * MS) if is_line else ModbusModel(), drive=[1], meter=None, a=[], b=[])
    now_ns, times = 0, []
    for member, unit, is_request, exchange, pause_ns in wanted:
        now_ns = max(now_ns + pause_ns, 0)
        message = ModbusRequest(unit, READ, exchange) if is_request else ModbusResponse(unit, VALUE, exchange)
        model.submit(now_ns, member, message)
        times += [delivery.time_ns for delivery in model.collect(now_ns)]
    times += [delivery.time_ns for delivery in all_of(model)]
    assert times == sorted(times)
    assert model.next_ns() is None


@pytest.mark.parametrize(("line", "state"), [(None, None), ("rtu", LineState(1, 0)), ("ascii", LineState(1, 0, True))])
def test_a_request_of_a_member_is_one_of_its_line(line: Mode | None, state: LineState | None) -> None:
    """A trace of virtual time says what the bus is, and unit 0 is a broadcast."""
    model = joined(ModbusModel(line), drive=[1], master=[])
    model.submit(0, "master", ModbusRequest(1, READ))
    (delivery,) = all_of(model)
    assert isinstance(delivery.message, ModbusRequest)
    assert delivery.message.line == state
