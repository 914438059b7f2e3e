"""The result of `fieldrig replay` for people and for build servers."""

from xml.etree import ElementTree as Xml

import typer

from fieldrig.clock import S
from fieldrig_devices.replay.replay_result import MOST_KEPT, Difference, ReplayResult
from fieldrig_devices.replay.words import time_words

MOST_SHOWN = 200


def show(result: ReplayResult) -> None:
    """Print the differences, the notes, and a summary."""
    for each in result.differences[:MOST_SHOWN]:
        typer.echo(str(each))
    if result.count > MOST_SHOWN:
        typer.echo(f"and {result.count - MOST_SHOWN} more; --json and --junit have up to {MOST_KEPT}")
    for note in result.notes:
        typer.echo(f"note: {note}")
    shift = f"; the rig answered {time_words(result.shift_ns)} later in all" if result.shift_ns else ""
    typer.echo(f"{result.summary} in {result.duration_ns / S:.3f} s{shift}")


def to_junit(result: ReplayResult, log: str, rig: str) -> str:
    """Return a JUnit report: a case for each object, PDO or register of each node, with its differences."""
    cases: dict[tuple[str, str, str], list[Difference]] = {key: [] for key in result.by_subject}
    for each in result.differences:
        cases.setdefault(_case_of(each, cases), []).append(each)
    failed = sum(bool(differences) for differences in cases.values())
    counts = {"tests": str(len(cases)), "failures": str(failed), "errors": "0", "skipped": "0"}
    seconds = f"{result.duration_ns / S:.3f}"
    root = Xml.Element("testsuites", {"name": f"{log} played to {rig}", **counts, "time": seconds})
    suite = Xml.SubElement(root, "testsuite", {"name": log, **counts, "time": seconds})
    for (bus, node, subject), differences in cases.items():
        name = f"{node} {subject}".strip()
        case = Xml.SubElement(suite, "testcase", {"classname": f"replay.{bus}", "name": name, "time": "0"})
        if differences:
            failure = Xml.SubElement(case, "failure", message=_legal(str(differences[0])))
            failure.text = _legal("\n".join(map(str, differences)))
    if result.notes:
        Xml.SubElement(suite, "system-out").text = _legal("\n".join(result.notes))
    Xml.indent(root)
    return Xml.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def _case_of(each: Difference, cases: dict[tuple[str, str, str], list[Difference]]) -> tuple[str, str, str]:
    """Return the case that a difference belongs to: that of its object, or else one of its own."""
    exact = (each.bus, each.node, each.subject)
    if exact in cases:
        return exact
    return next((key for key in cases if key[:2] == exact[:2] and key[2] in each.words), exact)


def _legal(text: str) -> str:
    """Return a text without the characters that XML 1.0 cannot have."""
    return "".join(letter if letter.isprintable() or letter == "\n" else "\N{REPLACEMENT CHARACTER}" for letter in text)
