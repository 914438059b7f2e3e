"""All faults that the buses and devices of a rig can have, made from the models of their settings.

What a model says of a key gives its values: each word of a choice, each wire of a bus, each station of a ring.  A rig
is asked whether it takes a fault, so that a key which fits one device and not another needs no rule.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from fnmatch import fnmatchcase
from itertools import islice, product
from typing import TYPE_CHECKING, Any, Final, Literal, Protocol, get_args, get_origin

from fieldrig.clock import MS
from fieldrig.errors import ControlError, RigError
from fieldrig.faults.faults import Repeated, Timed
from fieldrig.faults.power import MODELS
from fieldrig.text.nearest import closest
from fieldrig_devices.search.choices import Choice

if TYPE_CHECKING:
    from fieldrig.virtual.rig import Rig

MOST_OF_A_KIND: Final = 96
"""Forms of one fault of one bus or device, such as for its wires, before those by duration and condition."""
ALL_BUSES: Final = "buses"
ALL_DEVICES: Final = "devices"
NUMBERS: Final[Mapping[str, Sequence[int | float]]] = {
    "delay_ms": (5, 50, 500),
    "bitrate": (125_000,),
    "baud": (1_200,),
    "bit_error_rate": (0.01,),
    "amplitude": (1.0,),
    "highest_bps": (300,),
    "identifier": (0,),
    "us": (20_000,),
    "length": (0, 4),
    "code": (0x1000, 0x8130),
    "word": (0, 1),
    "number": tuple(range(1, 9)),
}
"""Values of keys without a default: one that a machine has to bear, and one that it cannot."""
_FURTHER: Final[Mapping[tuple[str, str], Sequence[Any]]] = {
    ("offset", "offset"): (1.0,),
    ("replace", "xor"): ("FF",),
    ("stuck", "value"): (False, True),
}
"""Values of keys with a default, by `what` and key, where the default would say nothing, or too little."""
_OPTIONAL: Final = (("drop", "node"), ("delay", "node"), ("distort", "station"))
"""Keys that may be left out, by `what` and key, but that make another fault of it."""


class Wanted(Protocol):
    """The faults that a plan asks for."""

    @property
    def where(self) -> Sequence[str]: ...
    @property
    def kinds(self) -> Sequence[str]: ...
    @property
    def durations(self) -> Sequence[int]: ...
    @property
    def when(self) -> Sequence[str]: ...
    @property
    def given(self) -> Mapping[str, Any]: ...


def matching_parts(rig: "Rig", patterns: Iterable[str]) -> list[str]:
    """Return the buses and devices of patterns, in the order of the rig.  ControlError for a pattern without any."""
    found: dict[str, None] = {}
    for pattern in patterns:
        matching = [name for name, words in _words(rig).items() if any(fnmatchcase(word, pattern) for word in words)]
        if not matching:
            raise ControlError(f"the rig has no bus or device {pattern!r}", closest(pattern, list(_words(rig))))
        found |= dict.fromkeys(matching)
    return [name for name in _words(rig) if name in found]


def _words(rig: "Rig") -> Mapping[str, tuple[str, ...]]:
    """Return what each bus and device may be called: its name, its kind, and what all are called."""
    buses = {name: (name, one.kind, ALL_BUSES) for name, one in rig.config.buses.items()}
    return {**buses, **{name: (name, one.kind, ALL_DEVICES) for name, one in rig.config.devices.items()}}


def fault_choices(rig: "Rig", wanted: Wanted) -> Iterator[Choice]:
    """Yield a choice for each kind of fault of each bus and device.  ControlError if there is none."""
    is_any = False
    for where in matching_parts(rig, wanted.where):
        for what, model in _models(rig, where).items():
            if not any(fnmatchcase(what, pattern) for pattern in wanted.kinds):
                continue
            forms = list(islice(_forms(rig, where, what, model, wanted.given), MOST_OF_A_KIND))
            if forms:
                is_any = True
                yield Choice("fault", where, tuple(_in_time(rig, where, forms, model, wanted)))
    if not is_any:
        _check_keys(rig, wanted)
        kinds = {what for where in matching_parts(rig, wanted.where) for what in _models(rig, where)}
        text = f"{', '.join(wanted.where)} cannot have a fault {', '.join(wanted.kinds)}"
        raise ControlError(text, closest(wanted.kinds[0], sorted(kinds)))


def _check_keys(rig: "Rig", wanted: Wanted) -> None:
    """ControlError for a key that no fault of these buses and devices has."""
    models = [model for where in matching_parts(rig, wanted.where) for model in _models(rig, where).values()]
    keys = sorted({key for model in models for key in model.model_fields})
    for key in wanted.given:
        if key not in keys:
            raise ControlError(f"no fault of {', '.join(wanted.where)} has {key}", closest(key, keys))


def _models(rig: "Rig", where: str) -> Mapping[str, type[Timed]]:
    if where in rig.config.buses:
        return type(rig.buses[where]).fault_models
    return {**MODELS, **rig.config.devices[where].cls.fault_models}


def _in_time(
    rig: "Rig", where: str, forms: Sequence[Mapping[str, Any]], model: type[Timed], wanted: Wanted
) -> Iterator[dict[str, Any]]:
    """Yield forms with durations and conditions; a fault of messages also as one for a single message.

    A fault that takes no duration, such as the break of a serial line, happens once.
    """
    conditions = [{"when": one} for one in wanted.when] or [{}]
    times: list[dict[str, Any]] = [{"duration_ms": duration_ns / MS} for duration_ns in wanted.durations]
    if not _is_taken(rig, where, {**forms[0], **times[0]}):
        times = [{}]
    elif issubclass(model, Repeated):
        times.append({**times[-1], "count": 1})
    for form, time, condition in product(forms, times, conditions):
        yield {**form, **time, **condition}


def _forms(rig: "Rig", where: str, what: str, model: type[Timed], given: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield the forms of a fault that the rig takes."""
    keys = [key for key in model.model_fields if key not in given and _has_values(model, what, key)]
    for chosen in product(*(_values(rig, where, model, what, key) for key in keys)):
        form = {"what": what, **{key: one for key, one in zip(keys, chosen, strict=True) if one is not None}, **given}
        if _is_taken(rig, where, form):
            yield form


