"""Pictures of the extension in an editor: a failing test, a step back, and live values, as docs/pictures has them.

`python -m tests.pictures.editor FOLDER` needs chromium, pngquant and the package code-server of npm, which has Visual
Studio Code for a browser; FOLDER is its folder lib/vscode, with its packages installed and its native modules built.
The editor, its rig and the browser are in a network of their own if the user may make one.  No test compares the
pictures: look at each before it is committed.
"""

import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final
from urllib.error import URLError
from urllib.request import urlopen

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from browser_page import chromium
from network_namespace import network_namespace, why_not
from playwright.sync_api import Locator, Page, ViewportSize, expect
from running_rig import until
from tests.pictures.album import FOLDER
from tests.pictures.page import take

from fieldrig.real.live_rig import FIELDRIG
from fieldrig.testing import free_port
from fieldrig_devices.editor.editors import unpack
from fieldrig_devices.editor.package import extension_files, manifest

MOTOR: Final = """\
FUNCTION_BLOCK Motor
VAR_INPUT start, stop : BOOL; END_VAR
VAR_OUTPUT run : BOOL; END_VAR
VAR longest : TON; END_VAR
longest(IN := run, PT := T#10s);
IF start THEN
  run := TRUE;
END_IF
IF stop OR longest.Q THEN
  run := FALSE;
END_IF
END_FUNCTION_BLOCK

PROGRAM PLC_PRG
VAR
  pump : Motor;
  cycles : DINT;
END_VAR
cycles := cycles + 1;
pump(start := cycles MOD 1000 = 1, stop := cycles MOD 1000 = 700);
END_PROGRAM
"""
TESTS: Final = """\
TEST 'start runs the motor, stop ends it'
VAR m : Motor; END_VAR
m(start := TRUE);
ASSERT_TRUE(m.run);
m(start := FALSE, stop := TRUE);
ASSERT_FALSE(m.run);
END_TEST

TEST 'the motor runs for five seconds at most'
VAR m : Motor; END_VAR
m(start := TRUE);
m(start := FALSE);
ADVANCE_TIME(T#5s);
m();
ASSERT_FALSE(m.run, 'five seconds are over');
END_TEST
"""
RIG: Final = """\
time: virtual
buses: {}
devices: {controller: {kind: max4, program: motor.st, autostart: true}}
"""
SETTINGS: Final = {
    "workbench.startupEditor": "none",
    "workbench.secondarySideBar.defaultVisibility": "hidden",
    "remote.autoForwardPorts": False,
    "telemetry.telemetryLevel": "off",
    "editor.minimap.enabled": False,
    "debug.internalConsoleOptions": "neverOpen",
    "git.enabled": False,
    "update.mode": "none",
    "window.commandCenter": False,
}
SIZE: Final[ViewportSize] = {"width": 1180, "height": 700}
PATIENCE_MS: Final = 60_000
SETTLED_MS: Final = 2_500
STOPPING_LINE: Final = 10


def main(server: Path) -> None:
    own_network = nullcontext() if why_not() else network_namespace()
    with own_network, TemporaryDirectory() as folder, served(server, Path(folder)) as address, chromium() as browser:
        page = browser.new_page(viewport=SIZE, color_scheme="light", reduced_motion="reduce")
        page.set_default_timeout(PATIENCE_MS)
        expect.set_options(timeout=PATIENCE_MS)
        page.goto(address)
        page.get_by_role("button", name="Yes, I trust the authors").click()
        a_failing_test(page)
        a_step_back(page)
        live_values(page)


@contextmanager
def served(server: Path, folder: Path) -> Iterator[str]:
    """An editor with the extension, and the address of a folder with the program in it."""
    work, data, port = folder / "work", folder / "data", free_port()
    for name, text in (("motor.st", MOTOR), ("motor_test.st", TESTS), ("rig.yaml", RIG)):
        (work / name).parent.mkdir(exist_ok=True)
        (work / name).write_text(text, encoding="utf-8")
    settings = {**SETTINGS, "fieldrig.command": list(FIELDRIG), "fieldrig.control": f"tcp/127.0.0.1:{free_port()}"}
    (data / "data/Machine").mkdir(parents=True)
    (data / "data/Machine/settings.json").write_text(json.dumps(settings), encoding="utf-8")
    unpack(data / "extensions", manifest(), extension_files())
    options = ["--without-connection-token", "--accept-server-license-terms", "--server-data-dir", str(data)]
    command = ["node", "out/server-main.js", "--host", "127.0.0.1", "--port", str(port), *options]
    with subprocess.Popen(command, cwd=server, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as editor:
        try:
            address = f"http://127.0.0.1:{port}/"
            until(lambda: answers(address))
            yield f"{address}?folder={work}"
        finally:
            editor.terminate()


def answers(address: str) -> bool:
    try:
        with urlopen(address):
            return True
    except (URLError, OSError):
        return False


# ---- what a user does


def open_file(page: Page, name: str) -> None:
    page.locator(".explorer-folders-view .monaco-list-row").filter(has_text=name).first.dblclick()
    expect(page.locator(f".tab.active[data-resource-name='{name}']")).to_be_visible()


def side(page: Page, name: str) -> None:
    page.locator(f".activitybar .action-label[aria-label^='{name}']").click()


def line(page: Page, number: int) -> Locator:
    """A line of the open file, all of which fits into the window."""
    return page.locator(".editor-instance .view-line").nth(number - 1)


def a_failing_test(page: Page) -> None:
    open_file(page, "motor_test.st")
    side(page, "Testing")
    row = page.locator(".test-explorer .monaco-list-row").filter(has_text="motor_test.st")
    row.hover()
    row.locator(".codicon-testing-run-icon").click()
    expect(row.locator(".codicon-testing-failed-icon")).to_be_visible()
    row.locator(".monaco-tl-twistie").click()
    page.wait_for_timeout(SETTLED_MS)
    take(page, FOLDER / "editor-tests.png")


def a_step_back(page: Page) -> None:
    """Stop in the block, and go back by one step."""
    side(page, "Explorer")
    page.keyboard.press("Control+J")  # closes the panel below
    open_file(page, "motor.st")
    line(page, STOPPING_LINE).click()
    page.keyboard.press("F9")
    page.keyboard.press("F5")
    expect(page.locator(".debug-top-stack-frame-line").first).to_be_visible()
    page.wait_for_timeout(SETTLED_MS)
    page.locator(".debug-toolbar .codicon-debug-step-back").click()
    page.wait_for_timeout(2 * SETTLED_MS)
    take(page, FOLDER / "editor-back.png")


def live_values(page: Page) -> None:
    """Let the program run on, and look at a variable of a block."""
    line(page, STOPPING_LINE).click()
    page.keyboard.press("F9")
    page.keyboard.press("F5")
    page.wait_for_timeout(SETTLED_MS)
    line(page, 5).hover(position={"x": 128, "y": 8})
    expect(page.get_by_text("PLC_PRG.pump.run").first).to_be_visible()
    page.wait_for_timeout(SETTLED_MS)
    take(page, FOLDER / "editor-values.png")
    page.keyboard.press("Shift+F5")
    expect(page.locator(".debug-toolbar")).to_be_hidden()
    page.wait_for_timeout(SETTLED_MS)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
