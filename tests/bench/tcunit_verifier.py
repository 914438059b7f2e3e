"""Judge our TcUnit by its own verifier, from a copy of TcUnit's repository.

    python -m tests.bench.tcunit_verifier FOLDER

The expectations are in the C# files of the verifier: lines that the report must have, must not have, or has a number of
times, compared in upper case.  Suites that test TcUnit's own internals are left out.  The exit code is 1 if anything
differs.
"""

import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Final, NamedTuple

from fieldrig.system.stopwatch import Stopwatch
from fieldrig_devices.iec.tcunit import report
from fieldrig_devices.iec.tcunit.bench import Bench
from fieldrig_devices.iec.tcunit.project import opened

INTERNALS: Final = frozenset(
    {
        "AnyToUnionValue", "TestFileControl", "TestXmlControl", "TestStreamBuffer", "TestDurationMeasurement",
        "AdjustAssertFailureMessageToMax253CharLengthTest", "AssertCountExceedsMaxNumber",
    }
)  # fmt: skip
"""Suites that test what is within TcUnit, or the time of the processor."""
TESTS, FAILURES = 215, 118
"""The tests that the other suites declare, and how many of their tests must fail."""
TEXT: Final = r'"((?:[^"\\]|\\.)*)"'
STATEMENT: Final = re.compile(
    rf"(?:string\s+)?(?P<name>\w+)\s*=\s*(?P<make>CreateFailedTestMessage\w*)\((?P<parts>[^;]*)\);"
    rf"|(?:string\s+)?(?P<plain>\w+)\s*=\s*{TEXT};"
    rf"|\w+\[\]\s+(?P<list>\w+)\s*=\s*new\s+\w+\[\]\s*\{{(?P<members>[^}}]*)\}};"
    rf"|(?P<check>Assert\w*Message\w*|AssertDoesNotContainMessage)\((?P<arguments>[^;]*)\);"
)


class Check(NamedTuple):
    """Any of these texts occurs at least `least` and at most `most` times in the report."""

    texts: tuple[str, ...]
    least: int
    most: int
    is_error: bool
    """True if only lines count that are errors, and not those of the summary."""


def checks_of(suite: str, text: str) -> Iterator[Check]:
    """Yield what the verifier expects of a suite."""
    known: dict[str, tuple[str, ...]] = {}
    for found in STATEMENT.finditer(text):
        if found["make"]:
            parts = [part.replace('\\"', '"') for part in re.findall(TEXT, found["parts"])]
            known[found["name"]] = (_line(suite, parts),)
        elif found["plain"]:
            known[found["plain"]] = (re.findall(TEXT, found[0])[0],)
        elif found["list"]:
            known[found["list"]] = tuple(text for name in re.findall(r"\w+", found["members"]) for text in known[name])
        else:
            yield from _check(suite, found["check"], found["arguments"], known)


def _line(suite: str, parts: list[str]) -> str:
    test, expected, actual, *message = parts
    front = f"FAILED TEST 'PRG_TEST.{suite}@{test}', EXP: {expected}, ACT: {actual}"
    return f"{front}, MSG: {message[0]}" if message else front


def _check(suite: str, check: str, arguments: str, known: dict[str, tuple[str, ...]]) -> Iterator[Check]:
    parts = [part.strip() for part in arguments.split(", EnvDTE80")[0].split(",")]
    literals = re.findall(TEXT, arguments)
    texts = known.get(parts[0]) or ((literals[0],) if literals else ())
    if not texts:
        return
    is_error = "LevelHigh" in arguments
    if check == "AssertDoesNotContainMessage":
        front = f"FAILED TEST 'PRG_TEST.{suite}@{literals[0]}'" if len(literals) == 2 else ""
        yield Check(tuple(f"{front}\0{text}" for text in literals[1:]) if front else texts, 0, 0, is_error)
    elif "Count" in check:
        (number,) = re.findall(r",\s*(\d+)\s*(?:,|$)", arguments)
        yield Check(texts, int(number), int(number), is_error)
    else:
        yield Check(texts, 1, 1_000_000, is_error)


NUMBER: Final = r"[+-]?(?:\d+(?:\.\d*)?(?:E[+-]?\d+)?|\.\d+(?:E[+-]?\d+)?)"
"""The text that %f stands for."""


def _count(lines: list[str], text: str) -> int:
    patterns = [re.escape(part).replace("%F", NUMBER) for part in text.upper().split("\0")]
    return sum(all(re.search(pattern, line) for pattern in patterns) for line in lines)


def main(folder: Path) -> int:
    watch = Stopwatch()
    projects = list(folder.rglob("TcUnitVerifier.plcproj"))
    if len(projects) != 1:
        sys.exit(
            f"error: {folder} has no TcUnitVerifier.plcproj\n  expected TCUNIT=FOLDER, a copy of TcUnit's repository"
        )
    (project,) = projects
    bench = Bench(opened(project))
    bench.run()
    seconds = watch.seconds
    errors = [line.upper() for line in bench.session.lines]
    lines = [*errors, *(line.upper() for line in report.summary(bench.session))]
    judged = [one for one in bench.session.suites.values() if one.path.partition(".")[2] not in INTERNALS]
    wrong, number = 0, 0
    for suite in judged:
        name = suite.path.partition(".")[2]
        for file in folder.rglob(f"FB_{name}.cs"):
            for check in checks_of(name, file.read_text(encoding="utf-8-sig")):
                number += 1
                count = sum(_count(errors if check.is_error else lines, text) for text in check.texts)
                if not check.least <= count <= check.most:
                    wrong += 1
                    print(f"{name}: {count} times instead of {check.least}: {check.texts}")
    tests = [test for suite in judged for test in suite.tests.values()]
    failed = sum(test.has_failed for test in tests)
    print(f"{len(judged)} suites, {len(tests)} tests, {failed} failed; {number} checks, {wrong} wrong; {seconds:.1f} s")
    return int(wrong > 0 or (len(tests), failed) != (TESTS, FAILURES))


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
