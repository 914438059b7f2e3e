"""The page of a running rig in Debian's Chromium: what the tests and the pictures of the page look at."""

import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Final, Literal

from page_addresses import WITH_PAGE, addresses
from playwright.sync_api import Browser, Page, expect, sync_playwright
from running_rig import RunningRig

from fieldrig.testing import free_port

CHROMIUM: Final = shutil.which("chromium")
# It shall show one page, and speak to no other host.
QUIET: Final = (
    *("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
)
PATIENCE_MS: Final = 60_000
expect.set_options(timeout=PATIENCE_MS)  # the host of the tests may be busy
Role = Literal["operate", "look"]


class ServedRig(RunningRig):
    """A rig that is ready, with its page."""

    def __init__(
        self,
        rig: str | Path,
        kinds: Path | None = None,
        *options: str,
        environment: Mapping[str, str] | None = None,
    ) -> None:
        ui = f"--set=ui.listen=127.0.0.1:{free_port()}"
        super().__init__(rig, kinds, ui, *options, environment={**WITH_PAGE, **(environment or {})})
        self.until_ready()

    def addresses(self) -> dict[str, str]:
        """Return the addresses of the page with their tokens, by role."""
        return addresses(self)


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
    page.on("pageerror", lambda error: mistakes.append(f"{error.message}\n{error.stack}"))
    page.goto(f"{rig.addresses()[role]}#{path}")  # the first view would leave its signals to the scope
    yield page
    found = "\n".join(mistakes)  # before the window closes in the middle of something
    context.close()
    assert not found, found
