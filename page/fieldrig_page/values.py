"""The values of a rig for the page: one list for each device, whatever the device calls them, and what they are now.

Objects of a dictionary, registers, parameters and inputs are points of a device; the variables of its program are
beside them, under `program:NAME`.  One reader asks for the values that any page shows, so that five pages cost a device
no more than one, and it waits longer for a device that takes long to answer.
"""

import asyncio
from collections.abc import Iterable, Mapping
from typing import Any, ClassVar, Final

from fieldrig.errors import ControlError
from fieldrig.outside.untrusted import MalformedError, field, items
from fieldrig_page.live import Page
from fieldrig_page.long_wholes import for_script
from fieldrig_page.program_questions import PROGRAM, read_variables
from fieldrig_page.rig_link import RigLink

POLL_S: Final = 0.25
SHARE: Final = 4
"""After an answer that took a time, the device is left alone for this many times as long."""
MOST_POINTS: Final = 1_000
"""Values that one page may show at a time."""

Name = tuple[str, str]
"""Device and key."""


class Reading:
    """The last value of one point, or why there is none."""

    __slots__ = ("trouble", "value")

    def __init__(self, value: Any, trouble: str = "") -> None:
        self.value, self.trouble = value, trouble

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Reading) and (self.value, self.trouble) == (other.value, other.trouble)

    __hash__ = None  # type: ignore[assignment]  # it is compared, and never a key


class Values:
    """The topic `values`."""

    name: ClassVar[str] = "values"

    def __init__(self, link: RigLink) -> None:
        self._link = link
        self._wanted: dict[Page, list[Name]] = {}
        self._sent: dict[Page, dict[Name, Reading]] = {}
        self._present: dict[Name, Reading] = {}
        self._more = asyncio.Event()
        self._readers: dict[str, asyncio.Task[None]] = {}

    def want(self, page: Page, wish: Any) -> None:
        """Show these points from now on: `{"points": ["io/6200:01", "tank/level"]}`."""
        names = [_name(text) for text in items(field(wish, "points", list), str, MOST_POINTS, "points")]
        unknown = [device for device, _ in names if device not in self._link.config.devices]
        if unknown:
            raise MalformedError(f"there is no device {unknown[0]!r:.60}")
        self._wanted[page], self._sent[page] = names, {}
        self._more.set()

    def forget(self, page: Page) -> None:
        self._wanted.pop(page, None)
        self._sent.pop(page, None)

    def frame(self, page: Page) -> dict[str, Any] | None:
        """Return the values that the page does not have: `values` by name, and `troubles` of those that have none."""
        sent, values, troubles = self._sent[page], {}, {}
        for name in self._wanted[page]:
            reading = self._present.get(name)
            if reading is None or sent.get(name) == reading:
                continue
            sent[name] = reading
            if reading.trouble:
                troubles["/".join(name)] = reading.trouble
            else:
                values["/".join(name)] = for_script(reading.value)
        return {"values": values, "troubles": troubles} if values or troubles else None

    async def run(self) -> None:
        """Have a reader for each device that a page looks at."""
        try:
            while True:
                for device in {device for names in self._wanted.values() for device, _ in names}:
                    if device not in self._readers:
                        self._readers[device] = asyncio.get_running_loop().create_task(self._read(device))
                self._more.clear()
                await self._more.wait()
        finally:
            for reader in self._readers.values():
                reader.cancel()

    async def _read(self, device: str) -> None:
        """Read what pages want to see of a device, until they want nothing more of it."""
        loop = asyncio.get_running_loop()
        while keys := self._keys_of(device):
            began_s = loop.time()
            for key, reading in (await self._readings(device, keys)).items():
                self._present[device, key] = reading
            await asyncio.sleep(max(POLL_S, SHARE * (loop.time() - began_s)))
        self._present = {name: reading for name, reading in self._present.items() if name[0] != device}
        del self._readers[device]

    def _keys_of(self, device: str) -> list[str]:
        return list(dict.fromkeys(key for names in self._wanted.values() for of, key in names if of == device))

    async def _readings(self, device: str, keys: list[str]) -> dict[str, Reading]:
        points = [key for key in keys if not key.startswith(PROGRAM)]
        variables = [key.removeprefix(PROGRAM) for key in keys if key.startswith(PROGRAM)]
        found = await self._read_points(device, points) if points else {}
        if variables:
            found |= {
                PROGRAM + name: Reading(value, trouble)
                for name, (value, trouble) in (await read_variables(self._link, device, variables)).items()
            }
        return found

    async def _read_points(self, device: str, keys: list[str]) -> dict[str, Reading]:
        try:
            return _as_readings(await self._link.ask(f"device/{device}/get", {"keys": keys}))
        except ControlError as wrong:
            if len(keys) == 1:
                return {keys[0]: Reading(None, wrong.what)}
        half = len(keys) // 2  # one of them is not there any more, as after another program was loaded
        return await self._read_points(device, keys[:half]) | await self._read_points(device, keys[half:])


def _name(text: str) -> Name:
    device, slash, key = text.partition("/")
    if not slash:
        raise MalformedError(f"expected DEVICE/KEY, found {text!r:.60}")
    return device, key


def _as_readings(values: Mapping[str, Any] | Iterable[Any]) -> dict[str, Reading]:
    return {key: Reading(value) for key, value in dict(values).items()}
