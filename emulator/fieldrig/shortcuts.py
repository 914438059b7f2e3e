"""Shortcuts: places that leave out work whose result is known already.

Each of them has a plain form, which does all of the work, and nothing outside may tell the two apart.  Tests run both
and compare what comes out to the last bit: `fieldrig.testing.plain_forms` selects the plain form.
docs/developers/architecture.md lists all shortcuts with their tests.
"""

from typing import Final


class Shortcut:
    """A place that leaves out work, and its switch.

    Objects read `is_taken` when they are built, so the switch costs nothing while they run.  Only tests change it.
    """

    def __init__(self, name: str, about: str) -> None:
        """`name` is how tests select the place; `about` says which work is left out, and when."""
        self.name, self.about = name, about
        self.is_taken = True
        SHORTCUTS[name] = self


SHORTCUTS: Final[dict[str, Shortcut]] = {}
"""The shortcuts of all modules that have been imported, by name."""
