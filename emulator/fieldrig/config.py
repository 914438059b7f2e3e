"""A rig file, read and checked: every mistake in it is found in one go, with file, line, key and what would be right.

    time: virtual
    buses:
      can0: {kind: can.virtual, bitrate: 500000}
    devices:
      io: {kind: canopen.node, node_id: 20, eds: eds/io32.eds, links: {can: can0}}

`extends: other.yaml` takes another file first and lays this one over it: mappings are merged, everything else is
replaced, so is a bus or device that names its `kind` anew, and `name: null` takes one away.
"""

import json
import re
import sys
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from pydantic import Field, ValidationError

from fieldrig import kinds
from fieldrig.bus import Bus, Time
from fieldrig.config_source import gather
from fieldrig.conflicts import conflicts
from fieldrig.device import Device
from fieldrig.errors import ConfigError, Mistake, RigError
from fieldrig.settings import Settings
from fieldrig.wording import closest, explain, show
from fieldrig.yaml_source import KeyPath, Mark, Source, key_text

NAME = r"^[a-z][a-z0-9_-]*$"
CONTROL = r"^((tcp|udp|tls|quic|ws)/[^/\s]+:[0-9]{1,5}|unixsock-stream/\S+)$"

Name = Annotated[str, Field(pattern=NAME)]
OnExit = Literal["restart", "stop", "ignore"]
S = TypeVar("S", bound=Settings)
T = TypeVar("T")


class RigKeys(Settings):
    """Keys of a rig file beside `buses`, `devices` and `extends`."""

    time: Annotated[Time, Field(description="the computer's clock, or one that the rig moves")]
    name: Annotated[Name | None, Field(description="name of the rig; without it the file's")] = None
    seed: Annotated[int, Field(description="where all chance in the rig comes from")] = 0
    speed: Annotated[
        Annotated[float, Field(gt=0)] | Literal["max"] | None,
        Field(description="virtual seconds per second under `fieldrig up`, or max; only with time: virtual"),
    ] = 1.0
    processes: Annotated[
        Literal["one", "each"], Field(description="one process for all devices, or one each; only with time: virtual")
    ] = "one"
    control: Annotated[
        str, Field(pattern=CONTROL, description="Zenoh endpoint of the control service, like tcp/127.0.0.1:7447")
    ] = "tcp/127.0.0.1:7447"
    run: Annotated[str | None, Field(description="folder for sockets, ptys, logs and memories; run/NAME")] = None
    start_timeout_s: Annotated[float, Field(gt=0, description="how long a process may take to be ready")] = 10.0


class BusKeys(Settings):
    """Keys that every bus has beside the settings of its kind."""

    kind: Annotated[str, Field(description="what it is; `fieldrig devices` lists the kinds")]
    process: Annotated[Name | None, Field(description="process that runs its hub; one of its own without it")] = None


class DeviceKeys(Settings):
    """Keys that every device has beside the settings of its kind."""

    kind: Annotated[str, Field(description='what it is: an installed kind, or "module:Class" of your own')]
    links: dict[str, str | list[str]] = Field(
        default_factory=dict, description="the bus, or the list of buses, for each link of the device"
    )
    process: Annotated[Name | None, Field(description="process it runs in; one of its own without it")] = None
    on_exit: Annotated[OnExit, Field(description="what happens when its process dies")] = "restart"
    after: str | list[str] = Field(
        default_factory=list, description="the device, or list of devices, that start before it"
    )


@dataclass(frozen=True)
class BusEntry:
    name: str
    kind: str
    bus: Bus[Any]
    process: str | None


@dataclass(frozen=True)
class DeviceEntry:
    name: str
    kind: str
    cls: type[Device]
    settings: Settings
    links: dict[str, tuple[str, ...]]
    """Parameter to names of buses."""
    many: frozenset[str]
    """The parameters that take a list."""
    process: str
    on_exit: OnExit
    after: tuple[str, ...]


