"""The nodes of a MAx-4 over the bus of the OPC UA server, in virtual time."""

from pathlib import Path
from typing import Any

import pytest

from fieldrig.clock import MS, S
from fieldrig.config.rig_file import from_dict
from fieldrig.virtual.node import LocalNode
from fieldrig.virtual.rig import Rig
from fieldrig_bus.opcua import message as opc
from fieldrig_bus.opcua.model import SERVER
from fieldrig_devices.languages.source_file import SourceFile
from fieldrig_devices.max4.configuration.program_file import Container
from fieldrig_devices.max4.controller import Max4

COUNT = "PROGRAM PLC_PRG VAR count : DINT; speed : REAL; END_VAR count := count + 1; END_PROGRAM"


class Bench:
    """A MAx-4 that runs a program, with this bench as the server of its OPC UA bus."""

    def __init__(self, folder: Path) -> None:
        (folder / "count.st").write_text(COUNT)
        device = {"kind": "max4", "links": {"opcua": "ua"}, "program": ["count.st"], "autostart": True}
        data: dict[str, Any] = {
            "time": "virtual",
            "buses": {"ua": {"kind": "opcua.server"}},
            "devices": {"max4": device},
        }
        self.rig = Rig(from_dict(data, folder))
        self.link = self.rig.attach(SERVER).link("ua")
        self.heard: list[opc.OpcUaMessage] = []
        self.link.on_receive(self.heard.append)
        self.rig.run_until(2 * S)

    @property
    def max4(self) -> Max4:
        node = self.rig._engine.nodes["max4"]
        assert isinstance(node, LocalNode)
        assert isinstance(node.device, Max4)
        return node.device

    def ask(self, request: opc.OpcUaMessage) -> opc.OpcUaMessage:
        self.heard.clear()
        self.link.send(request)
        self.rig.run_until(self.rig.now_ns + MS)
        [answer] = [message for message in self.heard if not isinstance(message, opc.Offer)]
        return answer

    def children(self, path: str) -> set[str]:
        answer = self.ask(opc.Browse("max4", 1, path))
        assert isinstance(answer, opc.Nodes)
        return {node.path for node in answer.nodes}

    def outcome(self, request: opc.OpcUaMessage) -> opc.Outcome:
        answer = self.ask(request)
        assert isinstance(answer, opc.Outcomes)
        return answer.outcomes[0]


@pytest.fixture
def bench(tmp_path: Path) -> Bench:
    return Bench(tmp_path)


@pytest.mark.manual("PD-284")
def test_the_nodes_are_the_program_the_configuration_and_the_methods(bench: Bench) -> None:
    methods = {"start()", "stop()", "reset()", "quit()", "force()", "release()", "forced()"}
    assert {"PLC_PRG", "PacDriveM", *methods} <= bench.children("")
    assert bench.children("PLC_PRG") == {"PLC_PRG.count", "PLC_PRG.speed"}
    assert "PacDriveM.DiagCode" in bench.children("PacDriveM")
    answer = bench.ask(opc.Find("max4", 1, "pacdrivem.diagcode"))
    assert isinstance(answer, opc.Nodes)
    [node] = answer.nodes
    assert (node.path, node.kind, node.type, node.is_writable) == (
        "PacDriveM.DiagCode",
        opc.Kind.VARIABLE,
        "UINT",
        False,
    )


def test_a_value_is_that_of_the_instant_of_reading(bench: Bench) -> None:
    first, second = (bench.outcome(opc.Read("max4", 1, ("PLC_PRG.count",))).value for _ in range(2))
    bench.rig.run_until(bench.rig.now_ns + S)
    third = bench.outcome(opc.Read("max4", 1, ("PLC_PRG.count",))).value
    assert isinstance(first, int)
    assert isinstance(third, int)
    assert second in (first, first + 1)
    assert third - first in (100, 101)  # a program without a task configuration runs every 10 ms


def test_variables_and_parameters_are_written(bench: Bench) -> None:
    assert bench.outcome(opc.Write("max4", 1, "PLC_PRG.speed", 2.5)).status is opc.Status.GOOD
    assert bench.outcome(opc.Read("max4", 1, ("PLC_PRG.speed",))) == opc.Outcome(opc.Status.GOOD, 2.5)
    assert bench.outcome(opc.Write("max4", 1, "PacDriveM.DiagCode", 1)).status is opc.Status.NOT_WRITABLE


def test_methods_are_the_commands_of_an_operator(bench: Bench) -> None:
    for path, is_running in (("stop()", False), ("start()", True), ("quit()", True)):
        assert bench.outcome(opc.Call("max4", 1, path)).status is opc.Status.GOOD
        assert bench.max4.firmware.plc.is_running is is_running


def test_forcing_is_that_of_the_debugger(bench: Bench) -> None:
    def debug(**question: Any) -> Any:
        return bench.max4.answer("debug", question)

    assert bench.outcome(opc.Call("max4", 1, "force()", ("PLC_PRG.count", 7))).status is opc.Status.GOOD
    bench.rig.run_until(bench.rig.now_ns + S)
    assert bench.outcome(opc.Read("max4", 1, ("PLC_PRG.count",))).value == 7
    assert [variable["path"] for variable in debug(command="forced")["variables"]] == ["PLC_PRG.count"]
    debug(command="force", values={"PLC_PRG.speed": 1.5})
    assert bench.outcome(opc.Call("max4", 1, "forced()")).results == (["PLC_PRG.count", "PLC_PRG.speed"],)
    assert bench.outcome(opc.Call("max4", 1, "release()", ("",))).status is opc.Status.GOOD
    assert debug(command="forced")["variables"] == []


def test_a_parameter_of_the_controller_cannot_be_forced(bench: Bench) -> None:
    outcome = bench.outcome(opc.Call("max4", 1, "force()", ("PacDriveM.Timer1", 7)))
    assert (outcome.status, outcome.arguments) == (
        opc.Status.WRONG_ARGUMENTS,
        (opc.Status.NOT_SUPPORTED, opc.Status.GOOD),
    )


def test_a_call_with_too_few_arguments_is_refused(bench: Bench) -> None:
    assert bench.outcome(opc.Call("max4", 1, "force()")).status is opc.Status.REFUSED


@pytest.mark.parametrize("is_online", [True, False])
def test_the_nodes_follow_a_download_and_an_online_change(bench: Bench, is_online: bool) -> None:
    text = COUNT.replace("speed : REAL;", "speed : REAL; more : BOOL;")
    bench.heard.clear()
    plc = bench.max4.firmware.plc
    container = Container((SourceFile("count.st", text),), "epas-4")
    (plc.downloads.change if is_online else plc.downloads.download)(plc.order(container))
    bench.rig.run_until(bench.rig.now_ns + S)
    assert [type(message) for message in bench.heard] == [opc.Offer]
    assert bench.children("PLC_PRG") == {"PLC_PRG.count", "PLC_PRG.speed", "PLC_PRG.more"}
