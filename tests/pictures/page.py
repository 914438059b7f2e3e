"""Pictures of the page of a rig, light and dark, on a screen and on a telephone, as docs/pictures has them.

`python -m tests.pictures.page` needs chromium and pngquant.  Rigs and browser are in a network of their own if the user
may make one.  No test compares the pictures, as fonts differ between machines: look at each before it is committed.
"""

import subprocess
import sys
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Final, Literal, NamedTuple

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from browser_page import ServedRig, chromium, opened
from network_namespace import network_namespace, why_not
from playwright.sync_api import Browser, Page
from tests.pictures.album import FOLDER

CONFIGS: Final = Path(__file__).parents[2] / "configs"
SCHEMES: Final[Sequence[Literal["light", "dark"]]] = ("light", "dark")
SIZES: Final = {"screen": (1280, 860), "telephone": (390, 844)}
FILLED_MS: Final = 45_000
"""How long the page looks before it is taken: spark lines and the scope are filled from when it does."""
SETTLED_MS: Final = 2_500


class Scene(NamedTuple):
    """One page that is taken."""

    name: str
    path: str
    prepare: Callable[[Page], object] = lambda _page: None


def main(names: Sequence[str]) -> None:
    with nullcontext() if why_not() else network_namespace(), chromium() as browser:
        with ServedRig(CONFIGS / "lab.yaml") as lab:
            lab.ask("device/drive/set", {"values": {"speed_set": 80, "run": True}})
            take_all(browser, lab, [scene for scene in OF_LAB if not names or scene.name in names])
        with ServedRig(CONFIGS / "machine-virtual.yaml", "--set=speed=1") as machine:
            take_all(browser, machine, [scene for scene in OF_MACHINE if not names or scene.name in names])


def take_all(browser: Browser, rig: ServedRig, scenes: Sequence[Scene]) -> None:
    """Take each page in each size and scheme; one page that stays open fills their lines from the start."""
    if not scenes:
        return
    with opened(browser, rig) as first:
        first.wait_for_timeout(FILLED_MS)
        for scene in scenes:
            for size, (width, height) in SIZES.items():
                for scheme in SCHEMES:
                    with opened(browser, rig, path=scene.path, width=width, height=height, scheme=scheme) as page:
                        page.wait_for_timeout(SETTLED_MS)
                        scene.prepare(page)
                        take(page, FOLDER / f"page-{scene.name}-{size}-{scheme}.png")


def take(page: Page, picture: Path) -> None:
    page.screenshot(path=picture)
    command = ["pngquant", "--force", "--strip", "--speed=1", "--quality=70-95", "--output", str(picture), str(picture)]
    subprocess.run(command, check=True)


def break_the_ring(page: Page) -> None:
    page.get_by_role("button", name="break ring between infeed and film").click()
    page.wait_for_timeout(SETTLED_MS)


OF_LAB: Final = (Scene("lab", "/"), Scene("time", "/time"))
OF_MACHINE: Final = (Scene("machine", "/"),)

if __name__ == "__main__":
    main(sys.argv[1:])
