"""The conformance suite on one node of a rig in virtual time, whole or broken."""

from pathlib import Path
from typing import Any

from broken_nodes import NODE_ID
from canopen_bench import IO32

from fieldrig.config.rig_file import from_dict
from fieldrig.virtual.rig import Rig
from fieldrig_devices.conformance.description import Description
from fieldrig_devices.conformance.options import Options
from fieldrig_devices.conformance.report import Report
from fieldrig_devices.conformance.run import choose, conform_virtual
from fieldrig_devices.conformance.suite import Verdict

HERE = Path(__file__).parent
ALONE = Options(is_alone=True)


def rig_of(eds: Path = IO32, fault: str | None = None, **settings: Any) -> dict[str, Any]:
    kind = {"kind": "canopen.node"} if fault is None else {"kind": "broken_nodes:BrokenNode", "fault": fault}
    node = {**kind, "node_id": NODE_ID, "eds": str(eds), "links": {"can": "can0"}, **settings}
    return {"time": "virtual", "buses": {"can0": {"kind": "can.virtual"}}, "devices": {"node": node}}


def conformed(
    *only: str, eds: Path = IO32, fault: str | None = None, options: Options = ALONE, **settings: Any
) -> Report:
    with Rig(from_dict(rig_of(eds, fault, **settings), HERE)) as rig:
        return conform_virtual(rig, "can0", Description(eds, NODE_ID), choose(only), options)


def numbers(report: Report, verdict: Verdict) -> list[str]:
    return [item.case.number for item in report.of(verdict)]


def failures(report: Report) -> dict[str, str]:
    return {item.case.number: item.reason for item in report.of(Verdict.FAILED)}
