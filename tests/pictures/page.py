"""Pictures of the page of a rig, light and dark, on a screen and on a telephone, as docs/pictures has them.

`python -m tests.pictures.page` needs chromium and pngquant.  Rigs and browser are in a network of their own if the user
may make one.  No test compares the pictures, as fonts differ between machines: look at each before it is committed.
"""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from contextlib import nullcontext, suppress
from pathlib import Path
from typing import Final, Literal, NamedTuple

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from browser_page import ServedRig, chromium, opened
from network_namespace import network_namespace, why_not
from playwright.sync_api import Browser, Page, expect
from running_rig import until
from tests.pictures.album import FOLDER

from fieldrig.clock import S

CONFIGS: Final = Path(__file__).parents[2] / "configs"
SCHEMES: Final[Sequence[Literal["light", "dark"]]] = ("light", "dark")
SIZES: Final = {"screen": (1280, 860), "telephone": (390, 844)}
FILLED_MS: Final = 45_000
"""How long the page looks before it is taken: spark lines and the scope are filled from when it does."""
SETTLED_MS: Final = 2_500
RUNNING_RAD_PER_S: Final = 3.0
"""Speed of the nip at which the film runs."""


class Scene(NamedTuple):
    """One page that is taken."""

    name: str
    path: str
    prepare: Callable[[Page], object] = lambda _page: None


def main(names: Sequence[str]) -> None:
    with nullcontext() if why_not() else network_namespace(), chromium() as browser:
        if scenes := chosen(OF_LAB, names):
            with ServedRig(CONFIGS / "lab.yaml") as lab:
                run_first(lab)
                set_values(lab, drive={"speed_set": 80, "run": True})
                take_all(browser, lab, scenes)
        if scenes := chosen(OF_VIRTUAL_LAB, names):
            with ServedRig(CONFIGS / "lab.yaml", None, "--set=time=virtual", "--set=speed=1") as lab:
                set_values(lab, drive={"speed_set": 80, "run": True})
                take_all(browser, lab, scenes)
        if scenes := chosen(OF_MACHINE, names):
            with ServedRig(CONFIGS / "machine.yaml", None, "--set=time=virtual") as machine:
                start_the_line(machine)
                take_all(browser, machine, scenes)


def chosen(scenes: Sequence[Scene], names: Sequence[str]) -> list[Scene]:
    return [scene for scene in scenes if not names or scene.name in names]


def start_the_line(machine: ServedRig) -> None:
    """Start glue, film, wrapper and labeller, as their masters do."""
    machine.until_ready()
    until(lambda: bool(machine.ask("device/max4/get", {"keys": ["ring.state"]})["ring.state"] == "up"))
    set_values(machine, drive={"speed_set": 80, "run": True}, line={"F33": True}, plc={"DIF_Start": True})
    until(lambda: bool(machine.ask("device/nip/get", {"keys": ["speed"]})["speed"] > RUNNING_RAD_PER_S))
    set_values(machine, max4={"g_bAutomatic": True})


def run_first(rig: ServedRig) -> None:
    """Let the processes of a rig run before all others, if the user may: browsers on few cores would make it late."""
    rig.until_ready()
    for process in rig.status()["processes"].values():
        with suppress(PermissionError, ProcessLookupError):
            os.sched_setscheduler(process["pid"], os.SCHED_RR, os.sched_param(1))


def set_values(rig: ServedRig, **values: dict[str, object]) -> None:
    for device, of_device in values.items():
        rig.ask(f"device/{device}/set", {"values": of_device})


def take_all(browser: Browser, rig: ServedRig, scenes: Sequence[Scene]) -> None:
    """Take each page in each size and scheme; one page that stays open fills their lines from the start."""
    with opened(browser, rig) as first:
        first.wait_for_timeout(FILLED_MS)
        for scene in scenes:
            for size, (width, height) in SIZES.items():
                for scheme in SCHEMES:
                    with opened(browser, rig, path=scene.path, width=width, height=height, scheme=scheme) as page:
                        expect(page.locator("main section h2").first).to_be_visible()
                        page.wait_for_timeout(SETTLED_MS)
                        scene.prepare(page)
                        take(page, FOLDER / f"page-{scene.name}-{size}-{scheme}.png")


def take(page: Page, picture: Path) -> None:
    page.screenshot(path=picture)
    command = ["pngquant", "--force", "--strip", "--speed=1", "--quality=70-95", "--output", str(picture), str(picture)]
    subprocess.run(command, check=True)


def break_the_ring(page: Page) -> None:
    """Press on the ring between two drives; it stays broken for the pictures that follow."""
    button = page.get_by_role("button", name="break ring between film and jaw")
    if button.count():
        button.click()
        page.wait_for_timeout(2 * SETTLED_MS)


CAUGHT: Final = {
    "signals": ["drive/speed_set", "drive/speed", "drive/running", "wires/pump.speed", "tank/level"],
    "recorded": [],
    "rhythm": "cycle",
    "window_ns": 4 * S,
    "before": 0.25,
    "mode": "single",
    "trigger": {"kind": "edge", "signal": "drive/speed_set", "level": 60, "what": "falling"},
    "xy": None,
}


def catch_a_step(page: Page) -> None:
    """Catch the step of a set point, with what was before it, and measure the way of the drive to it."""
    look: dict[str, object] = {"isStopped": False, "capture": None, "view": None, "cursors": [], "arm": 0}
    remembered = json.dumps({"setup": CAUGHT, "look": look})
    page.evaluate("text => sessionStorage.setItem('scope:lab', text)", remembered)
    set_by_page(page, "drive/points/speed_set", 80)
    page.reload()
    state = page.locator(".scope .pill").first
    expect(state).to_have_text("waiting for the trigger")
    page.wait_for_timeout(2 * SETTLED_MS)
    set_by_page(page, "drive/points/speed_set", 30)
    expect(page.get_by_role("button", name="Run", exact=True)).to_be_visible()
    expect(state).to_have_text("caught")
    page.get_by_role("button", name="Cursors").click()
    page.get_by_label("Cursor A").fill("150")
    page.get_by_label("Cursor B").fill("700")
    page.wait_for_timeout(SETTLED_MS)


def set_by_page(page: Page, point: str, value: float) -> None:
    call = "([path, value]) => import('/static/live.js').then(({ api }) => api('PUT', path, { value }))"
    page.evaluate(call, [f"devices/{point}", value])


OF_LAB: Final = (Scene("lab", "/"),)
OF_VIRTUAL_LAB: Final = (Scene("scope", "/scope", catch_a_step),)
"""In virtual time, so that no sample is missing however busy the host is."""
OF_MACHINE: Final = (
    Scene("front", "/device/max4"),
    Scene("traffic", "/bus/can1"),
    Scene("programs", "/programs/max4"),
    Scene("machine", "/", break_the_ring),
)

if __name__ == "__main__":
    main(sys.argv[1:])
