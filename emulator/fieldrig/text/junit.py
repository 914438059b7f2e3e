"""Reports for CI in JUnit's form: all tests counted, everything escaped, with files and lines.

No standard defines it; the elements and attributes are those that the readers of Jenkins, GitLab and GitHub know.
"""

import re
from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple
from xml.etree import ElementTree as Xml

_NO_XML: Final = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML 1.0 cannot have, not even escaped."""


class Failed(NamedTuple):
    """Why a test did not pass."""

    message: str
    text: str = ""
    """Further lines."""
    kind: str = ""
    is_error: bool = False
    """True if the test could not be judged."""


class Case(NamedTuple):
    """One test."""

    name: str
    seconds: float = 0.0
    failures: Sequence[Failed] = ()
    skipped: str | None = None
    """Why it did not run; None if it did."""
    file: str = ""
    line: int = 0
    assertions: int | None = None
    output: str = ""
    classname: str = ""
    """The name under which readers group it; that of its suite if it is empty."""


def junit(name: str, suites: Mapping[str, Sequence[Case]]) -> bytes:
    """Return the report of all suites, by their names."""
    every = [case for cases in suites.values() for case in cases]
    root = Xml.Element("testsuites", {"name": _clean(name)} | _counts(every))
    for suite, cases in suites.items():
        node = Xml.SubElement(root, "testsuite", {"name": _clean(suite)} | _counts(cases))
        for case in cases:
            _add(node, suite, case)
    Xml.indent(root)
    return bytes(Xml.tostring(root, encoding="utf-8", xml_declaration=True)) + b"\n"


def _counts(cases: Sequence[Case]) -> dict[str, str]:
    errors = sum(any(one.is_error for one in case.failures) for case in cases)
    counts = {
        "tests": str(len(cases)),
        "failures": str(sum(bool(case.failures) for case in cases) - errors),
        "errors": str(errors),
        "skipped": str(sum(case.skipped is not None for case in cases)),
        "time": f"{sum(case.seconds for case in cases):.6f}",
    }
    assertions = [case.assertions for case in cases if case.assertions is not None]
    return counts | ({"assertions": str(sum(assertions))} if assertions else {})


def _add(suite: Xml.Element, name: str, case: Case) -> None:
    facts = {"name": case.name, "classname": case.classname or name, "time": f"{case.seconds:.6f}"}
    facts |= {"file": case.file, "line": str(case.line)} if case.file else {}
    facts |= {} if case.assertions is None else {"assertions": str(case.assertions)}
    node = Xml.SubElement(suite, "testcase", {key: _clean(value) for key, value in facts.items()})
    if case.skipped is not None:
        Xml.SubElement(node, "skipped", message=_clean(case.skipped))
    for one in case.failures:
        kind = {"type": _clean(one.kind)} if one.kind else {}
        inner = Xml.SubElement(node, "error" if one.is_error else "failure", {"message": _clean(one.message)} | kind)
        inner.text = _clean(one.text) or None
    if case.output:
        Xml.SubElement(node, "system-out").text = _clean(case.output)


def _clean(text: str) -> str:
    return _NO_XML.sub("\ufffd", text)
