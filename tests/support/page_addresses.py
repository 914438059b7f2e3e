"""The addresses of the page that a rig has printed."""

import re
from typing import Final

from running_rig import RunningRig

from fieldrig.outside.page_seat import NO_PAGE_VARIABLE

WITH_PAGE: Final = {NO_PAGE_VARIABLE: "0"}
"""The environment of a rig with a page: other rigs of the tests have none."""


def addresses(rig: RunningRig) -> dict[str, str]:
    """Return the addresses with their tokens, by role."""
    return dict(re.findall(r"^page to (\w+): +(\S+)$", rig.output(), re.MULTILINE))
