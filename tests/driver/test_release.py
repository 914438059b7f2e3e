"""A release has its section in CHANGELOG.md by the rules that the file names; what cannot be one is refused."""

import re
from datetime import date
from pathlib import Path

import pytest
from tests.driver.release import (
    CHANGELOG,
    OF_PROJECT,
    PROJECT,
    UNRELEASED,
    VERSION,
    ReleaseError,
    numbers,
    of_version,
    released,
    sections,
)

ROOT = Path(__file__).parents[2]
DAY = date(2026, 12, 1)
GROUPS = ("Added", "Changed", "Deprecated", "Removed", "Fixed", "Security")
"""All groups of changes that keepachangelog.com has."""
BEFORE = """# Changelog

Rules.

## [Unreleased]

### Added

- A thing.

## [0.1.0] - 2026-11-29

### Fixed

- Another.
"""


def test_a_release_takes_the_unreleased_changes() -> None:
    assert released(BEFORE, "0.2.0", DAY) == BEFORE.replace("### Added", "## [0.2.0] - 2026-12-01\n\n### Added")


def test_the_first_release_takes_all() -> None:
    first = BEFORE.partition("## [0.1.0]")[0]
    assert released(first, "0.1.0", DAY) == first.replace("### Added", "## [0.1.0] - 2026-12-01\n\n### Added")


@pytest.mark.parametrize(
    ("changelog", "version", "reason"),
    [
        (BEFORE, "0.1.0", "0.1.0 does not come after 0.1.0, which was released on 2026-11-29"),
        (BEFORE, "0.0.9", "0.0.9 does not come after 0.1.0"),
        (BEFORE.replace("0.1.0", "0.10.0"), "0.9.0", "0.9.0 does not come after 0.10.0"),
        (BEFORE, "1", '"1" is no version'),
        (BEFORE, "v0.2.0", '"v0.2.0" is no version'),
        (BEFORE, "0.02.0", '"0.02.0" is no version'),
        (BEFORE.replace(UNRELEASED, "## Unreleased"), "0.2.0", "has no section"),
        (BEFORE.replace("### Added\n\n- A thing.\n\n", ""), "0.2.0", "nothing has changed"),
    ],
)
def test_what_is_no_release_is_refused(changelog: str, version: str, reason: str) -> None:
    with pytest.raises(ReleaseError, match=re.escape(reason)):
        released(changelog, version, DAY)


def test_the_version_of_the_project_rises_and_the_rest_stays() -> None:
    project = '[project]\nname = "x"\nversion = "0.1.0"\n\n[tool.other]\nversion = "7"\n'
    assert of_version(project, "0.2.0") == project.replace("0.1.0", "0.2.0")
    assert of_version(project, "0.1.0") == project
    with pytest.raises(ReleaseError, match=re.escape("0.0.9 is lower than 0.1.0")):
        of_version(project, "0.0.9")
    with pytest.raises(ReleaseError, match="no version"):
        of_version("[project]\n", "0.2.0")


def test_the_changelog_keeps_its_rules() -> None:
    """Unreleased changes first, then versions, the latest first, each with its day; each group once in a section."""
    text = (ROOT / CHANGELOG).read_text(encoding="utf-8")
    titles = re.findall(r"^## .*$", text, re.MULTILINE)
    found = [*sections(text)]
    assert titles == [UNRELEASED, *(f"## [{version}] - {date.fromisoformat(day)}" for version, day in found)]
    assert all(VERSION.fullmatch(version) for version, _ in found)
    assert [numbers(version) for version, _ in found] == sorted({numbers(of.version) for of in found}, reverse=True)
    for part in re.split(r"^## .*$", text, flags=re.MULTILINE)[1:]:
        groups = re.findall(r"^### (.*)$", part, re.MULTILINE)
        assert len(groups) == len({*groups} & {*GROUPS}), groups


def test_the_latest_release_is_the_version_of_the_project() -> None:
    version = OF_PROJECT.search((ROOT / PROJECT).read_text(encoding="utf-8"))
    assert version is not None
    latest = next(sections((ROOT / CHANGELOG).read_text(encoding="utf-8")), None)
    assert latest is None or latest.version == version["version"]
