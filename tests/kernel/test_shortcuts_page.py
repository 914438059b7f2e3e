"""docs/developers/architecture.md lists every place that leaves out work, with its test."""

import re

from doc_pages import ROOT, page_named

PACKAGES = ("emulator/fieldrig", "bus/fieldrig_bus", "devices/fieldrig_devices")
PAGE = page_named("architecture.md").read_text(encoding="utf-8")
ROWS = dict(re.findall(r"^\| `([a-z0-9_.]+)` \|.*\| `([a-z0-9_/]+\.py)` \|$", PAGE, re.MULTILINE))


def test_the_page_lists_all_shortcuts_of_the_code() -> None:
    sources = (file.read_text(encoding="utf-8") for package in PACKAGES for file in (ROOT / package).rglob("*.py"))
    found = [name for source in sources for name in re.findall(r"= Shortcut\(\s*\"([^\"]+)\"", source)]
    assert sorted(ROWS) == sorted(found)


def test_each_shortcut_has_a_test_that_takes_the_plain_form() -> None:
    for test in set(ROWS.values()):
        assert "plain_forms(" in (ROOT / "tests" / test).read_text(encoding="utf-8")
