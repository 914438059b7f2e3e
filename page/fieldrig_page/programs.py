"""The programs of a rig for the page: source, current lines, live values and task times, and their control.

Breakpoints and steps are left to editors (`fieldrig debug-adapter`).
"""

import asyncio
from collections.abc import Iterator
from typing import Any, ClassVar, Final, Literal

from pydantic import BaseModel, ConfigDict, Field

from fieldrig.device import Value
from fieldrig.errors import ControlError
from fieldrig.outside.untrusted import MalformedError, field, items
from fieldrig_page.api import Call, Operation, known
from fieldrig_page.live import Page
from fieldrig_page.long_wholes import for_script
from fieldrig_page.program_questions import debug, has_program, leaves, read_variables
from fieldrig_page.rig_link import RigLink

POLL_S: Final = 0.25
SHARE: Final = 4
MOST_NAMES: Final = 500
"""Names of values that one page may show at a time."""
TASK: Final = "/task/"
"""Is in the keys of the points of a task, such as `plc/task/Main/cycle`."""
ACTIONS: Final = ("start", "stop", "reset", "force", "release", "write")


class Orders(BaseModel):
    """The details of an action."""

    model_config = ConfigDict(extra="forbid")
    values: dict[str, Value] = Field(default_factory=dict, description="values by variable, to force or write")
    names: list[str] = Field(default_factory=list, description="variables to release")
    kind: Literal["warm", "cold", "origin"] | None = Field(None, description="how far a reset goes")


class _Wish:
    """The program and the names that one page looks at."""

    def __init__(self, device: str, names: list[str]) -> None:
        self.device, self.names = device, names
        self.sent: dict[str, Any] = {}