@dataclass(frozen=True)
class RigConfig:
    name: str
    path: Path
    time: Time
    seed: int
    speed: float | None
    """Virtual seconds per second; None as fast as possible."""
    processes: Literal["one", "each"]
    control: str
    run: Path
    start_timeout_s: float
    buses: dict[str, BusEntry]
    devices: dict[str, DeviceEntry]


def load(path: Path, overrides: Sequence[str] = (), only: Collection[str] | None = None) -> RigConfig:
    """The rig file with `overrides` ("buses.can0.bitrate=250000") over it.  ConfigError with every mistake.

    A process that hosts some of the devices names them in `only`: the other devices, and the buses that no device
    in `only` is linked to, are neither imported nor checked, which saves their time.
    """
    return _Loader(gather(path, overrides), path, only).rig()


def from_dict(data: Mapping[str, Any], folder: Path | None = None) -> RigConfig:
    """The same from data in memory; files in it are relative to `folder`, or to the current one."""
    plain = json.loads(json.dumps(data, default=str))
    path = (folder if folder is not None else Path.cwd()) / "rig.yaml"
    return _Loader(Source(plain, {(): Mark("", None)}), path, None).rig()


def start_order(config: RigConfig) -> list[str]:
    """Names of the devices: each after those it names in `after`, else as in the file."""
    return _order({name: device.after for name, device in config.devices.items()})[0]


def _order(after: Mapping[str, tuple[str, ...]]) -> tuple[list[str], list[str]]:
    """Names in the order of starting, and those that wait for each other in a circle."""
    ordered: list[str] = []
    waiting = list(after)
    while ready := next((name for name in waiting if not set(after[name]) & set(waiting)), None):
        ordered.append(ready)
        waiting.remove(ready)
    return ordered, waiting


