"""Completion in the shell: kinds, rig files, and what the running rig has.

Completion is silent.  If no rig answers at once, nothing is offered, and the shell falls back to file names.
"""

import os
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import typer

if TYPE_CHECKING:
    from fieldrig.control.messages import Client

PATIENCE_S: Final = 1.0
"""Time limit for an answer, in seconds; a process that takes longer is left out."""
RIG_FILES: Final = (".yaml", ".yml")
BREAKS: Final = (":", "=")
"""The characters at which bash splits a word, by its default COMP_WORDBREAKS; the parts arrive as separate words."""

Offers = list[str | tuple[str, str]]
"""Words, or words with a line about each."""


def kind(incomplete: str) -> Offers:
    """Offer the installed kinds of buses and devices, without importing them."""
    from fieldrig.config.kinds import BUSES, DEVICES, installed

    return [name for group in (BUSES, DEVICES) for name in installed(group) if name.startswith(incomplete)]


def rig_file(incomplete: str) -> Offers:
    """Offer YAML files and folders; if only a folder matches, offer its content."""
    paths = _in_folder(incomplete)
    while len(paths) == 1 and paths[0].endswith("/"):
        paths = _in_folder(paths[0])
    return [*paths]


def point(ctx: typer.Context, incomplete: str) -> Offers:
    """Offer devices, and the keys of one device, for `get`."""
    return _offer(ctx, "names", incomplete, lambda rig, word, _: _points(rig, word, is_to_write=False))


def setting(ctx: typer.Context, incomplete: str) -> Offers:
    """Offer the keys that can be written, up to the `=`, for `set`."""

    def offer(rig: "Client", word: str, before: list[str]) -> Iterable[str]:
        is_value = "=" in word or any("=" not in earlier for earlier in before)  # bash cuts the = off
        return () if is_value else _points(rig, word, is_to_write=True)

    return _offer(ctx, "settings", incomplete, offer)


def watched(ctx: typer.Context, incomplete: str) -> Offers:
    """Offer buses, devices, and the keys of one device, for `watch`."""

    def offer(rig: "Client", word: str, before: list[str]) -> Iterable[str]:
        buses = () if "/" in word else [bus for bus in _status(rig)["buses"] if bus.startswith(word)]
        return [*buses, *_points(rig, word, is_to_write=False)]

    return _offer(ctx, "patterns", incomplete, offer)


def signal(ctx: typer.Context, incomplete: str) -> Offers:
    """Offer points and wires for `record`: devices and buses with signals, and the keys of one of them."""

    def offer(rig: "Client", word: str, before: list[str]) -> Iterable[str]:
        part, slash, _ = word.partition("/")
        named = [bus for bus in _status(rig)["buses"] if bus == part or (not slash and bus.startswith(part))]
        wires = {bus: found for bus in named if (found := _wires(rig, bus))}
        of_one = [f"{part}/{wire}" for wire in wires.get(part, ())]
        return [*([] if slash else wires), *of_one, *_points(rig, word, is_to_write=False)]

    return _offer(ctx, "signals", incomplete, offer)


def bus(ctx: typer.Context, incomplete: str) -> Offers:
    return _offer(ctx, "buses", incomplete, lambda rig, word, _: _status(rig)["buses"])


def part(ctx: typer.Context, incomplete: str) -> Offers:
    """Offer processes, and the buses and devices in them."""
    return _offer(ctx, "", incomplete, lambda rig, word, _: _parts(_status(rig)))


def ready_part(ctx: typer.Context, incomplete: str) -> Offers:
    """Offer the same, the whole rig and its control service, for `status --ready`."""
    return _offer(ctx, "", incomplete, lambda rig, word, _: ["all", "rig", *_parts(_status(rig))])


def faulty(ctx: typer.Context, incomplete: str) -> Offers:
    """Offer the buses and devices with faults for `fault`, and those with kinds of the user's own."""

    def offer(rig: "Client", word: str, before: list[str]) -> Iterable[str]:
        status = _status(rig)
        parts = {**status["buses"], **status["devices"]}
        return [name for name, entry in parts.items() if ":" in entry["kind"] or _fault_models(entry["kind"])]

    return _offer(ctx, "", incomplete, offer)


