"""Reports as files: JUnit for build servers, HTML and Markdown for people.

The JUnit file is for Jenkins and GitLab: a suite per family, with the failure, the reason for skipping, and the frames
of each case.
"""

from xml.etree import ElementTree as Xml

from fieldrig.points.values import counted
from fieldrig.text.junit import Case, Failed, junit
from fieldrig_devices.conformance.report import Report, seconds, shown_frames
from fieldrig_devices.conformance.suite import Result, Verdict

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 70rem; margin: 2rem auto; padding: 0 1rem; color: #222 }
table { border-collapse: collapse; width: 100% } th, td { text-align: left; padding: .3rem .6rem; vertical-align: top }
tr { border-bottom: 1px solid #ddd } pre { font-size: 12px; background: #f6f6f6; padding: .5rem; overflow-x: auto }
.passed { color: #186a3b } .warning { color: #9a6700 }
.failed { color: #b03a2e; font-weight: 600 } .not-applicable { color: #777 }
small { color: #777 } summary { cursor: pointer; color: #555 }
"""


def to_junit(report: Report) -> str:
    suites = {
        family: [_junit_case(report, result) for result in report.results if result.case.family == family]
        for family in report.families
    }
    return junit(f"CANopen conformance of node {report.node_id}", suites).decode()


def _junit_case(report: Report, result: Result) -> Case:
    case, failures, skipped = result.case, list[Failed](), None
    if result.verdict is Verdict.FAILED:
        text = f"{case.requirement}\n{case.clause}\nexpected {result.expected}\ncame {result.came}"
        failures = [Failed(result.reason, text)]
    elif result.verdict is Verdict.NOT_APPLICABLE:
        skipped = result.reason
    lines = [case.requirement, case.clause, result.reason, *shown_frames(result), *result.notes, *result.remarks]
    group = f"canopen.node{report.node_id}.{case.family.replace(' ', '_')}"
    name = f"{case.number} {case.name}"
    return Case(name, seconds(result), failures, skipped, output="\n".join(lines), classname=group)


def to_html(report: Report) -> str:
    root = Xml.Element("html", lang="en")
    head, body = Xml.SubElement(root, "head"), Xml.SubElement(root, "body")
    Xml.SubElement(head, "meta", charset="utf-8")
    _text(head, "title", f"CANopen conformance of node {report.node_id}")
    _text(head, "style", STYLE)
    _text(body, "h1", f"CANopen conformance of node {report.node_id}")
    _text(body, "p", f"{report.summary}.")
    _text(body, "p", f"{report.eds} on {report.bus}; {report.date}, fieldrig {report.version}.")
    for note in report.notes:
        _text(body, "p", note)
    table = Xml.SubElement(body, "table")
    heading = Xml.SubElement(table, "tr")
    for title in ("case", "requirement", "verdict"):
        _text(heading, "th", title)
    for result in report.results:
        _html_row(table, result)
    return "<!doctype html>\n" + Xml.tostring(root, encoding="unicode", method="html") + "\n"


def _html_row(table: Xml.Element, result: Result) -> None:
    row = Xml.SubElement(table, "tr")
    _text(row, "td", f"{result.case.number} {result.case.name}")
    about = Xml.SubElement(row, "td")
    _text(about, "div", result.case.requirement)
    _text(about, "small", result.case.clause)
    verdict = Xml.SubElement(row, "td")
    _text(verdict, "span", result.verdict.value, {"class": result.verdict.value.replace(" ", "-")})
    for line in (result.reason, *result.notes, *result.remarks):
        if line:
            _text(verdict, "div", line)
    if result.frames:
        details = Xml.SubElement(about, "details")
        _text(details, "summary", f"{counted(len(result.frames), 'frame')} in {seconds(result):.3f} s")
        _text(details, "pre", "\n".join(shown_frames(result)))


def _text(parent: Xml.Element, tag: str, text: str, attributes: dict[str, str] | None = None) -> None:
    Xml.SubElement(parent, tag, attributes or {}).text = text


def to_markdown(report: Report) -> str:
    lines = [
        f"# CANopen conformance of node {report.node_id}",
        "",
        f"{report.summary}.  `{report.eds}` on {report.bus}; {report.date}, fieldrig {report.version}.",
        "",
        *(f"- {note}" for note in report.notes),
        "",
        f"| family | cases | {' | '.join(verdict.value for verdict in Verdict)} |",
        f"|---|---|{'---|' * len(Verdict)}",
        *(_family_row(report, family) for family in report.families),
        _family_row(report, None),
        "",
        "| case | | verdict | |",
        "|---|---|---|---|",
        *(_markdown_row(result) for result in report.results),
    ]
    for result in report.of(Verdict.FAILED):
        lines += _markdown_failure(result)
    return "\n".join(lines) + "\n"


def _family_row(report: Report, family: str | None) -> str:
    total = sum(1 for result in report.results if family in (None, result.case.family))
    counts = (total, *(report.count(verdict, family) for verdict in Verdict))
    return f"| {family or '**all**'} | {' | '.join(map(str, counts))} |"


def _markdown_row(result: Result) -> str:
    case, reason = result.case, "; ".join(filter(None, (result.reason, *result.notes, *result.remarks)))
    verdict = f"**{result.verdict.value}**" if result.verdict is Verdict.FAILED else result.verdict.value
    cells = (f"{case.number} {case.name}", f"{case.requirement} ({case.clause})", verdict, reason)
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


def _markdown_failure(result: Result) -> list[str]:
    case = result.case
    frames = ["```", *shown_frames(result), "```"] if result.frames else []
    return [
        "",
        f"## {case.number} {case.name} failed",
        "",
        f"{case.requirement}  {case.clause}",
        "",
        f"- expected: {result.expected}",
        f"- came: {result.came}",
        "",
        *frames,
    ]