class _Loader:
    """One walk over one rig file, in which mistakes are collected."""

    def __init__(self, source: Source, path: Path, only: Collection[str] | None) -> None:
        self._source, self._path, self._only = source, path, only
        self._mistakes = source.mistakes
        self._context = {"folder": path.absolute().parent}
        self._time: Time | None = None
        self._buses: dict[str, BusEntry | None] = {}  # None: there, but wrong

    def rig(self) -> RigConfig:
        if self._source.data is None and not self._mistakes:
            self._mistake((), "the file is empty", "it needs `time: real` or `time: virtual`, and devices")
        if self._mistakes and not isinstance(self._source.data, dict):
            raise ConfigError(self._mistakes)
        data = self._mapping((), self._source.data)
        keys = self._rig_keys(data)
        devices_data = self._mapping(("devices",), data.get("devices"))
        wanted = self._wanted_buses(devices_data)
        for name, entry in self._mapping(("buses",), data.get("buses")).items():
            if wanted is None or name in wanted:
                self._buses[name] = self._bus(name, entry)
        devices = self._devices(devices_data)
        buses = {name: bus for name, bus in self._buses.items() if bus is not None}
        for path, what, remedy in conflicts(buses, devices, keys.control if keys else None):
            self._mistake(path, what, remedy)
        if self._mistakes or keys is None:
            raise ConfigError(sorted(self._mistakes, key=lambda mistake: (mistake.file, mistake.line or 0)))
        return self._config(keys, buses, devices)

    def _config(self, keys: RigKeys, buses: dict[str, BusEntry], devices: dict[str, DeviceEntry]) -> RigConfig:
        name = keys.name or self._path.stem
        return RigConfig(
            name=name,
            path=self._path,
            time=keys.time,
            seed=keys.seed,
            speed=None if keys.speed == "max" else keys.speed,
            processes=keys.processes,
            control=keys.control,
            run=Path(keys.run) if keys.run is not None else Path("run") / name,
            start_timeout_s=keys.start_timeout_s,
            buses=buses,
            devices=devices,
        )

    def _rig_keys(self, data: dict[Any, Any]) -> RigKeys | None:
        sections = ("buses", "devices", "extends")
        own = {key: value for key, value in data.items() if key not in sections}
        keys = self._validate(RigKeys, own, (), sections)
        time = data.get("time")
        self._time = time if time in ("real", "virtual") else None
        if self._time == "real":
            for key in {"speed", "processes"} & data.keys():
                self._mistake((key,), f"{key} has no meaning with time: real", "take it away, or set time: virtual")
        return keys

    def _wanted_buses(self, devices: dict[Any, Any]) -> set[Any] | None:
        if self._only is None:
            return None
        wanted = set(self._only)
        for name in self._only:
            for linked in devices.get(name, {}).get("links", {}).values():
                wanted.update(_tuple(linked))
        return wanted

    def _bus(self, name: Any, data: Any) -> BusEntry | None:
        path = ("buses", name)
        entry = self._entry(path, data, BusKeys)
        if entry is None:
            return None
        keys, rest = entry
        cls = self._found(path, lambda: kinds.find_bus(keys.kind), keys.kind)
        if cls is None:
            return None
        if self._time is not None and self._time not in cls.times:
            fitting = _kinds_for(self._time, cls.family)
            self._mistake((*path, "kind"), f"{keys.kind} doesn't run with time: {self._time}", fitting)
        settings = self._validate(kinds.settings_model(cls), rest, path, tuple(BusKeys.model_fields))
        if settings is None:
            return None
        try:
            return BusEntry(name, keys.kind, cls(name, settings), keys.process)
        except (RigError, ValueError) as wrong:
            self._refused(path, wrong)
            return None

    def _devices(self, data: dict[Any, Any]) -> dict[str, DeviceEntry]:
        for name in self._buses.keys() & data.keys():
            self._mistake(("devices", name), f"a bus is called {name} too", "every name in a rig is there once")
        devices = {}
        for name, entry in data.items():
            if self._only is None or name in self._only:
                device = self._device(name, entry, [str(other) for other in data])
                if device is not None:
                    devices[device.name] = device
        if self._only is None:
            for name in (circle := _order({name: device.after for name, device in devices.items()})[1])[:1]:
                what = f"these wait for each other: {', '.join(circle)}"
                self._mistake(("devices", name, "after"), what, "take one `after` away")
        return devices

    def _device(self, name: Any, data: Any, names: list[str]) -> DeviceEntry | None:
        path = ("devices", name)
        entry = self._entry(path, data, DeviceKeys)
        if entry is None:
            return None
        keys, rest = entry
        after = _tuple(keys.after)
        for other in after:
            if other not in names or other == name:
                others = [one for one in names if one != name]
                self._mistake((*path, "after"), f'there is no other device "{other}"', closest(other, others))
        cls = self._found(path, lambda: kinds.find_device(keys.kind), keys.kind)
        parameters = self._found(path, lambda: kinds.link_parameters(cls), keys.kind) if cls is not None else None
        if cls is None or parameters is None:
            return None
        links = self._links((*path, "links"), keys.links, parameters)
        settings = self._validate(kinds.settings_model(cls), rest, path, tuple(DeviceKeys.model_fields))
        if settings is None:
            return None
        many = frozenset(one.name for one in parameters.values() if one.many)
        return DeviceEntry(name, keys.kind, cls, settings, links, many, keys.process or name, keys.on_exit, after)

    def _links(
        self, path: KeyPath, given: dict[str, str | list[str]], parameters: dict[str, kinds.LinkParameter]
    ) -> dict[str, tuple[str, ...]]:
        for name, parameter in parameters.items():
            if parameter.required and not given.get(name):
                fitting = [bus for bus, entry in self._buses.items() if entry and parameter.fits(entry.bus.messages)]
                remedy = f"buses that fit: {', '.join(fitting)}" if fitting else "no bus of this rig fits"
                self._mistake((*path, name), "this link is missing", remedy)
        links: dict[str, tuple[str, ...]] = {}
        for name, linked in given.items():
            if name not in parameters:
                self._mistake((*path, name), "the device has no such link", closest(name, list(parameters)))
            elif isinstance(linked, list) and not parameters[name].many:
                self._mistake((*path, name), "this link takes one bus", f"right would be {name}: BUS")
            else:
                links[name] = _tuple(linked)
                for bus in links[name]:
                    self._link((*path, name), parameters[name], bus)
        every = [bus for linked in links.values() for bus in linked]
        for bus in sorted({bus for bus in every if every.count(bus) > 1}):
            self._mistake(path, f"{bus} is linked twice", "a device has one end of a bus")
        return links

    def _link(self, path: KeyPath, parameter: kinds.LinkParameter, bus: str) -> None:
        if bus not in self._buses:
            self._mistake(path, f'there is no bus "{bus}"', closest(bus, [str(name) for name in self._buses]))
        elif (entry := self._buses[bus]) is not None and not parameter.fits(entry.bus.messages):
            carried, asked = _type_names(entry.bus.messages), _type_names(parameter.messages)
            self._mistake(path, f"{bus} ({entry.kind}) carries {carried}", f"right would be a bus that carries {asked}")

    def _entry(self, path: KeyPath, data: Any, model: type[S]) -> tuple[S, dict[Any, Any]] | None:
        """The keys that every entry of this sort has, and the rest, which is the affair of its kind."""
        self._check_name(path)
        if not isinstance(data, dict):
            self._mistake(path, f"{show(data)} doesn't fit", "right would be a mapping that starts with `kind:`")
            return None
        own = {key: value for key, value in data.items() if key in model.model_fields}
        keys = self._validate(model, own, path)
        rest = {key: value for key, value in data.items() if key not in model.model_fields}
        return (keys, rest) if keys is not None else None

    def _check_name(self, path: KeyPath) -> None:
        if self._matches_name(path[-1]):
            return
        self._mistake(path, f"{show(path[-1])} is not a name", "small letters, digits, _ and -, a letter first")

    @staticmethod
    def _matches_name(name: Any) -> bool:
        return isinstance(name, str) and re.fullmatch(NAME, name) is not None

    def _found(self, path: KeyPath, find: Callable[[], T], kind: str) -> T | None:
        try:
            if ":" in kind:
                _import_from(self._path.absolute().parent)
            return find()
        except RigError as wrong:
            self._mistake((*path, "kind"), wrong.what, wrong.remedy)
            return None

    def _validate(self, model: type[S], data: Any, path: KeyPath, others: tuple[str, ...] = ()) -> S | None:
        """By pydantic's rules for JSON: strict, but a list may become a tuple and a text an enum or path."""
        try:
            return model.model_validate_json(json.dumps(data, default=str), context=self._context)
        except ValidationError as wrong:
            for finding in explain(wrong, data, model, others):
                self._mistake((*path, *finding.path), finding.what, finding.remedy)
            return None

    def _refused(self, path: KeyPath, wrong: RigError | ValueError) -> None:
        what, remedy = (wrong.what, wrong.remedy) if isinstance(wrong, RigError) else (str(wrong), "")
        self._mistake(path, what, remedy)

    def _mapping(self, path: KeyPath, data: Any) -> dict[Any, Any]:
        if isinstance(data, dict):
            return data
        if data is not None:
            self._mistake(path, f"{show(data)} doesn't fit", "right would be a mapping of names to values")
        return {}

    def _mistake(self, path: KeyPath, what: str, remedy: str) -> None:
        self._mistakes.append(Mistake(*self._source.mark(path), key_text(path), what, remedy))


def _kinds_for(time: Time, family: str) -> str:
    fitting = kinds.bus_kinds_for(time, family)
    return f"kinds that do: {', '.join(fitting)}" if fitting else f"no {family} bus does"


def _import_from(folder: Path) -> None:
    """Modules beside the rig file can be imported."""
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))


def _type_names(messages: tuple[type, ...]) -> str:
    return " and ".join(message.__name__ for message in messages)


def _tuple(names: str | list[str]) -> tuple[str, ...]:
    return tuple(names) if isinstance(names, list) else (names,)
