"""The page of a running rig in Debian's Chromium: what the tests and the pictures of the page look at."""

import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Final, Literal, Self

from playwright.sync_api import Browser, Page, sync_playwright
from running_rig import RunningRig, until

from fieldrig.testing import free_port

CHROMIUM: Final = shutil.which("chromium")
# It shall show one page, and speak to no other host.
QUIET: Final = (
    *("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
)
PATIENCE_MS: Final = 60_000
NO_PAGE: Final = {"FIELDRIG_NO_UI": "1"}
Role = Literal["operate", "look"]


class ServedRig(RunningRig):
    """A rig that is ready, with a process of its page."""

    def __init__(self, rig: Path, *options: str, environment: Mapping[str, str] | None = None) -> None:
        super().__init__(rig, None, *options, environment={**NO_PAGE, **(environment or {})})
        self.until_ready()
        self._printed = self.folder / "page.out"
        self._page = self._start_page()

    def addresses(self) -> dict[str, str]:
        """Return the addresses of the page with their tokens, by role."""
        lines = self._printed.read_text().splitlines()
        return {role: address for role, _, address in (line.partition(": ") for line in lines)}

    def close(self) -> None:
        self._page.terminate()
        self._page.wait(timeout=60)
        super().close()

    def _start_page(self) -> "subprocess.Popen[bytes]":
        command = [sys.executable, "-m", "fieldrig_page", str(self.file), "--control", self.endpoint]
        with self._printed.open("wb") as printed:
            page = subprocess.Popen([*command, "--listen", f"127.0.0.1:{free_port()}"], stdout=printed)
        until(lambda: "look" in self.addresses())
        return page

    def __enter__(self) -> Self:
        return self


@contextmanager
def chromium() -> Iterator[Browser]:
    """The browser, without a window."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(QUIET))
        yield browser
        browser.close()


@contextmanager
def opened(
    browser: Browser,
    rig: ServedRig,
    role: Role = "operate",
    *,
    path: str = "/",
    width: int = 1280,
    height: int = 860,
    scheme: Literal["light", "dark"] = "light",
) -> Iterator[Page]:
    """The page of a rig in a window of this size.  At its end it has reported no mistake of its scripts."""
    context = browser.new_context(
        viewport={"width": width, "height": height}, color_scheme=scheme, reduced_motion="reduce"
    )
    context.set_default_timeout(PATIENCE_MS)
    page = context.new_page()
    mistakes: list[str] = []
    page.on("pageerror", lambda error: mistakes.append(str(error)))
    page.goto(rig.addresses()[role])
    page.goto(f"{page.url.partition('#')[0]}#{path}")
    yield page
    context.close()
    assert not mistakes
