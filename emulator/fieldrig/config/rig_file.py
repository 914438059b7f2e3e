"""Load a rig file, and find all of its mistakes at once, each with file, line, key, and what was expected.

    time: virtual
    buses:
      can0: {kind: can.virtual, bitrate: 500000}
    devices:
      io: {kind: canopen.node, node_id: 20, eds: eds/io32.eds, links: {can: can0}}

The keys are in `keys.py`, those of a kind in its settings; `source.py` handles `extends` and overrides.
"""

import json
import re
import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeVar

from fieldrig.bus import Bus, Time
from fieldrig.config import kinds
from fieldrig.config.conflicts import conflicts
from fieldrig.config.entries import BusEntry, DeviceEntry
from fieldrig.config.homes import homes, linked, names_of_part, rules_of, unmatched
from fieldrig.config.keys import NAME, SECTIONS, BusKeys, DeviceKeys, PageKeys, RigKeys, as_tuple, right_part
from fieldrig.config.links import wrong_links
from fieldrig.config.settings_file import validated
from fieldrig.config.source import TYPED, gather
from fieldrig.config.yaml_source import KeyPath, Source, key_text
from fieldrig.device import FAULTS_KEY
from fieldrig.errors import ArgumentError, ConfigError, Mistake, RigError
from fieldrig.outside.addresses import UNIX_SOCKET
from fieldrig.outside.untrusted import shown
from fieldrig.settings import Settings, WrongKey, WrongSettingsError
from fieldrig.system.garbage import without_searches
from fieldrig.system.own_files import OUTSIDE_REMEDY, is_outside_allowed, leaves
from fieldrig.text.nearest import closest
from fieldrig.text.yaml_value import show

S = TypeVar("S", bound=Settings)
T = TypeVar("T")


@dataclass(frozen=True)
class RigConfig:
    """A rig file that was loaded and checked."""

    name: str
    path: Path
    time: Time
    seed: int
    speed: float | None
    """Virtual seconds per second; None is as fast as possible."""
    processes: Literal["one", "each"]
    control: str
    run: Path
    start_timeout_s: float
    ui: PageKeys | None
    """The page of the rig; None if it has none."""
    buses: dict[str, BusEntry]
    devices: dict[str, DeviceEntry]
    overrides: tuple[str, ...] = ()
    """The values given beside the file, such as "buses.can0.bitrate=250000"."""


def load(path: str | Path, overrides: Sequence[str] = (), only: Collection[str] | None = None) -> RigConfig:
    """Load a rig file with `overrides` such as "buses.can0.bitrate=250000".  ConfigError with every mistake.

    A process that runs only some devices and buses names them in `only`.  The rest of the file is then neither imported
    nor checked, except the buses that those devices are linked to.
    """
    if not isinstance(path, str | Path):
        raise ArgumentError(f"a rig file cannot be {shown(path)}", 'expected a path, such as load("rig.yaml")')
    if isinstance(overrides, str) or not all(isinstance(setting, str) for setting in overrides):
        raise ArgumentError(
            f"overrides cannot be {shown(overrides)}", 'expected a list of texts, such as ["buses.can0.bitrate=250000"]'
        )
    with without_searches():
        return _Loader(gather(Path(path), overrides), Path(path), only, overrides).rig()


def load_part(path: Path, overrides: Sequence[str], name: str) -> RigConfig:
    """Load what the process, device or bus of this name needs, and the whole rig if there is none.

    Importing all kinds of a large rig takes seconds of processor time, and each of many containers would do it.
    """
    data = gather(path, overrides).data
    buses, devices = (data.get(section) if isinstance(data, dict) else None for section in ("buses", "devices"))
    if not isinstance(buses, dict) or not isinstance(devices, dict):
        return load(path, overrides)
    return load(path, overrides, names_of_part(name, rules_of(data.get("processes")), buses, devices) or None)


def look_through(
    path: Path, overrides: Sequence[str] = ()
) -> tuple[RigConfig | None, list[DeviceEntry], list[Mistake]]:
    """Return the rig, or None if it has mistakes; its devices without mistakes; and the mistakes."""
    loader = _Loader(gather(path, overrides), path, None, overrides)
    try:
        with without_searches():
            config = loader.rig()
    except ConfigError as wrong:
        return None, loader.right, wrong.mistakes
    return config, loader.right, []


def from_dict(data: Mapping[str, Any], folder: str | Path | None = None) -> RigConfig:
    """Load a rig from data in memory.  Its files are relative to `folder`, or to the current folder."""
    if not isinstance(data, Mapping):
        raise ArgumentError(f"a rig cannot be {shown(data)}", 'expected a mapping with "time" and "devices"')
    folder = Path(folder) if folder is not None else Path.cwd()
    source = Source(json.loads(json.dumps(data, default=str)), folders=[folder.absolute()])
    return _Loader(source, folder / "rig.yaml", None).rig()


