"""The fronts of devices: what they are made of, the values of their parts as they are now, and their keys.

The front of a device is asked for by `GET devices/NAME/front`; the topic `front` has the values of its points, read as
long as a page looks at the device.  A key is pressed and released by `POST devices/NAME/front/PART`.  A page that holds
a key names itself there by the number that the topic gave it, so that the key goes up when its socket goes.
"""

import asyncio
import secrets
from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any, ClassVar, Final, NamedTuple

from pydantic import BaseModel, ConfigDict, Field

from fieldrig.device import Value
from fieldrig.errors import ControlError
from fieldrig.outside.untrusted import MalformedError, field, items
from fieldrig.text.nearest import closest
from fieldrig_page.api import Call, GivenValue, Operation, known
from fieldrig_page.guard import DeniedError
from fieldrig_page.held_keys import HeldKey, HeldKeys
from fieldrig_page.live import Page
from fieldrig_page.long_wholes import as_given, for_script
from fieldrig_page.rig_link import RigLink

PERIOD_S: Final = 0.1
"""Time between two looks at the points of a front."""
MOST_DEVICES: Final = 64
"""Most devices that one page looks at."""
HELD_FILE: Final = "page-held-keys.json"


class Operated(BaseModel):
    """An act of a person on a part."""

    model_config = ConfigDict(extra="forbid")
    value: GivenValue = Field(description="true presses a key, false releases it; for any other part its new value")
    page: str = Field(
        default="", max_length=64, description="the page that holds a key, as the topic `front` names it; or none"
    )


class Part(NamedTuple):
    """A part that can be operated, with what its device says of it."""

    device: str
    facts: Mapping[str, Any]

    @property
    def point(self) -> str:
        return str(self.facts["point"])


class State(NamedTuple):
    """The values of the front of a device, or why there are none now, such as a device without power."""

    values: Mapping[str, Value]
    why: str = ""


class _Look:
    """A look at the front of one device."""

    def __init__(self) -> None:
        self.keys: list[str] = []
        self.state = State({})
        """Another object only if something has changed."""


