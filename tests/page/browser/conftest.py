"""One browser for all tests of the page."""

from collections.abc import Iterator

import pytest
from browser_page import CHROMIUM, chromium
from playwright.sync_api import Browser


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    if CHROMIUM is None:
        pytest.skip("needs chromium: apt-get install chromium")
    with chromium() as browser:
        yield browser