def start_order(config: RigConfig) -> list[str]:
    """Return the names of the devices, each after those in its `after`, otherwise in the order of the file."""
    return _order({name: device.after for name, device in config.devices.items()})[0]


def _order(after: Mapping[str, Collection[str]]) -> tuple[list[str], list[str]]:
    """Return the names in starting order, and those that wait for each other in a circle."""
    ordered: list[str] = []
    waiting = list(after)
    while ready := [name for name in waiting if not set(after[name]) & set(waiting)]:
        ordered.append(ready[0])
        waiting.remove(ready[0])
    return ordered, waiting


class _Loader:
    """One pass over one rig file that collects its mistakes."""

    def __init__(self, source: Source, path: Path, only: Collection[str] | None, overrides: Sequence[str] = ()) -> None:
        self._source, self._path, self._only, self._overrides = source, path, only, tuple(overrides)
        self._mistakes = source.mistakes
        self._time: Time | None = None
        self._buses: dict[str, BusEntry | None] = {}  # None: there, but wrong
        self._homes: dict[Any, str] = {}
        self.right: list[DeviceEntry] = []
        """The devices whose entries have no mistake."""

    def rig(self) -> RigConfig:
        if self._source.data is None and not self._mistakes:
            self._mistake((), "the file is empty", "it needs `time: real` or `time: virtual`, and devices")
        data = self._mapping((), self._source.data)
        if data is not self._source.data:
            raise ConfigError(self._mistakes)
        keys = self._rig_keys(data)
        devices_data = self._mapping(("devices",), data.get("devices"))
        buses_data = self._mapping(("buses",), data.get("buses"))
        rules = rules_of(data.get("processes"))
        self._homes = homes(rules, buses_data, devices_data)
        self._mistakes_at(("processes",), unmatched(rules, buses_data, devices_data))
        needed = self._needed(devices_data)
        for name, entry in buses_data.items():
            if needed is None or name in needed:
                self._buses[name] = self._bus(name, entry, self._members(name, devices_data))
        devices = self._devices(devices_data)
        buses = {name: bus for name, bus in self._buses.items() if bus is not None}
        if keys is not None:
            self._mistakes_at((), self._outside(keys))
        if self._only is None:  # a process that hosts a part doesn't know the others; the rig was checked as a whole
            control, is_real = (keys.control, keys.time == "real") if keys is not None else (None, True)
            self._mistakes_at((), conflicts(buses, devices, control, devices_data, is_real=is_real))
        if self._mistakes or keys is None:
            raise ConfigError(sorted(self._mistakes, key=lambda mistake: (mistake.file, mistake.line or 0)))
        return self._config(keys, buses, devices)

    def _outside(self, keys: RigKeys) -> Iterator[WrongKey]:
        """Yield a control socket outside the run folder, unless the user has typed it or allows it."""
        protocol, _, path = keys.control.partition("/")
        is_typed = self._source.mark(("control",)).file.startswith(TYPED)
        if protocol == UNIX_SOCKET and not is_typed and not is_outside_allowed():
            run = _run_folder(keys, self._path)
            if leaves(run.absolute(), str(Path(path).absolute())):
                yield WrongKey(("control",), f"{path} is outside the run folder {run}", OUTSIDE_REMEDY)

    def _config(self, keys: RigKeys, buses: dict[str, BusEntry], devices: dict[str, DeviceEntry]) -> RigConfig:
        return RigConfig(
            name=_rig_name(keys, self._path),
            path=self._path,
            time=keys.time,
            seed=keys.seed,
            speed=None if keys.speed == "max" else keys.speed,
            processes="each" if keys.processes == "each" else "one",
            control=keys.control,
            run=_run_folder(keys, self._path),
            start_timeout_s=keys.start_timeout_s,
            ui=keys.ui or None,
            buses=buses,
            devices=devices,
            overrides=self._overrides,
        )

    def _rig_keys(self, data: dict[Any, Any]) -> RigKeys | None:
        own = {key: value for key, value in data.items() if key not in SECTIONS}
        sections = {section: data[section] for section in SECTIONS if isinstance(data.get(section), dict)}
        for key in own.keys() - RigKeys.model_fields.keys():
            for section in (section for section, entries in sections.items() if key in entries):
                # as `--set tank.area_m2=2` says it
                self._mistake((key,), "there is no such key", f"did you mean {section}.{key}?")
                own.pop(key, None)
        keys = self._validate(RigKeys, own, (), SECTIONS)
        time = data.get("time")
        self._time = time if time in ("real", "virtual") else None
        if self._time == "real" and "speed" in data:
            self._mistake(("speed",), "it has no meaning with time: real", "take it away, or set time: virtual")
        if self._time == "real" and data.get("processes") in ("one", "each"):
            remedy = "name the processes and their devices, such as {nodes: can0}, or set time: virtual"
            self._mistake(("processes",), f"{data['processes']} has no meaning with time: real", remedy)
        return keys

    def _needed(self, devices: dict[Any, Any]) -> set[str] | None:
        """Return the names of the buses to make; None for all."""
        if self._only is None:
            return None
        return {*self._only, *(bus for name, entry in devices.items() if name in self._only for bus in linked(entry))}

    def _members(self, bus: Any, devices: Mapping[Any, Any]) -> dict[str, str]:
        """Return the linked devices with their processes, including those that this process does not run or check."""
        return {name: self._homes[name] for name, entry in devices.items() if bus in linked(entry)}

    def _bus(self, name: Any, data: Any, members: Mapping[str, str]) -> BusEntry | None:
        path = ("buses", name)
        entry = self._entry(path, data, BusKeys)
        if entry is None:
            return None
        keys, rest = entry
        cls = self._found(path, keys.kind, lambda: kinds.find_bus(keys.kind))
        if cls is None:
            return None
        is_replaced = self._time == "virtual" and cls.virtual_kind is not None
        if self._time is not None and self._time not in cls.times and not is_replaced:
            remedy = _fitting_kinds(self._time, cls.family)
            self._mistake((*path, "kind"), f"{keys.kind} doesn't run with time: {self._time}", remedy)
        model = self._found(path, keys.kind, lambda: kinds.settings_model(cls))
        settings = self._validate(model, rest, path, tuple(BusKeys.model_fields)) if model is not None else None
        if settings is None:
            return None
        try:
            bus = _in_virtual_time(cls, name, settings) if is_replaced else cls(name, settings)
            return BusEntry(name, keys.kind, bus, keys.process, members)
        except (RigError, ValueError) as wrong:
            self._mistake(path, *described(wrong))
            return None

    def _devices(self, data: dict[Any, Any]) -> dict[str, DeviceEntry]:
        for name in self._buses.keys() & data.keys():
            self._mistake(("devices", name), f"a bus is called {name} too", "give each a name of its own")
        names = [str(name) for name in data]
        made = [
            self._device(name, entry, names) for name, entry in data.items() if self._only is None or name in self._only
        ]
        devices = {device.name: device for device in made if device is not None}
        circle = _order({name: set(device.after) - {name} for name, device in devices.items()})[1]
        if circle:
            what = f"these wait for each other: {', '.join(circle)}"
            self._mistake(("devices", circle[0], "after"), what, "take one `after` away")
        return devices

    def _device(self, name: Any, data: Any, names: list[str]) -> DeviceEntry | None:
        path = ("devices", name)
        known = len(self._mistakes)
        entry = self._entry(path, data, DeviceKeys)
        if entry is None:
            return None
        keys, rest = entry
        others = [other_name for other_name in names if other_name != name]
        for other in as_tuple(keys.after):
            if other not in others:
                self._mistake((*path, "after"), f'there is no other device "{other}"', closest(other, others))
        cls = self._found(path, keys.kind, lambda: kinds.find_device(keys.kind))
        if cls is None:
            return None
        parameters = self._found(path, keys.kind, lambda: kinds.link_parameters(cls))
        if parameters is None:
            return None
        self._mistakes_at((*path, "links"), wrong_links(keys.links, parameters, self._buses))
        faults = self._faults(kinds.settings_model(cls), rest, path)
        settings = self._validate(kinds.settings_model(cls), rest, path, (*DeviceKeys.model_fields, FAULTS_KEY))
        if settings is None:
            return None
        device = DeviceEntry(
            name=name,
            kind=keys.kind,
            cls=cls,
            settings=settings,
            links={parameter: as_tuple(buses) for parameter, buses in keys.links.items()},
            many=frozenset(parameter.name for parameter in parameters.values() if parameter.many),
            process=self._homes[name],
            on_exit=keys.on_exit,
            after=as_tuple(keys.after),
            faults=faults,
            place=self._source.mark(path),
        )
        self.right += [device] if len(self._mistakes) == known else []
        return device

    def _faults(self, settings: Any, rest: dict[Any, Any], path: KeyPath) -> tuple[dict[str, Any], ...]:
        """Take the key `faults` out of an entry, unless its settings have it; the device reads it when it is built."""
        if FAULTS_KEY not in rest or FAULTS_KEY in settings.model_fields:
            return ()
        faults = rest.pop(FAULTS_KEY)
        if isinstance(faults, list) and all(isinstance(fault, dict) for fault in faults):
            return tuple(faults)
        self._mistake((*path, FAULTS_KEY), f"{show(faults)} doesn't fit", "expected a list such as [{what: power_off}]")
        return ()

    def _entry(self, path: KeyPath, data: Any, model: type[S]) -> tuple[S, dict[Any, Any]] | None:
        """Return the keys that all entries of this sort have, and the rest, which belongs to the kind."""
        name = path[-1]
        if not isinstance(name, str) or re.fullmatch(NAME, name) is None:
            self._mistake(
                path,
                f"{show(name)} is not a name",
                "expected lower-case letters, digits, _ and -, starting with a letter",
            )
        if not isinstance(data, dict):
            self._mistake(path, f"{show(data)} doesn't fit", "expected a mapping with a `kind`")
            return None
        own = {key: value for key, value in data.items() if key in model.model_fields}
        rest = {key: value for key, value in data.items() if key not in model.model_fields}
        keys = self._validate(model, own, path)
        if keys is None:
            keys = right_part(model, own)
        return (keys, rest) if keys is not None else None

    def _found(self, path: KeyPath, kind: str, find: Callable[[], T]) -> T | None:
        try:
            if ":" in kind:
                _import_from(self._path.absolute().parent, kind)
            return find()
        except RigError as wrong:
            self._mistake((*path, "kind"), wrong.what, wrong.remedy)
        except OSError as wrong:
            self._mistake((*path, "kind"), f"its module cannot be searched for: {wrong.strerror or wrong}", "")
        return None

    def _validate(self, model: type[S], data: Any, path: KeyPath, other_keys: tuple[str, ...] = ()) -> S | None:
        """Return the settings, or None after adding their mistakes."""
        try:
            return validated(model, data, self._source.folders, other_keys)
        except WrongSettingsError as wrong:
            self._mistakes_at(path, wrong.wrong)
            return None

    def _mapping(self, path: KeyPath, data: Any) -> dict[Any, Any]:
        if isinstance(data, dict):
            return data
        if data is not None:
            self._mistake(path, f"{show(data)} doesn't fit", "expected a mapping of names to values")
        return {}

    def _mistakes_at(self, path: KeyPath, wrong_keys: Iterable[WrongKey]) -> None:
        for wrong in wrong_keys:
            self._mistake((*path, *wrong.path), wrong.what, wrong.remedy)

    def _mistake(self, path: KeyPath, what: str, remedy: str) -> None:
        self._mistakes.append(Mistake(*self._source.mark(path), key_text(path), what, remedy))


