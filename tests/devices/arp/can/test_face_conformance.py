"""All cases of our conformance suite against the card's CAN node."""

import json
from pathlib import Path

import arp_face
import pytest
from arp_face import NODE_ID
from typer.testing import CliRunner

from fieldrig.cli.app import app
from fieldrig.config.rig_file import from_dict
from fieldrig.system.exits import Exit
from fieldrig.virtual.rig import Rig
from fieldrig_devices.arp.can.face import EDS
from fieldrig_devices.conformance.description import Description
from fieldrig_devices.conformance.options import Options
from fieldrig_devices.conformance.run import choose, conform_virtual
from fieldrig_devices.conformance.suite import Verdict

NOT_THERE = {
    "2.29": "1201h",  # a second SDO server
    "2.30": "1280h",  # an SDO client
    "4.5": "sub-index FFh",
    "8.9": "1020h",
}


@pytest.mark.long
def test_the_card_conforms_to_cia_301() -> None:
    card = {"kind": "arp_face:FaceDevice", "links": {"can": "can0"}}
    config = {"time": "virtual", "buses": {"can0": {"kind": "can.virtual"}}, "devices": {"card": card}}
    with Rig(from_dict(config, Path(arp_face.__file__).parent)) as rig:
        report = conform_virtual(rig, "can0", Description(EDS, NODE_ID), choose(()), Options(is_alone=True))
    assert {result.case.number: result.reason for result in report.of(Verdict.FAILED)} == {}
    missing = {result.case.number: result.reason for result in report.of(Verdict.NOT_APPLICABLE)}
    assert missing.keys() == NOT_THERE.keys()
    assert all(NOT_THERE[number] in reason for number, reason in missing.items())
    assert len(report.of(Verdict.PASSED)) == 122
    assert [result.case.number for result in report.of(Verdict.WARNING)] == ["1.0"]


@pytest.mark.long
def test_a_card_that_starts_itself_and_has_parameters_of_its_rig_conforms(tmp_path: Path) -> None:
    """Once, its states after a reset failed, as it needs no master to start (1F80h), and so did its parameters."""
    card = {
        "kind": "arp",
        "parameters": {"general": {5: 11, 16: 40}, "axis1": {7: 1500, 14: 90}, "axis2": {3: 2}},
        "exchange": {"send": [{"channel": 1, "words": ["POS2", "FLAG2"]}]},
        "links": {"can": "can0"},
    }
    rig = tmp_path / "card.yaml"
    rig.write_text(
        json.dumps({"time": "virtual", "buses": {"can0": {"kind": "can.virtual"}}, "devices": {"card": card}})
    )
    only = [
        word for name in ("OD 02", "OD 08", "Guarding 02", "Heartbeat*", "Transition 01") for word in ("--only", name)
    ]
    done = CliRunner().invoke(app, ["conform", "--rig", str(rig), "--bus", "can0", "--node", "11", "--json", *only])
    assert done.exit_code == Exit.OK, done.output
    report = json.loads(done.stdout)
    assert (report["failed"], report["passed"]) == (0, 18)
