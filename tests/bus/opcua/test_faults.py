"""Each fault of an OPC UA bus: status codes of OPC 10000-4, 7.39.2, late answers, lost connections."""

from random import Random
from typing import Any

import pytest
from asyncua import Client, ua
from in_loop import in_loop
from opcua_bench import server_bench

from fieldrig import Rig, from_dict
from fieldrig.bus import BusModel, Delivery
from fieldrig.clock import MS
from fieldrig.faults.disturbed import medium_of
from fieldrig.faults.note import FaultNote
from fieldrig_bus.opcua import traced
from fieldrig_bus.opcua.message import Hangup, OnOpcUa, Outcome, Outcomes, Read, Status, Write
from fieldrig_bus.opcua.model import SERVER
from fieldrig_bus.opcua.server import OpcUaServer, OpcUaSettings

GOOD = Outcome(Status.GOOD, 1.5)


class Bench:
    """A server that reads `a` and `b` of a device, and writes `a`."""

    def __init__(self, *faults: dict[str, Any]) -> None:
        bus: Any = OpcUaServer("opc", OpcUaSettings.model_validate({"faults": list(faults)}))
        self.model: BusModel[OnOpcUa] = medium_of(bus)
        self.model.begin(0, Random("1/opc"))
        for member in (SERVER, "plc"):
            self.model.join(member)
            self.model.listen(0, member, None)
        self.trace: list[Delivery[Any]] = []

    def exchange(self) -> list[tuple[int, list[Status]]]:
        """The milliseconds and status of the answers that the server gets."""
        self.model.submit(0, SERVER, Read("plc", 1, ("a", "b")))
        self.model.submit(0, "plc", Outcomes(1, (GOOD, GOOD)))
        self.model.submit(0, SERVER, Write("plc", 2, "a", 2.0))
        self.model.submit(0, "plc", Outcomes(2, (GOOD,)))
        while (next_ns := self.model.next_ns()) is not None:
            self.trace += self.model.collect(next_ns)
        heard = [each for each in self.trace if SERVER in each.receivers and isinstance(each.message, Outcomes)]
        return [(each.time_ns // MS, [outcome.status for outcome in each.message.outcomes]) for each in heard]


@pytest.mark.parametrize(
    ("fault", "answers"),
    [
        ({"what": "bad_quality"}, [(0, [Status.SENSOR_FAILURE] * 2), (0, [Status.GOOD])]),
        ({"what": "bad_quality", "path": "b", "status": "bad"}, [(0, [Status.GOOD, Status.BAD]), (0, [Status.GOOD])]),
        ({"what": "drop", "nth": 2}, [(0, [Status.GOOD] * 2)]),
        ({"what": "drop", "path": "b"}, [(0, [Status.GOOD])]),
        ({"what": "delay", "delay_ms": 300, "count": 1}, [(0, [Status.GOOD]), (300, [Status.GOOD] * 2)]),
    ],
    ids=str,
)
def test_what_the_server_gets(fault: dict[str, Any], answers: list[tuple[int, list[Status]]]) -> None:
    bench = Bench(fault)
    assert bench.exchange() == answers
    assert sum(isinstance(each.message, FaultNote) for each in bench.trace) == 1


def test_a_lost_session_is_told_to_the_server_once() -> None:
    bench = Bench()
    bench.model.add_fault(0, {"what": "lost_session"})
    bench.exchange()
    assert next(each.message for each in bench.trace if SERVER in each.receivers) == Hangup()
    assert bench.model.all_faults(0)[1]["applied"] == 1
    for message in (Hangup(), FaultNote(1, "delayed"), Outcomes(1, (GOOD,))):
        assert traced.decode(traced.encode(message)) == message
        assert traced.show(message)


def test_a_session_is_lost_where_no_server_runs() -> None:
    """A rig in virtual time has a server only for the clients of a master."""
    with Rig(from_dict({"time": "virtual", "buses": {"opc": {"kind": "opcua.server"}}, "devices": {}})) as rig:
        number = rig.add_fault("opc", {"what": "lost_session", "duration_ms": 10})
        rig.run_for(MS)
        assert rig.faults("opc")[number]["state"] == "on"
        rig.run_for(10 * MS)
        assert rig.faults("opc")[number]["state"] == "over"


def test_a_device_that_is_not_there_is_refused() -> None:
    with pytest.raises(ValueError, match="no device 'plx'"):
        Bench().model.add_fault(0, {"what": "drop", "device": "plx"})


@pytest.mark.system
@in_loop
async def test_a_client_sees_the_status_and_loses_its_connection(tmp_path: Any) -> None:
    async with server_bench(tmp_path) as bench:
        client = Client(bench.url)
        await client.connect()
        node = client.get_node("ns=2;s=belt.Position")
        number = bench.hub.add_fault({"what": "bad_quality", "status": "device_failure"})
        value = await node.read_data_value(raise_on_bad_status=False)
        assert value.StatusCode.value == ua.StatusCodes.BadDeviceFailure
        bench.hub.clear_fault(number)
        assert await node.read_value() == 1.5
        bench.hub.add_fault({"what": "lost_session"})
        with pytest.raises((ConnectionError, ua.UaError, TimeoutError)):
            await node.read_value()
        async with Client(bench.url) as again:
            assert await again.get_node("ns=2;s=belt.Position").read_value() == 1.5
        client.disconnect_socket()