def _rig_name(keys: RigKeys, path: Path) -> str:
    return keys.name if keys.name is not None else path.stem


def _run_folder(keys: RigKeys, path: Path) -> Path:
    return Path(keys.run) if keys.run is not None else Path("run") / _rig_name(keys, path)


def _in_virtual_time(cls: type[Bus[Any]], name: str, settings: Settings) -> Bus[Any]:
    """Return a bus of the kind that models this one in virtual time, with those of the settings that it knows."""
    assert cls.virtual_kind is not None
    stand_in = kinds.find_bus(cls.virtual_kind)
    model = kinds.settings_model(stand_in)
    known = {key: getattr(settings, key) for key in settings.model_fields_set if key in model.model_fields}
    return stand_in(name, model.model_construct(**known))


def described(wrong: Exception) -> tuple[str, str]:
    """Return the problem, and its remedy if there is one."""
    return (wrong.what, wrong.remedy) if isinstance(wrong, RigError) else (str(wrong), "")


def _fitting_kinds(time: Time, family: str) -> str:
    fitting = kinds.bus_kinds_for(time, family)
    return f"kinds that do: {', '.join(fitting)}" if fitting else f"no {family} bus does"


def _import_from(folder: Path, kind: str) -> None:
    """Make modules beside the rig file importable.  RigError if another module of that name is already imported."""
    name = kind.partition(":")[0].partition(".")[0]
    beside = next((file for file in (folder / f"{name}.py", folder / name / "__init__.py") if file.is_file()), None)
    loaded = getattr(sys.modules.get(name), "__file__", None)
    if beside is not None and loaded is not None and Path(loaded).resolve() != beside.resolve():
        raise RigError(f"another module {name} is in use already: {loaded}", f"give {beside.name} another name")
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))