class Fronts:
    """The topic `front`.  A page asks for `{"devices": [NAME, ...]}`."""

    name: ClassVar[str] = "front"

    def __init__(self, link: RigLink) -> None:
        self._link = link
        self.held = HeldKeys(partial(write, link), link.config.run / HELD_FILE)
        self._pages: dict[Page, str] = {}
        """The number of each page."""
        self._wanted: dict[Page, list[str]] = {}
        self._sent: dict[Page, dict[str, State] | None] = {}
        self._looks: dict[str, _Look] = {}
        self._is_wanted = asyncio.Event()

    # ---- pages

    def want(self, page: Page, wish: Any) -> None:
        devices = items(field(wish, "devices", list), str, MOST_DEVICES, "devices")
        if unknown := [name for name in devices if name not in self._link.config.devices]:
            raise MalformedError(f"there is no device {unknown[0]!r:.60}")
        self._pages.setdefault(page, secrets.token_urlsafe(9))
        self._wanted[page], self._sent[page] = list(dict.fromkeys(devices)), None
        self._is_wanted.set()

    def forget(self, page: Page) -> None:
        number = self._pages.pop(page, None)
        self._wanted.pop(page, None)
        self._sent.pop(page, None)
        if number is not None:
            self.held.drop(number)
        if not self._wanted:
            self._is_wanted.clear()
            self._looks.clear()

    def frame(self, page: Page) -> dict[str, Any] | None:
        before = self._sent[page]
        now = {name: self._looks[name].state for name in self._wanted[page] if name in self._looks}
        self._sent[page] = now
        if before is None:
            return {"page": self._pages[page], "whole": True, "devices": {name: now[name]._asdict() for name in now}}
        changed = [name for name, state in now.items() if before.get(name) is not state]
        return {"devices": {name: _news(before.get(name), now[name]) for name in changed}} if changed else None

    # ---- looking

    async def run(self) -> None:
        await self.held.release_left()
        while True:
            await self._is_wanted.wait()
            devices = {name for names in self._wanted.values() for name in names}
            self._looks = {name: look for name, look in self._looks.items() if name in devices}
            await asyncio.gather(*(self.look_at(name) for name in devices))
            await asyncio.sleep(PERIOD_S)

    async def look_at(self, name: str) -> None:
        """Read the points of a device's front."""
        look = self._looks.get(name) or _Look()
        try:
            if not look.keys:
                look.keys = points_of(await self._link.ask(f"device/{name}/front"))
            values = await self._link.ask(f"device/{name}/get", {"keys": look.keys})
            state = State({key: for_script(value) for key, value in values.items()})
        except ControlError as cause:
            look.keys = []  # another program, or the same device after a restart, may have others
            state = State({}, cause.what)
        if state != look.state:
            look.state = state
        self._looks[name] = look

    # ---- operations

    def operations(self) -> Iterator[Operation]:
        link = self._link

        async def front(call: Call) -> dict[str, Any]:
            device = known(call.path["name"], link.config.devices, "device")
            given: dict[str, Any] = await link.ask(f"device/{device}/front")
            return given

        async def operate(call: Call) -> dict[str, Any]:
            device = known(call.path["name"], link.config.devices, "device")
            part = _found(device, await link.recent(f"device/{device}/front"), call.path["part"])
            done: Operated = call.body
            await self._operate(part, done)
            if device in self._looks:
                await self.look_at(device)
            return {"value": done.value}

        names = {"name": "name of a device", "part": "name of a part, such as key.F1"}
        yield Operation(
            "GET",
            "devices/{name}/front",
            "Return the front of a device: its name plate, and groups of parts with the points that they show.",
            front,
            parameters={"name": names["name"]},
        )
        yield Operation(
            "POST",
            "devices/{name}/front/{part:path}",
            "Press or release a key, turn a switch, or set another part; what is refused is answered with 409.",
            operate,
            Operated,
            parameters=names,
        )

    async def _operate(self, part: Part, done: Operated) -> None:
        facts, value = part.facts, done.value
        if facts["sort"] == "key":
            await self._move_key(part, done)
        elif "bit" in facts:
            await self._write(part, await self._with_bit(part, bool(value)))
        else:
            await self._write(part, await as_given(self._link, part.device, part.point, value))

    async def _move_key(self, part: Part, done: Operated) -> None:
        facts, value = part.facts, done.value
        if not isinstance(value, bool):
            raise ValueError(f"{facts['name']} is a key: expected true or false")
        key = HeldKey(part.device, part.point, facts["released"]) if "released" in facts else None
        if not value:
            if key is not None:
                await self.held.release(key, done.page)
        elif key is None or not done.page:
            await self._write(part, facts["pressed"])
        elif done.page in self._pages.values():
            await self.held.press(key, done.page, facts["pressed"])
        else:
            raise DeniedError(409, "the socket of this page has gone", "the page connects again by itself")

    async def _write(self, part: Part, value: Value) -> None:
        await write(self._link, part.device, part.point, value)

    async def _with_bit(self, part: Part, is_on: bool) -> int:
        """Return the number of a point with one bit as it is set."""
        values = await self._link.ask(f"device/{part.device}/get", {"keys": [part.point]})
        number, bit = int(values[part.point]), 1 << int(part.facts["bit"])
        return number | bit if is_on else number & ~bit


def points_of(front: Mapping[str, Any]) -> list[str]:
    """Return the keys of all points that a front names."""
    keys = dict.fromkeys(str(key) for key in front["plate"]["points"].values())
    for part in parts_of(front):
        named = (part.get(name) for name in ("point", "segments", "texts", "cursor", "blinks"))
        keys |= dict.fromkeys(key for key in named if isinstance(key, str))  # `blinks` of a lamp has values
        keys |= dict.fromkeys((*part.get("lines", ()), *part.get("roles", {}).values()))
    return list(keys)


def parts_of(front: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    for group in front["groups"]:
        yield from group["parts"]


def _news(before: State | None, now: State) -> dict[str, Any]:
    """Return what has changed of a device; all of it if it has other values than before."""
    if before is None or before.why != now.why or before.values.keys() != now.values.keys():
        return {**now._asdict(), "whole": True}
    return {"values": {key: value for key, value in now.values.items() if value != before.values[key]}}


async def write(link: RigLink, device: str, point: str, value: Value) -> None:
    """Write a point of a device.  ControlError if the device refuses."""
    await link.ask(f"device/{device}/set", {"values": {point: value}})


def _found(device: str, front: Mapping[str, Any], name: str) -> Part:
    """Return a part by its name.  DeniedError for one that is not there, or that only shows something."""
    operated = {part["name"]: part for part in parts_of(front) if part["operated"]}
    if name not in operated:
        shown = {part["name"] for part in parts_of(front)}
        if name in shown:
            raise DeniedError(409, f"{name} of {device} only shows something", closest(name, list(operated)))
        raise DeniedError(404, f"the front of {device} has no part {name!r}", closest(name, list(operated)))
    return Part(device, operated[name])
