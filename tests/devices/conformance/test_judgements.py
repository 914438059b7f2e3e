"""Verdicts follow the log of CiA's tool where it shows them."""

from pathlib import Path

import pytest
from broken_nodes import FAULTS, Fault, Frames, is_abort, sdo
from canopen_bench import IO32
from conform_bench import conformed, numbers, rig_of

from fieldrig.config.rig_file import from_dict
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.conformance.allowed import ALLOWED
from fieldrig_devices.conformance.case import CASES
from fieldrig_devices.conformance.description import Description
from fieldrig_devices.conformance.report import as_data
from fieldrig_devices.conformance.run import choose, conform_virtual
from fieldrig_devices.conformance.suite import Verdict

# From the log: an answer of CANopenNode with which it passed.
EMCY = 0x085
RESERVED_CODE = 0x0504_0005


class Refuses(Fault):
    """Refuses everything with this code."""

    code = 0

    def from_node(self, frame: CanFrame) -> Frames:
        yield sdo(frame.data[:4] + self.code.to_bytes(4, "little")) if is_abort(frame) else frame


def refused_with(monkeypatch: pytest.MonkeyPatch, code: int, *cases: str) -> list[str]:
    monkeypatch.setitem(FAULTS, "Refuses", Refuses)
    monkeypatch.setattr(Refuses, "code", code)
    return [CASES[number].name for number in numbers(conformed(*cases, fault="Refuses"), Verdict.FAILED)]


@pytest.mark.parametrize("code", sorted({code for codes in ALLOWED.values() for code in codes}))
def test_refusal_is_accepted_with_the_codes_that_the_log_allows_and_no_others(
    monkeypatch: pytest.MonkeyPatch, code: int
) -> None:
    cases = [name for name in ALLOWED if name != "SDO 28"]
    assert refused_with(monkeypatch, code, *cases) == [name for name in cases if code not in ALLOWED[name]]


def test_code_that_no_case_allows_is_refused_by_all(monkeypatch: pytest.MonkeyPatch) -> None:
    assert refused_with(monkeypatch, RESERVED_CODE, *ALLOWED) == list(ALLOWED)


def checked(folder: Path, *edits: tuple[str, str]) -> dict[str, object]:
    """Return the result of the EDS checker for the I/O module's file with changes."""
    text = IO32.read_text()
    for old, new in edits:
        assert old in text
        text = text.replace(old, new)
    eds = folder / "io32.eds"
    eds.write_text(text)
    with Rig(from_dict(rig_of(), folder)) as rig:
        report = conform_virtual(rig, "can0", Description(eds, 5), choose(["1.0"]))
    data = as_data(report)
    assert (data["passed"], data["warnings"], data["failed"]).count(1) == 1
    case: dict[str, object] = data["cases"][0]
    return case


def test_missing_order_code_is_a_warning(tmp_path: Path) -> None:
    case = checked(tmp_path, ("OrderCode=IO32\n", ""))
    assert (case["verdict"], "OrderCode is missing" in str(case["reason"])) == ("warning", True)


def test_access_without_a_direction_of_mapping_is_a_warning(tmp_path: Path) -> None:
    """Like the 43 warnings of the log: rw with PDOMapping=1 doesn't say whether an RPDO or a TPDO carries it."""
    case = checked(tmp_path, ("AccessType=rww", "AccessType=rw"))
    assert (case["verdict"], "no clear mapping direction" in str(case["reason"])) == ("warning", True)


def test_file_that_breaks_the_standard_fails(tmp_path: Path) -> None:
    assert checked(tmp_path, ("SubNumber=5", "SubNumber=4"))["verdict"] == "failed"


def test_whole_file_passes(tmp_path: Path) -> None:
    assert checked(tmp_path)["verdict"] == "passed"


def test_report_says_what_the_tool_says_of_acyclic_tpdos() -> None:
    (result,) = conformed("PDO 07").results
    assert result.verdict is Verdict.PASSED
    assert "CiA's tool (CTT 3.0.3.10) disagrees" in result.remarks[0]


class EventIsOver(Fault):
    """Sends EMCY 8210h with a register of 0 and has 1001h at 0, like CANopenNode in the log."""

    def from_node(self, frame: CanFrame) -> Frames:
        if frame.identifier == EMCY:
            yield CanFrame(EMCY, frame.data[:2] + b"\x00" + frame.data[3:])
        elif self.request[:4] == b"\x40\x01\x10\x00":
            yield sdo(b"\x4f\x01\x10\x00\x00")
        else:
            yield frame


def test_error_register_of_an_event_that_is_over_may_be_zero(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(FAULTS, "EventIsOver", EventIsOver)
    assert numbers(conformed("5.5", fault="EventIsOver"), Verdict.PASSED) == ["5.5"]


class RestoresAtResetNode(Fault):
    """Restores the defaults of 1011h:02h only at a reset of the node, and ignores resets of communication."""

    def to_node(self, frame: CanFrame) -> Frames:
        if frame.identifier == 0 and frame.data[0] == 130:
            self.say_after(1, CanFrame(0x705, b"\x00"))
        else:
            yield frame


def test_defaults_that_come_back_with_a_reset_of_the_node_are_a_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(FAULTS, "RestoresAtResetNode", RestoresAtResetNode)
    (result,) = conformed("8.8", fault="RestoresAtResetNode").results
    assert result.verdict is Verdict.WARNING
    assert "by a reset of the node" in result.reason
