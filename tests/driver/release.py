"""Begins a release: `python -m tests.driver.release 0.2.0` gives it its version and its section of CHANGELOG.md.

Source: keepachangelog.com 1.1.0 for the form of the file, semver.org 2.0.0 for versions.  What is not a release of this
form is refused, and nothing is written then.
"""

import re
import sys
from collections.abc import Iterator, Sequence
from datetime import UTC, date, datetime
from pathlib import Path
from typing import Final, NamedTuple

CHANGELOG: Final = Path("CHANGELOG.md")
PROJECT: Final = Path("pyproject.toml")
UNRELEASED: Final = "## [Unreleased]"
RELEASED = re.compile(r"^## \[(?P<version>[^]]+)\] - (?P<day>.+)$", re.MULTILINE)
VERSION = re.compile(r"(?:0|[1-9]\d*)\.(?:0|[1-9]\d*)\.(?:0|[1-9]\d*)")
OF_PROJECT = re.compile(r'^version = "(?P<version>[^"]+)"$', re.MULTILINE)


class Section(NamedTuple):
    """A version that was released, and its day as the file has it."""

    version: str
    day: str


class ReleaseError(Exception):
    """No release can be made; the text says why."""


def sections(changelog: str) -> Iterator[Section]:
    """Yield the released versions of a changelog in its order, which is the latest first."""
    yield from (Section(found["version"], found["day"]) for found in RELEASED.finditer(changelog))


def released(changelog: str, version: str, day: date) -> str:
    """Return a changelog whose unreleased changes are those of a version.  ReleaseError if it may not be one."""
    if not VERSION.fullmatch(version):
        raise ReleaseError(f'"{version}" is no version; expected three numbers, such as 0.2.0')
    last = next(sections(changelog), None)
    if last is not None and numbers(version) <= numbers(last.version):
        raise ReleaseError(f"{version} does not come after {last.version}, which was released on {last.day}")
    before, mark, after = changelog.partition(f"{UNRELEASED}\n")
    if not mark:
        raise ReleaseError(f"{CHANGELOG} has no section {UNRELEASED}")
    if not RELEASED.split(after)[0].strip():
        raise ReleaseError(f"nothing has changed: {UNRELEASED} is empty")
    return f"{before}{mark}\n## [{version}] - {day.isoformat()}\n{after}"


def of_version(project: str, version: str) -> str:
    """Return a pyproject.toml with this version.  ReleaseError if it has a higher one, or none."""
    present = OF_PROJECT.search(project)
    if present is None:
        raise ReleaseError(f"{PROJECT} has no version")
    if numbers(version) < numbers(present["version"]):
        raise ReleaseError(f"{version} is lower than {present['version']}, which {PROJECT} has")
    return f'{project[: present.start()]}version = "{version}"{project[present.end() :]}'


def numbers(version: str) -> tuple[int, ...]:
    return tuple(map(int, version.split(".")))


def main(arguments: Sequence[str]) -> int:
    if len(arguments) != 1:
        sys.stderr.write("usage: python -m tests.driver.release VERSION\n")
        return 2
    try:
        changelog = released(CHANGELOG.read_text(encoding="utf-8"), arguments[0], datetime.now(UTC).date())
        project = of_version(PROJECT.read_text(encoding="utf-8"), arguments[0])
    except ReleaseError as wrong:
        sys.stderr.write(f"{wrong}\n")
        return 1
    CHANGELOG.write_text(changelog, encoding="utf-8")
    PROJECT.write_text(project, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
