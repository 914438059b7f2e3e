"""An OPC UA server on a hub in this process, with a device of two belts behind it."""

import asyncio
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from functools import cache
from pathlib import Path
from typing import Any
from unittest.mock import patch

from asyncua import ua
from asyncua.server.address_space import AddressSpace, AttributeValue, NodeData, NodeManagementService
from asyncua.server.standard_address_space import standard_address_space

from fieldrig.device import Point, Value
from fieldrig.hub.hub import LocalHub
from fieldrig.loop.real_clock import RealClock
from fieldrig.points.checks import number_in
from fieldrig.testing import free_port
from fieldrig_bus.opcua.message import NODE, VALUE, AnyValue, Argument, OpcUaMessage, Read, Status
from fieldrig_bus.opcua.server import OpcUaServer, OpcUaSettings
from fieldrig_devices.opcua.face import OpcUaFace
from fieldrig_devices.opcua.methods import Method, MethodsTree
from fieldrig_devices.opcua.points import PointsTree
from fieldrig_devices.opcua.tree import Trees, WrongArgumentsError


class Plc:
    """A device with points `belt.Position` (mm, at least 0), `belt.On` (read-only) and methods.

    start and stop have no arguments; hold(Variable, Value) holds a variable that is not read-only, and held() returns
    the held ones.
    """

    def __init__(self) -> None:
        self.values: dict[str, Value] = {"belt.Position": 1.5, "belt.On": True}
        self.called: list[str] = []
        self.held: dict[str, AnyValue] = {}
        self.reads = 0

    def points(self) -> dict[str, Point]:
        def write(value: Value) -> None:
            self.values["belt.Position"] = number_in(value, 0.0)

        found = {key: Point(lambda key=key: self.values[key]) for key in self.values}  # type: ignore[misc]
        found["belt.Position"] = Point(lambda: self.values["belt.Position"], write, "mm", "position of the belt")
        return found

    def start(self) -> None:
        self.called.append("start")

    def stop(self) -> None:
        raise ValueError("it is not running")

    def hold(self, path: str, value: AnyValue) -> None:
        if path == "belt.On":
            raise WrongArgumentsError(Status.NOT_WRITABLE, Status.GOOD)
        self.held[path] = value

    def tree(self) -> Trees:
        variable, value = Argument("Variable", NODE, "what to hold"), Argument("Value", VALUE, "where to hold it")
        held = Argument("Variables", NODE, "what is held", is_array=True)
        methods = {
            "start": Method("start the belt", self.start),
            "stop": Method("stop the belt", self.stop),
            "hold": Method("hold a variable", self.hold, (variable, value)),
            "held": Method("return what is held", lambda: [list(self.held)], results=(held,), is_writable=False),
        }
        return Trees([PointsTree(self.points), MethodsTree(methods)])


class ServerBench:
    def __init__(self, hub: LocalHub, settings: OpcUaSettings, run: Path) -> None:
        self.hub, self.settings, self.run = hub, settings, run
        self.url = f"opc.tcp://{settings.listen}"
        self.plc = Plc()
        self.face = OpcUaFace("plc", "a PLC", hub.join("plc"), self.plc.tree)
        self.asked: list[OpcUaMessage] = []
        hub.on_delivery(lambda delivery: self.asked.append(delivery.message))

    def reads(self) -> int:
        """The number of Read requests since the last call."""
        count = sum(isinstance(message, Read) for message in self.asked)
        self.asked.clear()
        return count


@cache
def standard_nodes() -> Mapping[ua.NodeId, NodeData]:
    """The nodes of the standard, which the library makes again for each server, in a second of CPU time."""
    space = AddressSpace()
    standard_address_space.fill_address_space(NodeManagementService(space))
    nodes: Mapping[ua.NodeId, NodeData] = space._nodes
    return nodes


def fill(service: NodeManagementService) -> None:
    """Fill an address space with copies of the nodes of the standard: a server changes attributes and references."""
    for identifier, node in standard_nodes().items():
        copied = NodeData(identifier)
        copied.attributes = {which: AttributeValue(each.value) for which, each in node.attributes.items()}
        copied.references = [*node.references]
        service._aspace[identifier] = copied


@asynccontextmanager
async def server_bench(run: Path, **settings: Any) -> AsyncIterator[ServerBench]:
    clock = RealClock(asyncio.get_running_loop())
    found = OpcUaSettings(listen=f"127.0.0.1:{free_port()}", **settings)
    hub = LocalHub(OpcUaServer("ua", found), clock, run / "bench")
    bench = ServerBench(hub, found, run / "bench")
    bench.face.offer()
    standard_nodes()
    with patch.object(standard_address_space, "fill_address_space", fill):
        await hub.open(serve=False)
    try:
        yield bench
    finally:
        await hub.close()
        clock.close()