class Programs:
    """The topic `program`, and what the HTTP API asks about programs."""

    name: ClassVar[str] = "program"

    def __init__(self, link: RigLink) -> None:
        self._link = link
        self._wishes: dict[Page, _Wish] = {}
        self._present: dict[str, dict[str, Any]] = {}
        self._task_keys: dict[str, tuple[int, list[str]]] = {}
        """The keys of the task points of each device, and the count of loads of the program that has them."""
        self._more = asyncio.Event()

    # ---- the topic

    def want(self, page: Page, wish: Any) -> None:
        """Show a program: `{"device": "plc", "names": ["Main.Counter"]}`, the values of these names beside it."""
        device = field(wish, "device", str)
        if device not in self._link.config.devices:
            raise MalformedError(f"there is no device {device!r:.60}")
        names = items(field(wish, "names", list), str, MOST_NAMES, "names")
        self._wishes[page] = _Wish(device, list(dict.fromkeys(names)))
        self._more.set()

    def forget(self, page: Page) -> None:
        self._wishes.pop(page, None)

    def frame(self, page: Page) -> dict[str, Any] | None:
        """Return the parts of the present state that have changed: `state`, `values`, `tasks`, `forced`."""
        wish = self._wishes[page]
        present = self._present.get(wish.device)
        if present is None:
            return None
        mine = {**present, "values": {name: present["values"].get(name) for name in wish.names}}
        changed = {key: part for key, part in mine.items() if wish.sent.get(key) != part}
        if not changed:
            return None
        wish.sent = mine
        return {"device": wish.device, **changed}

    async def run(self) -> None:
        loop = asyncio.get_running_loop()
        while True:
            began_s = loop.time()
            self._more.clear()  # before the look, so that a request that comes meanwhile is seen at once
            devices = {wish.device for wish in self._wishes.values()}
            self._present = {device: await self._look(device) for device in sorted(devices)}
            wait_s = max(POLL_S, SHARE * (loop.time() - began_s)) if devices else None
            try:
                async with asyncio.timeout(wait_s):
                    await self._more.wait()
            except TimeoutError:
                continue

    async def _look(self, device: str) -> dict[str, Any]:
        names = list(dict.fromkeys(n for wish in self._wishes.values() if wish.device == device for n in wish.names))
        try:
            return {
                "state": await self.state(device),
                "values": await self._values(device, names[:MOST_NAMES]),
                "forced": [
                    {**one, "value": for_script(one["value"])}
                    for one in (await debug(self._link, device, "forced"))["variables"]
                ],
                "tasks": await self._tasks(device),
            }
        except ControlError as wrong:
            return {"state": {"trouble": wrong.what}, "values": {}, "forced": [], "tasks": {}}

    async def _values(self, device: str, names: list[str]) -> dict[str, Any]:
        """Return the values of those names that are variables; a name in a source may be a keyword as well."""
        if not names:
            return {}
        readings = await read_variables(self._link, device, names)
        found = {name: value for name, (value, trouble) in readings.items() if not trouble}
        return {name: for_script(value) for name, value in found.items() if value is not None}

    async def _tasks(self, device: str) -> dict[str, Any]:
        loads = (await debug(self._link, device, "state"))["loads"]
        known, keys = self._task_keys.get(device, (-1, []))
        if known != loads:
            facts = await self._link.ask(f"device/{device}/keys")
            keys = [key for key in facts if TASK in key]
            self._task_keys[device] = loads, keys
        return dict(await self._link.ask(f"device/{device}/get", {"keys": keys})) if keys else {}

    # ---- what the HTTP API asks

    async def state(self, device: str) -> dict[str, Any]:
        """Return state, files and threads of a program, each thread with its place.  ControlError without one."""
        state = await debug(self._link, device, "state")
        files = (await debug(self._link, device, "files"))["files"]
        threads = [{**thread, "frames": await self._frames(device, thread["number"])} for thread in state["threads"]]
        kept = ("language", "state", "loads", "progress", "problem")
        return {**{key: state[key] for key in kept}, "files": files, "threads": threads}

    async def _frames(self, device: str, thread: int) -> list[Any]:
        try:
            frames: list[Any] = (await debug(self._link, device, "stack", thread=thread))["frames"]
        except ControlError:  # it has ended meanwhile
            return []
        return frames

    async def source(self, device: str, file: str) -> str:
        """Return the text of a file of the program."""
        return str((await debug(self._link, device, "source", file=file))["text"])

    async def variables(self, device: str, path: str) -> list[Any]:
        """Return the variables of a group; the groups at the top for an empty path."""
        return list((await debug(self._link, device, "variables", path=path))["variables"])

    async def act(self, device: str, action: str, orders: Orders) -> Any:
        """Start, stop or reset a program, or force, release or write variables.  ControlError if it cannot."""
        if action not in ACTIONS:
            raise ControlError(f"a program cannot {action!r:.40}", f"it can: {', '.join(ACTIONS)}")
        answer = await debug(self._link, device, action, **orders.model_dump(exclude_defaults=True))
        for variable in answer.get("variables", ()):
            if "error" in variable:
                raise ControlError(variable["error"])
        self._more.set()
        return answer

    def operations(self) -> Iterator[Operation]:
        """Yield the operations on programs."""
        link = self._link

        def device_of(call: Call) -> str:
            return known(call.path["name"], link.config.devices, "device")

        async def all_programs(_call: Call) -> list[str]:
            devices = list(link.config.devices)
            found = await asyncio.gather(*(has_program(link, device) for device in devices))
            return [device for device, has in zip(devices, found, strict=True) if has]

        async def state(call: Call) -> dict[str, Any]:
            return await self.state(device_of(call))

        async def source(call: Call) -> dict[str, str]:
            return {"text": await self.source(device_of(call), call.path["file"])}

        async def variables(call: Call) -> list[Any]:
            return await self.variables(device_of(call), call.query.get("path", ""))

        async def values(call: Call) -> list[Any]:
            return await leaves(link, device_of(call))

        async def act(call: Call) -> Any:
            return await self.act(device_of(call), call.path["action"], call.body)

        device = {"name": "name of a device with a program"}
        yield Operation(
            "GET", "programs", "Return the names of the devices with programs.", all_programs, gives=list[str]
        )
        yield Operation("GET", "programs/{name}", "Return state, files and tasks.", state, parameters=device)
        yield Operation(
            "GET", "programs/{name}/source/{file:path}", "Return the text of a file of a program.", source,
            parameters={**device, "file": "name of the file"},
        )  # fmt: skip
        yield Operation(
            "GET", "programs/{name}/variables", "Return the variables of a group.", variables, gives=list[Any],
            parameters=device, queries={"path": "the group; without it those at the top"},
        )  # fmt: skip
        yield Operation(
            "GET", "programs/{name}/values", "Return all variables that have values.", values, gives=list[Any],
            parameters=device,
        )  # fmt: skip
        yield Operation(
            "POST", "programs/{name}/{action}", "Start, stop or reset a program; force, release or write variables.",
            act, Orders, parameters={**device, "action": ", ".join(ACTIONS)},
        )  # fmt: skip
