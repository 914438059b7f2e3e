"""Names that no shipped rig has, in a browser: those of JavaScript, marks of HTML, a slash at the end, long ones."""

import json
from collections.abc import Iterator
from typing import Any

import pytest
from axe_playwright_python.sync_playwright import Axe
from browser_page import ServedRig, opened
from playwright.sync_api import Browser, expect

KEYS = (
    *("a b", "it's", 'say "hi"', "grün/ß€", "</script><script>document.title = 'taken'</script>", "<b>bold</b>"),
    *("__proto__", "constructor", "toString", "%41", "#a?b=1&c", "*", "tab\tin", "a,b", "trail/", "/lead", "x" * 300),
)
KIND = f"""
from fieldrig import Device, Point


class Odd(Device):
    def __init__(self) -> None:
        self.values = dict.fromkeys({KEYS!r}, 1.5)

    def points(self) -> dict[str, Point]:
        return {{key: Point(lambda key=key: self.values[key], lambda value, key=key: self.values.update({{key: value}}))
                for key in self.values}}
"""
LONG = "l" * 120
LOOKS = 30
"""Looks at a view while it fills: for a moment it has words of its own."""
RIG = {
    "time": "virtual",
    "speed": 1,
    "buses": {"wires": {"kind": "wires.virtual"}},
    "devices": {name: {"kind": "odd:Odd"} for name in ("constructor", "plain", LONG)},
}

pytestmark = pytest.mark.real


@pytest.fixture(scope="module")
def odd(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServedRig]:
    folder = tmp_path_factory.mktemp("odd")
    (folder / "odd.py").write_text(KIND)
    (folder / "rig.yaml").write_text(json.dumps(RIG))
    with ServedRig(folder / "rig.yaml") as rig:
        yield rig


@pytest.mark.parametrize(("width", "scheme"), [(1280, "light"), (390, "dark")])
def test_every_view_shows_such_names_within_its_width(
    browser: Browser, odd: ServedRig, width: int, scheme: Any
) -> None:
    with opened(browser, odd, width=width, scheme=scheme) as page:
        expect(page.locator("main article")).to_have_count(3)
        for path in (
            "/",
            "/device/constructor",
            "/values/constructor",
            f"/values/{LONG}",
            f"/device/{LONG}",
            "/faults/constructor",
            "/time",
        ):
            page.evaluate("path => { location.hash = `#${path}`; }", path)
            expect(page.locator("main section h2").first).to_be_visible()
            if path.startswith("/device"):
                expect(page.locator(".fact")).to_have_count(len(KEYS))
            widest = max(page.evaluate("document.documentElement.scrollWidth") for _ in range(LOOKS))
            assert widest <= width, path
            assert Axe().run(page).violations_count == 0, path
            expect(page).not_to_have_title("taken")


def test_such_values_are_found_and_written(browser: Browser, odd: ServedRig) -> None:
    with opened(browser, odd, path="/values/plain") as page:
        for number, key in enumerate(KEYS):
            page.get_by_label("find").fill(key)
            page.locator(".rows tbody").get_by_role("button").first.click()
            page.get_by_role("textbox", name="new value").fill(str(100 + number))
            page.get_by_role("button", name="Write").click()
            expect(page.get_by_role("dialog")).to_have_count(0)
        values = odd.ask("device/plain/get")
        assert [values[key] for key in KEYS] == [100 + number for number in range(len(KEYS))]


def test_such_signals_are_drawn(browser: Browser, odd: ServedRig) -> None:
    with opened(browser, odd, path="/scope") as page:
        for key in ("</script>", "__proto__", "a,b"):
            page.get_by_label("Search signals").fill(f"constructor/{key}")
            page.get_by_role("checkbox").first.check()
        rows = page.locator(".scope-values tbody tr")
        expect(rows).to_have_count(3)
        for row in rows.all():
            expect(row).to_contain_text("1.5")
