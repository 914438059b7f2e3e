"""The time line of a finding in a browser: what happened, where a property does not hold, and the way back."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

import pytest
from axe_playwright_python.sync_playwright import Axe
from browser_page import ServedRig, opened
from playwright.sync_api import Browser, expect
from st_tests import LAMP_RIG, STUCK_LAMP

pytestmark = pytest.mark.real

FINDING = """\
rig: rig.yaml
after: 500ms
steps:
  - {at: 100ms, press: {wires/switch.on: true}, hold: 30ms}
  - {at: 300ms, press: {wires/switch.on: true}, hold: 30ms}
  - {at: 400ms, fault: wires stuck wire=lamp.on value=true duration_ms=20}
  - {at: 500ms, press: {wires/switch.on: true}, hold: 30ms}
properties:
  the lamp goes out: {never: wires/lamp.on and not wires/switch.on, longer: 50ms}
"""
SCHEMES: tuple[Literal["light", "dark"], ...] = ("light", "dark")


class OpenedFinding(ServedRig):
    """The rig of a finding, which `fieldrig scenario open` keeps."""

    def start_up(self, file: Path, *options: str, folder: Path | None = None) -> "subprocess.Popen[bytes]":
        (self.folder / "rig.yaml").write_text(LAMP_RIG)
        (self.folder / "lamp.st").write_text(STUCK_LAMP)
        (self.folder / "finding-1.yaml").write_text(FINDING)
        command = [sys.executable, "-m", "fieldrig", "scenario", "open", "finding-1.yaml", *options]
        with self._output.open("ab") as output:
            return subprocess.Popen(
                command, cwd=self.folder, env=self.environment, stdin=subprocess.DEVNULL, stdout=output, stderr=output
            )

    def _state(self) -> str:
        state = super()._state()
        return "ready" if state == "paused" else state


@pytest.fixture(scope="module")
def finding() -> Iterator[ServedRig]:
    with OpenedFinding("") as rig:
        yield rig


def test_the_time_line_shows_what_happened_and_goes_back(browser: Browser, finding: ServedRig) -> None:
    with opened(browser, finding) as page:
        page.get_by_role("link", name="Time line").click()
        expect(page.get_by_role("heading", name="finding-1.yaml")).to_be_visible()
        expect(page.get_by_text("does not hold", exact=True)).to_be_visible()
        expect(page.get_by_role("img", name="wires/lamp.on over time")).to_be_visible()
        assert page.locator(".lane path.fault").count() == 1
        rows = page.get_by_role("row")
        expect(rows.filter(has_text="fault wires stuck")).to_have_count(1)
        violation = rows.filter(has_text="violation")
        expect(violation).to_contain_text("580 ms")
        page.get_by_role("button", name="back to 330 ms").first.click()
        expect(violation.get_by_role("button")).to_be_disabled()  # it is in the future now
    assert finding.status()["now_ns"] == 830_000_000


def test_without_a_scenario_there_is_no_time_line(browser: Browser) -> None:
    lab = Path(__file__).parents[3] / "configs/lab.yaml"
    with ServedRig(lab, None, "--set=time=virtual") as rig, opened(browser, rig, path="/timeline") as page:
        expect(page.get_by_text("this rig has not been played a scenario")).to_be_visible()
        said: list[str] = []
        page.on("console", lambda message: said.append(message.text))
        page.reload()
        expect(page.get_by_text("this rig has not been played a scenario")).to_be_visible()
        assert said == []
        expect(page.get_by_role("link", name="Time line")).to_have_count(0)


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("width", [1280, 390])
def test_the_time_line_is_for_everybody(
    browser: Browser, finding: ServedRig, width: int, scheme: Literal["light", "dark"]
) -> None:
    with opened(browser, finding, path="/timeline", width=width, scheme=scheme) as page:
        expect(page.get_by_role("img", name="wires/lamp.on over time")).to_be_visible()
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        assert Axe().run(page).violations_count == 0
