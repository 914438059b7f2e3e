"""The HTTP API of the scope: signals, set-ups, and captures, made without a browser too, with their downloads."""

import asyncio
from collections.abc import Iterator
from typing import Any, Final, Literal, Protocol

from pydantic import BaseModel, ConfigDict, Field
from starlette.responses import Response

from fieldrig.config.rig_file import RigConfig
from fieldrig.errors import ControlError
from fieldrig.text.nearest import closest
from fieldrig_page.api import Call, Operation
from fieldrig_page.rig_link import RigLink
from fieldrig_page.scope.captures import Capture, Captures
from fieldrig_page.scope.export import FORMATS, exported
from fieldrig_page.scope.session import Session, Wish
from fieldrig_page.scope.setup import Setup, read_setup
from fieldrig_page.scope.setups import Setups, missing

LONGEST_S: Final = 600.0
LOOK_S: Final = 0.02
NAME: Final = {"name": "name of a set-up"}
KINDS: Final = {"csv": "text/csv", "vcd": "application/octet-stream"}


class TriggerBody(BaseModel):
    """The event that a scope waits for; each kind takes the keys that describe it."""

    model_config = ConfigDict(extra="forbid")
    kind: Literal["edge", "level", "state", "window", "message", "fault"]
    signal: str = Field(default="", description="PART/KEY, for edge, level, state and window")
    level: float = Field(default=0.0, description="for edge and level, and one of the two limits of a window")
    high: float = Field(default=0.0, description="the other limit of a window")
    what: str = Field(
        default="",
        description="edge: rising, falling or both; level: above or below; window: inside or outside; state: its name; "
        "fault: begin or end; without it the first of these",
    )
    part: str = Field(default="", description="the bus of a message; the bus or device of a fault, or any")
    words: str | list[str] = Field(default=[], description="words that a message has")


class SetupBody(BaseModel):
    """A set-up of the scope; keys that are left out have their defaults."""

    model_config = ConfigDict(extra="forbid")
    signals: list[str] = Field(default=[], description="signals that are drawn, PART/KEY, from top to bottom")
    recorded: list[str] = Field(default=[], description="further signals that are recorded")
    rhythm: str | int = Field(default="cycle", description="cycle, change, or a period in ns")
    window_ns: int = Field(default=10_000_000_000, description="time that is shown, in ns")
    before: float = Field(default=0.5, description="part of the window before the trigger, 0 to 1")
    mode: str = Field(default="run", description="run, auto, normal or single")
    trigger: TriggerBody | None = Field(default=None, description="what is waited for")
    xy: list[str] | None = Field(default=None, description="signals across and up of the XY view")

    def setup(self) -> Setup:
        return read_setup(self.model_dump(exclude_unset=True))


class Shot(BaseModel):
    """A capture to be made: the first trigger of a set-up, or without one the next whole window."""

    model_config = ConfigDict(extra="forbid")
    setup: SetupBody
    timeout_s: float = Field(default=30.0, gt=0, le=LONGEST_S, description="how long to wait, in seconds")


class Scopes(Protocol):
    """The topic, as far as the operations need it."""

    link: RigLink
    captures: Captures
    setups: Setups

    def session(self, user: object) -> Session: ...
    def listen(self) -> None: ...
    def end(self, user: object) -> None: ...


