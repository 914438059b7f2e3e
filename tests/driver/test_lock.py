"""The lock files are of today's pyproject.toml, and what is installed from them is listed with its licence."""

import re
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from tests.driver.lock import ALL, LICENCES, RUN, VENDORED, packages, vendored

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
DECLARED = {RUN: PROJECT["dependencies"], ALL: PROJECT["dependencies"] + PROJECT["optional-dependencies"]["dev"]}
STARTS_A_PACKAGE = re.compile(r"^(?=\w)", re.MULTILINE)


@pytest.mark.parametrize("lock", [RUN, ALL], ids=str)
def test_a_lock_file_has_what_is_declared(lock: Path) -> None:
    locked = packages(ROOT / lock)
    for text in DECLARED[lock]:
        requirement = Requirement(text)
        assert locked[canonicalize_name(requirement.name)] in requirement.specifier, f"{text}: run make lock"


@pytest.mark.parametrize("lock", [RUN, ALL], ids=str)
def test_each_locked_package_has_hashes(lock: Path) -> None:
    entries = STARTS_A_PACKAGE.split((ROOT / lock).read_text(encoding="utf-8"))
    assert [entry for entry in entries if entry and "--hash=sha256:" not in entry] == []


def test_tests_run_with_the_packages_of_the_image() -> None:
    assert packages(ROOT / RUN).items() <= packages(ROOT / ALL).items()


def test_each_package_of_the_image_is_listed_with_its_licence() -> None:
    rows = re.findall(
        r"^\| ([\w.-]+) \| (\S+) \| (.+?) \|", (ROOT / LICENCES).read_text(encoding="utf-8"), re.MULTILINE
    )
    licences = {name: licence for name, version, licence in rows if packages(ROOT / RUN).get(name) == version}
    only_elsewhere = {"colorama"}  # Windows
    assert packages(ROOT / RUN).keys() - licences.keys() <= only_elsewhere
    assert "Lesser General Public License" in licences["asyncua"]
    assert "LGPL" in licences["python-can"]


def test_the_base_of_the_image_is_named_by_its_digest() -> None:
    text = (ROOT / "docker" / "Dockerfile").read_text(encoding="utf-8")
    assert re.search(r"^ARG FIELDRIG_BASE=\S+@sha256:[0-9a-f]{64}$", text, re.MULTILINE)
    assert set(re.findall(r"^FROM (\S+)", text, re.MULTILINE)) == {"${FIELDRIG_BASE}"}


def test_each_package_of_the_page_is_listed_with_its_licence() -> None:
    listed = (ROOT / LICENCES).read_text(encoding="utf-8").splitlines(keepends=True)
    assert [row for row in vendored(ROOT / VENDORED) if row not in listed] == []
