"""Findings as scenario files, which repeat them bit for bit, and as a test in pytest."""

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from fieldrig.clock import MS
from fieldrig.faults.words import words_of_fault
from fieldrig.system.whole_file import replace_file
from fieldrig.virtual.readings import seconds
from fieldrig_devices.scenarios.act import Act
from fieldrig_devices.scenarios.property import Kind, Property
from fieldrig_devices.scenarios.report import Outcome
from fieldrig_devices.scenarios.scenario_file import Scenario
from fieldrig_devices.search.corpus import Finding
from fieldrig_devices.search.plan import in_world

_CONDITIONS: Final = {
    Kind.ALWAYS: "always",
    Kind.NEVER: "never",
    Kind.WITHIN: "expect",
    Kind.STAYS: "stays",
    Kind.EVENTUALLY: "eventually",
}
TEST: Final = '''"""Findings of `fieldrig search`: each fails until the program is fixed."""

from pathlib import Path

import pytest

from fieldrig_devices.scenarios import run_scenario

FILES = sorted(Path(__file__).parent.glob("finding-*.yaml"))


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_the_property_holds(file):
    run_scenario(file)
'''


def write(scenario: Scenario, findings: Sequence[Finding], folder: Path) -> list[Path]:
    """Write a scenario for each finding, a picture of it, and a test for all of them; return the scenarios."""
    from fieldrig_devices.scenarios.running import played

    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for finding in findings:
        file = folder / f"finding-{finding.number}.yaml"
        replace_file(file, scenario_text(scenario, finding, folder).encode())
        outcome = played(file)
        replace_file(file.with_suffix(".svg"), _drawn(finding, outcome).encode())
        files.append(file)
    replace_file(folder / "test_findings.py", TEST.encode())
    return files


def _drawn(finding: Finding, outcome: Outcome) -> str:
    """Return the picture around the violation; of the whole scenario for a property of every rig."""
    from fieldrig_devices.scenarios.picture import picture, picture_of

    played, scenario = outcome.played, outcome.scenario
    rule = next((one for one in scenario.properties if one.name == finding.property), None)
    violation = next((one for one in played.violations if one.property == finding.property), None)
    if rule is None or violation is None:
        return picture(finding.property, played, scenario.schedule)
    return picture_of(played, rule, violation)


def scenario_text(scenario: Scenario, finding: Finding, folder: Path) -> str:
    """Return a scenario file, for a folder, with the one property that does not hold; all for one of every rig."""
    scenario = in_world(scenario, finding.world)
    rules = [one for one in scenario.properties if one.name == finding.property] or scenario.properties
    steps = (act for act in scenario.schedule if act.when or act.at_ns <= finding.length_ns)
    acts = sorted((*steps, *finding.acts), key=lambda act: act.at_ns)
    overrides = list(scenario.overrides)
    lines = [
        _comment(f"{finding.property}: at {seconds(finding.at_ns)} {finding.what}"),
        *(_comment(f"  {line}") for line in finding.reason[1:]),
        *([f"# messages and their hash: {finding.hash}"] if finding.hash else []),
        f"rig: {_quoted(_relative(scenario.rig, folder))}",
        *([f"overrides: {json.dumps(overrides)}"] if overrides else []),
        *([f"master: {_quoted(_relative(scenario.master, folder))}"] if scenario.master is not None else []),
        *([f"jitter: {_time(scenario.jitter_ns)}"] if scenario.jitter_ns else []),
        f"after: {_time(scenario.after_ns)}",
        f"for: {_time(finding.length_ns)}",
        "forgives: true",
        "steps:" if acts else "steps: []",
        *(f"  - {_step(act)}{'  # found' if act in finding.acts else ''}" for act in acts),
        *(["recover:"] if scenario.recovery else []),
        *(f"  - {_step(act)}" for act in scenario.recovery),
        "properties:",
        *(f"  {_quoted(rule.name)}: {_flow(_rule(rule))}" for rule in rules),
    ]
    return "\n".join(lines) + "\n"


def _relative(file: Path, folder: Path) -> str:
    """Return a path from a folder to a file, with / between its parts."""
    return Path(os.path.relpath(file.resolve(), folder.resolve())).as_posix()


def _step(act: Act) -> str:
    body: dict[str, Any] = {"at": _time(act.at_ns)} if act.at_ns or not act.when else {}
    body |= {"when": act.when} if act.when else {}
    body |= {"nth": act.nth} if act.nth > 1 else {}
    match act.verb:
        case "set":
            body["set"] = {act.where: act.value}
        case "press":
            body |= {"press": {act.where: act.value}, "hold": _time(act.hold_ns)}
        case "fault":
            assert isinstance(act.value, Mapping)
            body["fault"] = f"{act.where} {words_of_fault(act.value)}"
        case "send":
            body["send"] = {act.where: act.value}
        case _:
            body[act.verb] = act.where
    return _flow(body)


def _rule(rule: Property) -> dict[str, str]:
    body = {_CONDITIONS[rule.kind]: rule.condition.text}
    body |= {} if rule.after is None else {"after": rule.after.text}
    body |= {} if rule.until is None else {"until": rule.until.text}
    time = "longer" if rule.kind in (Kind.ALWAYS, Kind.NEVER) else "within"
    return body | ({} if rule.within_ns is None else {time: _time(rule.within_ns)})


def _flow(value: object) -> str:
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_quoted(str(key))}: {_flow(one)}" for key, one in value.items()) + "}"
    return _quoted(value) if isinstance(value, str) else json.dumps(value)


def _quoted(text: str) -> str:
    """Return a text as a scalar of YAML, which JSON's form is, except for signs that YAML has no halves of."""
    if text.isidentifier() and text.lower() not in ("true", "false", "null"):
        return text
    return "".join(_sign(sign) for sign in json.dumps(text, ensure_ascii=False))


def _sign(sign: str) -> str:
    return sign if sign.isprintable() else f"\\U{ord(sign):08x}"


def _comment(text: str) -> str:
    """Return a comment of one line."""
    return "# " + "".join(sign if sign.isprintable() else " " for sign in text)


def _time(ns: int) -> str:
    return f"{ns // MS}ms" if ns % MS == 0 else f"{ns}ns"