def operations(scope: Scopes) -> Iterator[Operation]:
    """Yield the operations of the scope."""
    config = scope.link.config

    async def signals(call: Call) -> list[dict[str, Any]]:
        found = await all_signals(scope)
        words = call.query.get("search", "").casefold().split()
        return [signal for signal in found if all(word in _searched(signal) for word in words)]

    async def parts(_call: Call) -> dict[str, list[str]]:
        return {"devices": list(config.devices), "buses": list(config.buses)}

    async def names(_call: Call) -> list[str]:
        return scope.setups.names()

    async def opened(call: Call) -> dict[str, Any]:
        setup = scope.setups.open(call.path["name"])
        known = [signal["name"] for signal in await all_signals(scope)]
        away = missing(setup, known, config.devices, config.buses)
        return {"setup": setup.as_data(), "missing": away}

    async def save(call: Call) -> dict[str, Any]:
        body: SetupBody = call.body
        scope.setups.save(call.path["name"], body.setup())
        return {"name": call.path["name"]}

    async def delete(call: Call) -> dict[str, Any]:
        scope.setups.delete(call.path["name"])
        return {"name": call.path["name"]}

    async def captures(_call: Call) -> list[dict[str, Any]]:
        return [about(capture) for capture in scope.captures.all()]

    async def shoot(call: Call) -> dict[str, Any]:
        shot: Shot = call.body
        return about(await capture_of(scope, shot.setup.setup(), shot.timeout_s))

    async def download(call: Call) -> Response:
        capture, form = _capture(scope, call), call.path["format"]
        if form not in FORMATS:
            raise ValueError(f"expected one of {', '.join(FORMATS)}, found {form!r:.40}")
        name = f"{config.name}-capture-{capture.number}.{form}"
        headers = {"content-disposition": f'attachment; filename="{name}"'}
        return Response(exported(capture, form), media_type=KINDS[form], headers=headers)

    search = {"search": "words that must all be in the name or the description"}
    yield Operation(
        "GET", "scope/signals", "Return what can be recorded.", signals, gives=list[dict[str, Any]], queries=search
    )
    yield Operation(
        "GET", "scope/parts", "Return the devices and buses, for triggers.", parts, gives=dict[str, list[str]]
    )
    yield Operation("GET", "scope/setups", "Return the names of the saved set-ups.", names, gives=list[str])
    yield Operation(
        "GET", "scope/setups/{name:path}", "Return a set-up, and its signals that are missing.", opened, parameters=NAME
    )
    yield Operation("PUT", "scope/setups/{name:path}", "Save a set-up.", save, SetupBody, parameters=NAME)
    yield Operation("DELETE", "scope/setups/{name:path}", "Delete a set-up.", delete, parameters=NAME)
    yield Operation("GET", "scope/captures", "Return the captures that are kept.", captures, gives=list[dict[str, Any]])
    yield Operation("POST", "scope/captures", "Wait for a trigger, and return its capture.", shoot, Shot)
    yield Operation(
        "GET",
        "scope/captures/{number}/{format}",
        "Download the samples of a capture for a spreadsheet, or for GTKWave and PulseView.",
        download,
        gives="application/octet-stream",
        parameters={"number": "number of a capture", "format": "csv or vcd"},
    )


async def all_signals(scope: Scopes) -> list[dict[str, Any]]:
    """Return what can be recorded now: points of devices, and wires that have had a value."""
    found: list[dict[str, Any]] = []
    for device, facts in (await scope.link.ask_all("device/*/keys")).items():
        found += [{"name": f"{device}/{key}", **_known(fact)} for key, fact in facts.items()]
    for bus, wires in (await scope.link.ask_all("bus/*/keys")).items():
        found += [{"name": f"{bus}/{wire}", **_known(fact)} for wire, fact in wires.items()]
    return sorted(found, key=lambda signal: str(signal["name"]))


async def capture_of(scope: Scopes, setup: Setup, timeout_s: float) -> Capture:
    """Return the next capture of a set-up.  ControlError if there is none in time, or can be none."""
    _check(setup, scope.link.config)
    loop, user = asyncio.get_running_loop(), object()
    session = scope.session(user)
    deadline_s = loop.time() + timeout_s
    try:
        session.want(Wish(setup._replace(mode="run" if setup.trigger is None else "single"), pixels=16))
        scope.listen()
        while loop.time() < deadline_s:
            if session.trouble is not None:
                raise ControlError(session.trouble.what, session.trouble.remedy)
            found = session.caught if setup.trigger is not None else session.whole_window()
            if found is not None:
                return found
            await asyncio.sleep(LOOK_S)
    finally:
        scope.end(user)
    raise ControlError(f"nothing has triggered within {timeout_s:g} s", "check the trigger, or wait longer")


def _check(setup: Setup, config: RigConfig) -> None:
    """ControlError for a set-up that can give no capture."""
    trigger = setup.trigger
    if trigger is None:
        if not setup.all_signals:
            raise ControlError("there is nothing to record", "name signals, such as tank/level")
        return
    is_message = trigger.kind == "message"
    parts = [*config.buses] if is_message else [*config.buses, *config.devices]
    if trigger.part not in parts and (trigger.part or is_message):
        raise ControlError(f"the rig has no {trigger.part!r} to wait for", closest(trigger.part, parts))


def about(capture: Capture) -> dict[str, Any]:
    return {
        "number": capture.number,
        "first_ns": capture.first_ns,
        "end_ns": capture.end_ns,
        "trigger_ns": None if capture.hit is None else capture.hit.instant_ns,
        "after_ns": None if capture.hit is None else capture.hit.after_ns,
        "lost": capture.lost,
        "signals": list(capture.traces),
    }


def _known(fact: dict[str, Any]) -> dict[str, Any]:
    return {key: fact[key] for key in ("unit", "about", "type", "states") if key in fact}


def _searched(signal: dict[str, Any]) -> str:
    return f"{signal['name']} {signal.get('about', '')}".casefold()


def _capture(scope: Scopes, call: Call) -> Capture:
    number = call.path["number"]
    if not number.isdecimal() or len(number) > 9:
        raise ValueError(f"{number[:20]!r} is no number of a capture")
    return scope.captures[int(number)]
