"""Lists of names that may be long, as in a rig of 500 devices."""

from collections.abc import Sequence


def listed(names: Sequence[str], room: int) -> str:
    """Return the first names that fit into `room` characters, at least one, and the number of the others."""
    shown = ", ".join(names)
    count = len(names)
    while len(shown) > room and count > 1:
        count -= 1
        shown = f"{', '.join(names[:count])} and {len(names) - count} more"
    return shown
