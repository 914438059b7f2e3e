"""The channels of CAN logs that number their buses from 1, and the names of the buses.

Channel 1 is `can0`, as python-can and can-utils have it.  A bus with any other name gets the next free channel, and the
file says its name in a text that other programs take for a comment: `fieldrig: channel 2 is "axis"`.
"""

import json
import re
from typing import Final

from fieldrig.errors import UsageError

MOST: Final = 255
_LINUX: Final = re.compile(r"can(\d{1,3})")
_TEXT: Final = re.compile(r'fieldrig: channel (\d{1,3}) is (".*")')


class Channels:
    """The channel of each bus that is written."""

    def __init__(self) -> None:
        self._numbers: dict[str, int] = {}

    def __getitem__(self, bus: str) -> int:
        return self._numbers[bus]

    def get(self, bus: str) -> int | None:
        return self._numbers.get(bus)

    def add(self, bus: str) -> str:
        """Give a bus its channel, and return the text that names it.  UsageError for more buses than channels."""
        match = _LINUX.fullmatch(bus)
        wanted = int(match[1]) + 1 if match else 1
        used = set(self._numbers.values())
        free = [wanted, *range(1, MOST + 1)]
        number = next((channel for channel in free if channel not in used and channel <= MOST), None)
        if number is None:
            raise UsageError(f"there are more than {MOST} buses", "choose some of them")
        self._numbers[bus] = number
        return f"fieldrig: channel {number} is {json.dumps(bus)}"


class BusNames:
    """The name of the bus of each channel that is read."""

    def __init__(self) -> None:
        self._names = {channel: f"can{channel - 1}" for channel in range(1, MOST + 1)}

    def __getitem__(self, channel: int) -> str:
        return self._names.get(channel) or (f"can{channel - 1}" if channel > 0 else "can")

    def learn(self, text: str) -> None:
        """Take the name of a bus from a text, if it has one."""
        match = _TEXT.search(text)
        if match is None or int(match[1]) > MOST:
            return
        try:
            name = json.loads(match[2])
        except ValueError:
            return
        if isinstance(name, str) and name:
            self._names[int(match[1])] = name