def fault_word(ctx: typer.Context, incomplete: str) -> Offers:
    """Offer the faults of the bus or device, then the keys of the chosen fault."""

    def offer(rig: "Client", word: str, before: list[str]) -> Iterable[str]:
        status = _status(rig)
        entry = {**status["buses"], **status["devices"]}.get(str(ctx.params.get("where")))
        models = _fault_models(entry["kind"]) if entry is not None else {}
        if not before:
            return models
        model = models.get(before[0].removeprefix("what="))
        if model is None or "=" in word or any("=" not in pair for pair in before[1:]):
            return ()
        given = {pair.partition("=")[0] for pair in before}
        return [f"{key}=" for key in model.model_fields if key not in {"what", *given}]

    return _offer(ctx, "words", incomplete, offer)


def _offer(
    ctx: typer.Context,
    parameter: str,
    incomplete: str,
    ask: Callable[["Client", str, list[str]], Iterable[str]],
) -> Offers:
    """Return the completions of the whole word, without the part that bash has split off; none without a rig.

    `ask` is called with the rig, the word, and the words of the same parameter before it.
    """
    from fieldrig.control.endpoint import is_answered
    from fieldrig.outside.addresses import DEFAULT_ENDPOINT

    *before, word = _joined([*(ctx.params.get(parameter) or ()), incomplete])
    endpoint = ctx.params.get("endpoint") or DEFAULT_ENDPOINT
    if not is_answered(endpoint):
        return []
    from fieldrig.control.messages import Client
    from fieldrig.errors import ControlError

    try:
        with Client(endpoint, PATIENCE_S) as rig:
            offered = [*ask(rig, word, before)]
    except ControlError:
        return []
    cut = len(word) - len(incomplete)
    return [offer[cut:] for offer in offered if offer.startswith(word)]


def _joined(words: Iterable[str]) -> list[str]:
    """Join the words that bash has split: `io/6200`, `:`, `01` become one word."""
    whole: list[str] = []
    goes_on = False
    for word in words:
        if whole and (goes_on or word in BREAKS):
            whole[-1] += word
        else:
            whole.append(word)
        goes_on = word in BREAKS
    return whole


def _status(rig: "Client") -> dict[str, Any]:
    status: dict[str, Any] = rig.ask("rig/status", timeout_s=PATIENCE_S)
    return status


def _points(rig: "Client", word: str, *, is_to_write: bool) -> list[str]:
    """Return devices, and the keys of a device once only one matches, as all keys together may be thousands."""
    name, slash, _ = word.partition("/")
    known = _status(rig)["devices"]
    devices = [device for device in known if device == name or (not slash and device.startswith(name))]
    if len(devices) != 1:
        return [f"{device}/" if is_to_write else device for device in devices]
    facts = rig.ask(f"device/{devices[0]}/keys", timeout_s=PATIENCE_S)
    ending = "=" if is_to_write else ""
    offered = [key for key, fact in facts.items() if fact.get("writable", True) or not is_to_write]
    keys = [f"{devices[0]}/{key}{ending}" for key in offered]
    return keys if slash or is_to_write else [devices[0], *keys]


def _wires(rig: "Client", bus: str) -> list[str]:
    from fieldrig.errors import ControlError

    with suppress(ControlError):  # the bus has no signals, or nothing answers for it
        return list(rig.ask(f"bus/{bus}/keys", timeout_s=PATIENCE_S))
    return []


def _parts(status: Mapping[str, Any]) -> list[str]:
    return list(dict.fromkeys([*status["processes"], *status["buses"], *status["devices"]]))


def _fault_models(kind: str) -> Mapping[str, Any]:
    from fieldrig.config.kinds import find_bus, find_device
    from fieldrig.errors import RigError
    from fieldrig.faults.power import models_of_device

    with suppress(RigError):
        return find_bus(kind).fault_models
    with suppress(RigError):
        return models_of_device(find_device(kind))
    return {}


def _in_folder(incomplete: str) -> list[str]:
    folder, slash, start = incomplete.replace(os.sep, "/").rpartition("/")
    paths = []
    with suppress(OSError):
        for path in sorted(Path(f"{folder}{slash}" or ".").expanduser().iterdir()):
            is_shown = path.name.startswith(start) and (start.startswith(".") or not path.name.startswith("."))
            if is_shown and (path.is_dir() or path.suffix in RIG_FILES):
                paths.append(f"{folder}{slash}{path.name}{'/' if path.is_dir() else ''}")
    return paths
