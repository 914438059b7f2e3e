"""The report for CI: JUnit's XML, with all tests counted, everything escaped, and files and lines.

No standard defines it; the attributes are those that Jenkins, GitLab and GitHub's readers know.
"""

import re
from collections.abc import Sequence
from itertools import groupby
from typing import Final
from xml.etree import ElementTree as Xml

from fieldrig_devices.iec.testing.case import Outcome, Verdict
from fieldrig_devices.iec.testing.reports.people import place, said, source_line

_NO_XML: Final = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML 1.0 cannot have, not even escaped."""


def junit(outcomes: Sequence[Outcome]) -> bytes:
    """Return the report of all tests."""
    root = Xml.Element("testsuites", {"name": "fieldrig"} | _counts(outcomes))
    ordered = sorted(outcomes, key=lambda outcome: outcome.case.suite)
    for suite, group in groupby(ordered, key=lambda outcome: outcome.case.suite):
        inside = list(group)
        node = Xml.SubElement(root, "testsuite", name=_clean(suite), file=_clean(str(inside[0].case.file)))
        node.attrib |= _counts(inside)
        for outcome in inside:
            _case(node, outcome)
    Xml.indent(root)
    return bytes(Xml.tostring(root, encoding="utf-8", xml_declaration=True)) + b"\n"


def _counts(outcomes: Sequence[Outcome]) -> dict[str, str]:
    verdicts = [outcome.verdict for outcome in outcomes]
    return {
        "tests": str(len(outcomes)),
        "failures": str(verdicts.count(Verdict.FAILED)),
        "errors": str(verdicts.count(Verdict.ERROR)),
        "skipped": str(verdicts.count(Verdict.SKIPPED)),
        "assertions": str(sum(outcome.asserts for outcome in outcomes)),
        "time": f"{sum(outcome.wall_s for outcome in outcomes):.6f}",
    }


def _case(suite: Xml.Element, outcome: Outcome) -> None:
    case = outcome.case
    node = Xml.SubElement(
        suite,
        "testcase",
        name=_clean(case.name),
        classname=_clean(case.suite),
        file=_clean(str(case.file)),
        line=str(case.line),
        assertions=str(outcome.asserts),
        time=f"{outcome.wall_s:.6f}",
    )
    if outcome.verdict is Verdict.SKIPPED:
        Xml.SubElement(node, "skipped", message=_clean(outcome.reason))
    for failure in outcome.failures:
        tag = "failure" if outcome.verdict is Verdict.FAILED else "error"
        inner = Xml.SubElement(node, tag, message=_clean(said(failure)), type=failure.kind)
        lines = [place(failure), source_line(failure.file, failure.line), said(failure), *failure.diagram]
        inner.text = _clean("\n".join(line for line in lines if line))
    if outcome.output:
        Xml.SubElement(node, "system-out").text = _clean("\n".join(outcome.output))


def _clean(text: str) -> str:
    return _NO_XML.sub("\ufffd", text)
