"""Reports for build servers and for people."""

from io import StringIO
from xml.etree import ElementTree as Xml

import pytest
from conform_bench import conformed
from rich.console import Console

from fieldrig_devices.conformance.report import Report, as_data, shown_frames
from fieldrig_devices.conformance.report_files import to_html, to_junit, to_markdown
from fieldrig_devices.conformance.terminal import show_report, show_result


@pytest.fixture(scope="module")
def report() -> Report:
    """A report in which one case passes, one fails, and one is not applicable."""
    return conformed("2.1", "2.30", "2.6", fault="WrongAbortCode")


def test_summary_counts(report: Report) -> None:
    assert report.summary == "3 cases: 1 passed, 1 failed, 1 not applicable"
    assert (report.executed, report.families) == (2, ["SDO"])


def test_frames_are_shown_with_time_and_direction(report: Report) -> None:
    assert shown_frames(report.results[0])[0] == "  0.000000 > 605#40 00 10 00 00 00 00 00"
    assert shown_frames(report.results[0])[1].endswith(" < 585#43 00 10 00 91 01 0F 00")


def test_long_cases_show_their_first_and_last_frames() -> None:
    long = conformed("4.3").results[0]
    lines = shown_frames(long, 10)
    assert len(lines) == 11
    assert lines[5] == f"... {len(long.frames) - 10} more frames ..."


def test_junit_has_failure_reason_and_frames(report: Report) -> None:
    root = Xml.fromstring(to_junit(report))
    (suite,) = root
    assert {key: suite.attrib[key] for key in ("name", "tests", "failures", "skipped")} == {
        "name": "SDO", "tests": "3", "failures": "1", "skipped": "1",
    }  # fmt: skip
    passed, failed, skipped = suite
    assert (passed.attrib["name"], passed.attrib["classname"]) == ("2.1 SDO 01", "canopen.node5.SDO")
    failure, reason = failed.find("failure"), skipped.find("skipped")
    assert failure is not None
    assert reason is not None
    assert "expected reading 1004h:00h to be refused with 06020000h or 08000000h" in failure.attrib["message"]
    assert reason.attrib["message"] == "the EDS has no SDO client (1280h and following)"
    assert "605#40 04 10 00" in (failed.findtext("system-out") or "")


def test_html_is_whole_and_escapes(report: Report) -> None:
    text = to_html(report)
    assert text.startswith("<!doctype html>")
    assert 'class="failed"' in text
    assert "&gt; 605#40 04 10 00" in text
    assert "<script" not in text


def test_markdown_has_tables_and_what_failed(report: Report) -> None:
    lines = to_markdown(report).splitlines()
    assert "| SDO | 3 | 1 | 0 | 1 | 1 |" in lines
    assert "## 2.6 SDO 06 failed" in lines
    assert "- came: abort 0606 0000h (hardware error) for reading 1004h:00h" in lines


def test_json_has_everything(report: Report) -> None:
    data = as_data(report)
    assert (data["passed"], data["failed"], data["not_applicable"]) == (1, 1, 1)
    assert data["cases"][1]["clause"] == "CiA 301 7.2.4.3.17, table 22"
    assert data["cases"][1]["verdict"] == "failed"


def test_terminal_shows_each_case_what_failed_and_the_sums(report: Report) -> None:
    out = Console(file=StringIO(), width=200, highlight=False, markup=False)
    for result in report.results:
        show_result(out, result)
    show_report(out, report)
    assert isinstance(out.file, StringIO)
    text = out.file.getvalue()
    assert "   2.1 SDO 01" in text
    assert "came      abort 0606 0000h (hardware error) for reading 1004h:00h" in text
    assert "node 5: 3 cases: 1 passed, 1 failed, 1 not applicable" in text
