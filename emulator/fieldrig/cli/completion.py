"""What the shell offers for the word that is being typed: kinds, rig files, and what the running rig has.

Completion is silent: where no rig answers at once there is nothing to offer, and the shell falls back to file names.
"""

from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import typer

if TYPE_CHECKING:
    from fieldrig.control import Client

PATIENCE_S: Final = 1.0
"""A process that takes longer to answer is left out."""
RIG_FILES: Final = (".yaml", ".yml")
BREAKS: Final = (":", "=")
"""Characters at which bash splits a word, by its default COMP_WORDBREAKS; the parts come as words of their own."""

Offers = list[str | tuple[str, str]]
"""Words, or words with a line about each."""


def kind(incomplete: str) -> Offers:
    """The kinds of buses and devices that are installed; none of them is imported."""
    from fieldrig.kinds import BUSES, DEVICES, installed

    return [name for group in (BUSES, DEVICES) for name in installed(group) if name.startswith(incomplete)]


def rig_file(incomplete: str) -> Offers:
    """YAML files and folders; the content of a folder where nothing else fits, so that Tab goes on into it."""
    found = _in_folder(incomplete)
    while len(found) == 1 and found[0].endswith("/"):
        found = _in_folder(found[0])
    return [*found]


def point(ctx: typer.Context, incomplete: str) -> Offers:
    """`get`: devices, and the keys of one."""
    return _offer(ctx, "names", incomplete, lambda rig, word, _: _points(rig, word, is_to_write=False))


def setting(ctx: typer.Context, incomplete: str) -> Offers:
    """`set`: keys that can be written, up to the `=`."""

    def offer(rig: "Client", word: str, before: list[str]) -> Iterable[str]:
        is_value = "=" in word or any("=" not in one for one in before)  # bash cuts the = off
        return () if is_value else _points(rig, word, is_to_write=True)

    return _offer(ctx, "settings", incomplete, offer)


def watched(ctx: typer.Context, incomplete: str) -> Offers:
    """`watch`: buses, devices, and the keys of one."""

    def offer(rig: "Client", word: str, before: list[str]) -> Iterable[str]:
        buses = () if "/" in word else [bus for bus in _status(rig)["buses"] if bus.startswith(word)]
        return [*buses, *_points(rig, word, is_to_write=False)]

    return _offer(ctx, "patterns", incomplete, offer)


def bus(ctx: typer.Context, incomplete: str) -> Offers:
    return _offer(ctx, "buses", incomplete, lambda rig, word, _: _status(rig)["buses"])


def part(ctx: typer.Context, incomplete: str) -> Offers:
    """Processes, and the buses and devices in them."""
    return _offer(ctx, "", incomplete, lambda rig, word, _: _parts(_status(rig)))


def ready_part(ctx: typer.Context, incomplete: str) -> Offers:
    """`status --ready`: the same, the whole rig, its control service."""
    return _offer(ctx, "", incomplete, lambda rig, word, _: ["all", "rig", *_parts(_status(rig))])


def faulty(ctx: typer.Context, incomplete: str) -> Offers:
    """`fault`: buses and devices that take faults, and those of kinds of the user's own, which may."""

    def offer(rig: "Client", word: str, before: list[str]) -> Iterable[str]:
        status = _status(rig)
        parts = {**status["buses"], **status["devices"]}
        return [name for name, one in parts.items() if ":" in one["kind"] or _fault_models(one["kind"])]

    return _offer(ctx, "", incomplete, offer)


def fault_word(ctx: typer.Context, incomplete: str) -> Offers:
    """`fault BUS_OR_DEVICE`: what there is to break, then the keys of that fault."""

    def offer(rig: "Client", word: str, before: list[str]) -> Iterable[str]:
        status = _status(rig)
        one = {**status["buses"], **status["devices"]}.get(str(ctx.params.get("where")))
        models = _fault_models(one["kind"]) if one is not None else {}
        if not before:
            return models
        model = models.get(before[0].removeprefix("what="))
        if model is None or "=" in word or any("=" not in one for one in before[1:]):
            return ()
        given = {one.partition("=")[0] for one in before}
        return [f"{key}=" for key in model.model_fields if key not in {"what", *given}]

    return _offer(ctx, "words", incomplete, offer)


def _offer(
    ctx: typer.Context,
    parameter: str,
    incomplete: str,
    ask: Callable[["Client", str, list[str]], Iterable[str]],
) -> Offers:
    """What `ask` knows for the whole word, without what bash takes for words of their own; none without a rig.

    `ask` is called with the rig, the word, and the words of the same parameter before it.
    """
    from fieldrig.endpoint import is_answered
    from fieldrig.net import DEFAULT_ENDPOINT

    *before, word = _joined([*(ctx.params.get(parameter) or ()), incomplete])
    endpoint = ctx.params.get("endpoint") or DEFAULT_ENDPOINT
    if not is_answered(endpoint):
        return []
    from fieldrig.control import Client
    from fieldrig.errors import ControlError

    try:
        with Client(endpoint, PATIENCE_S) as rig:
            offered = [*ask(rig, word, before)]
    except ControlError:
        return []
    cut = len(word) - len(incomplete)
    return [one[cut:] for one in offered if one.startswith(word)]


def _joined(words: Iterable[str]) -> list[str]:
    """`io/6200`, `:`, `01` are one word."""
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
    """Devices; and the keys of a device once it is clear which one, for those of all may be thousands."""
    name, slash, _ = word.partition("/")
    devices = [one for one in _status(rig)["devices"] if one == name or (not slash and one.startswith(name))]
    if len(devices) != 1:
        return [f"{one}/" if is_to_write else one for one in devices]
    facts = rig.ask(f"device/{devices[0]}/keys", timeout_s=PATIENCE_S)
    ending = "=" if is_to_write else ""
    keys = [f"{devices[0]}/{key}{ending}" for key, one in facts.items() if one.get("writable", True) or not is_to_write]
    return keys if slash or is_to_write else [devices[0], *keys]


def _parts(status: Mapping[str, Any]) -> list[str]:
    return list(dict.fromkeys([*status["processes"], *status["buses"], *status["devices"]]))


def _fault_models(kind: str) -> Mapping[str, Any]:
    from fieldrig.errors import RigError
    from fieldrig.kinds import find_bus, find_device

    for find in (find_bus, find_device):
        with suppress(RigError):
            return find(kind).fault_models
    return {}


def _in_folder(incomplete: str) -> list[str]:
    folder, slash, start = incomplete.rpartition("/")
    found = []
    with suppress(OSError):
        for path in sorted(Path(f"{folder}{slash}" or ".").expanduser().iterdir()):
            is_shown = path.name.startswith(start) and (start.startswith(".") or not path.name.startswith("."))
            if is_shown and (path.is_dir() or path.suffix in RIG_FILES):
                found.append(f"{folder}{slash}{path.name}{'/' if path.is_dir() else ''}")
    return found