def _has_values(model: type[Timed], what: str, key: str) -> bool:
    """True for a key that has to be given, or that has few values."""
    field = model.model_fields[key]
    if key == "what" or key in Repeated.model_fields:
        return False
    is_chosen = (what, key) in _FURTHER or (what, key) in _OPTIONAL
    return is_chosen or field.is_required() or bool(_literals(field.annotation)) or field.annotation is bool


def _literals(annotation: Any) -> tuple[Any, ...]:
    return get_args(annotation) if get_origin(annotation) is Literal else ()


def _values(rig: "Rig", where: str, model: type[Timed], what: str, key: str) -> Sequence[Any]:
    annotation = model.model_fields[key].annotation
    if (what, key) in _OPTIONAL:
        return (None, *_of_bus(rig, where, key)) if where in rig.config.buses else (None,)
    if known := _FURTHER.get((what, key)) or _literals(annotation):
        return known
    if annotation is bool:
        return (False, True)
    if key in NUMBERS:
        return NUMBERS[key]
    return _of_bus(rig, where, key) if where in rig.config.buses else _of_device(rig, where, annotation)


def _of_bus(rig: "Rig", bus: str, key: str) -> Sequence[str]:
    """Return the wires of a bus, or its members."""
    if key in ("wire", "other"):
        heard = (name for names in rig.interests(bus).values() for name in names or ())
        return list(dict.fromkeys([*rig.signals(bus), *map(str, heard)]))
    return [name for name, one in rig.config.devices.items() if bus in one.buses]


def _of_device(rig: "Rig", device: str, annotation: Any) -> Sequence[Any]:
    """Return the last words of the keys of a device, or the numbers in them: sensors, keys and terminals."""
    keys = [key for key, value in rig.values(device).items() if type(value) is bool]
    words = dict.fromkeys(re.split(r"[./]", key)[-1] for key in keys)
    if annotation is not int:
        return list(words)
    return list(dict.fromkeys(int(found[1]) for word in words if (found := re.fullmatch(r"[a-z]*(\d+)", word))))


def _is_taken(rig: "Rig", where: str, form: Mapping[str, Any]) -> bool:
    """Try a fault that begins much later; the caller throws this rig away."""
    try:
        rig.add_fault(where, {**form, "start_ms": 1_000_000})
    except RigError:
        return False
    return True
