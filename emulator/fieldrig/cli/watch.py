"""The command `watch`: see what happens in a running rig."""

import math
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fieldrig.cli import completion
from fieldrig.cli.common import AsJson, Count, Endpoint, For, argument, duration_ns, json_text
from fieldrig.cli.message_words import OfRig, Shower, shower_of
from fieldrig.cli.names import Parts, check_patterns
from fieldrig.cli.thinning import Line, thinned
from fieldrig.clock import S
from fieldrig.outside.addresses import DEFAULT_ENDPOINT
from fieldrig.points.values import counted
from fieldrig.system.exits import Exit
from fieldrig.text.digits import show_with_unit, with_fewer_digits

if TYPE_CHECKING:
    from fieldrig.control.messages import Client

POLL_S = 0.1
FACTS_S = 1.0
"""Time between two questions for the words about a late host: they cost a device more than its values do."""


def watch(
    patterns: Annotated[
        list[str] | None,
        argument("[PATTERN]...", "Buses, or points of devices in the form DEVICE/KEY.", completion.watched),
    ] = None,
    count: Count = None,
    duration: For = None,
    rig: OfRig = None,
    as_json: AsJson = False,
    endpoint: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Show messages or changes of values until Ctrl-C.

    \b
        fieldrig watch                        every bus, and the events of the rig; on busy buses some messages
        fieldrig watch '*'                    every message on every bus
        fieldrig watch can0                   one bus
        fieldrig watch can0 --rig lab.yaml    the same with the names of nodes, objects and registers
        fieldrig watch tank/level io/6200:*   values of devices, whenever they change
        fieldrig watch can0 -n 1 --json       one message, for a script

    A * matches any characters. Watching loads the rig only while it lasts. If fewer than N lines come in the time of
    --for, the exit code is 7.
    """
    from fieldrig.control.messages import Client

    is_everything = not patterns
    patterns = patterns or ["*"]
    points = [pattern for pattern in patterns if "/" in pattern]
    if points and len(points) < len(patterns):
        raise typer.BadParameter("watch either buses or points (with a /), not both at once")
    give_up_s = None if duration is None else time.monotonic() + duration_ns(duration) / S
    with Client(endpoint) as client:
        lines = _points(client, points) if points else _messages(client, patterns, rig)
        if is_everything and count is None and not as_json:
            lines = thinned(lines, len(client.ask("rig/status")["buses"]), time.monotonic)
        seen = _print(lines, count, give_up_s, as_json)
    if count is not None and duration is not None and seen is not None and seen < count:
        typer.echo(f"{seen} of {counted(count, 'line')} came within {duration}", err=True)
        raise typer.Exit(Exit.NOT_READY)


def _print(lines: Iterator[Line | None], count: int | None, give_up_s: float | None, as_json: bool) -> int | None:
    """Print lines until a limit; None is a moment without a message.

    Return how many were printed; None if a person has ended it.
    """
    seen = 0
    try:
        for line in lines:
            if give_up_s is not None and time.monotonic() > give_up_s:
                break
            if line is not None:
                typer.echo(json_text(line[1]) if as_json else line[0])
                seen += 1
                if seen == count:
                    break
    except KeyboardInterrupt:
        return None
    return seen


def _messages(client: "Client", patterns: list[str], rig: Path | None) -> Iterator[Line | None]:
    from fieldrig.control import events
    from fieldrig.control.notices import in_words, taken
    from fieldrig.traces.trace import is_batch

    parts = Parts(client)
    parts.check_buses(patterns)
    width = max(map(len, parts.buses))
    is_real = parts.status["time"] == "real"
    shower = None if rig is None else shower_of(rig)
    inbox = client.inbox(["watch/*" if shower is None else "trace/*", "event", "notice/*"])
    expected: dict[tuple[str, str], int] = {}
    for published in inbox:
        if published is None:
            yield None
        elif published[0] == "event":
            if (event := events.taken(published[1])) is not None:
                words = " ".join(filter(None, (event.process, events.in_words(event).partition("\n")[0])))
                yield f"{_time_of_day(round(event.time_s * S))}  -- {words}", {"event": event._asdict()}
        elif (notice := taken(published[1])) is not None:
            yield f"{_time_of_day(time.time_ns())}  -- {notice.part}: {in_words(notice)}", {"notice": notice._asdict()}
        elif any(fnmatchcase(published[0], pattern) for pattern in patterns) and is_batch(published[1]):
            bus, batch = published
            batch = batch if shower is None else _in_words(bus, batch, shower)
            yield from _of_batch(bus, batch, width, is_real, expected)


def _in_words(bus: str, batch: dict[str, Any], shower: Shower) -> dict[str, Any]:
    """Return a batch of data as one of texts."""
    from fieldrig.traces.trace import TraceEntry

    entries = [
        (time_ns, sender, shower(TraceEntry(time_ns, bus, batch["family"], sender, bytes.fromhex(data))))
        for time_ns, sender, data in batch["entries"]
    ]
    return {**batch, "entries": entries}


def _of_batch(
    bus: str, batch: dict[str, Any], width: int, is_real: bool, expected: dict[tuple[str, str], int]
) -> Iterator[Line]:
    source = (bus, batch["process"])
    lost = batch["first"] - expected.get(source, batch["first"])
    expected[source] = batch["first"] + len(batch["entries"])
    if lost:
        yield f"-- {counted(lost, 'message')} on {bus} lost: this terminal is too slow", {"lost": lost, "bus": bus}
    for time_ns, sender, text in batch["entries"]:
        instant_ns = time_ns + batch["epoch_ns"]
        shown = _time_of_day(instant_ns) if is_real else f"{instant_ns / S:14.6f}"
        data = {"time_ns": instant_ns, "bus": bus, "sender": sender, "message": text}
        yield f"{shown}  {bus:{width}}  {sender:12}  {with_fewer_digits(text)}", data


def _points(client: "Client", patterns: list[str]) -> Iterator[Line | None]:
    """Yield changes of points.  Devices are polled, as they report values only when asked."""
    from fieldrig.control.messages import NoAnswerError
    from fieldrig.control.troubles import LATER_NS

    parts = Parts(client)
    check_patterns((pattern.partition("/")[0] for pattern in patterns), parts.devices, f"{parts.rig} has no device")
    wanted = {
        device: [pattern.partition("/")[2] for pattern in patterns if fnmatchcase(device, pattern.partition("/")[0])]
        for device in parts.devices
    }
    watched = {device: keys for device, keys in wanted.items() if keys}
    units = _units(client, watched)
    if len(units) == len(watched):  # the keys of a device that does not answer are not known
        _check_keys(patterns, units)
    shown = {device: _Shown(keys, LATER_NS / S + FACTS_S) for device, keys in watched.items()}
    silent: set[str] = set()
    while True:
        started_s = time.monotonic()
        for device, its in shown.items():
            try:
                if device not in units or its.wants_facts(started_s):
                    units[device] = client.ask(f"device/{device}/keys")
                values = client.ask(f"device/{device}/get")
            except NoAnswerError as silence:  # it is being restarted, or hangs
                if device not in silent:
                    silent.add(device)
                    typer.echo(f"-- {silence.what}", err=True)
                yield None
                continue
            if device in silent:
                silent.remove(device)
                typer.echo(f"-- {device} answers again", err=True)
            for key in its.changed(values, units[device], started_s):
                yield _of_point(f"{device}/{key}", values[key], units[device].get(key, {}))
        yield None
        time.sleep(max(0.0, POLL_S - (time.monotonic() - started_s)))


class _Shown:
    """The values and words that were shown of one device."""

    def __init__(self, patterns: Iterable[str], later_s: float) -> None:
        """Words about a late host may come up to `later_s` after a change."""
        self._patterns, self._later_s = patterns, later_s
        self._present: dict[str, tuple[Any, str]] = {}
        """Value, and words about a late host, by key."""
        self._last_change_s = self._next_facts_s = -math.inf

    def wants_facts(self, now_s: float) -> bool:
        """Return whether the facts are to be asked for, because words about the host may have come."""
        is_due = self._next_facts_s <= now_s <= self._last_change_s + self._later_s
        if is_due:
            self._next_facts_s = now_s + FACTS_S
        return is_due

    def changed(self, values: Mapping[str, Any], facts: Mapping[str, Any], now_s: float) -> Iterator[str]:
        """Yield the keys that are to be shown: another value, or words beside the same one."""
        for key, value in values.items():
            words = facts.get(key, {}).get("host", "") if value else ""  # the facts may be older than the value
            before, words_before = self._present.get(key, (_missing, ""))
            if before == value and words in ("", words_before):
                continue
            if any(fnmatchcase(key, pattern) for pattern in self._patterns):
                self._present[key] = (value, words)
                if before != value:
                    self._last_change_s = now_s
                yield key


def _of_point(name: str, value: Any, fact: Mapping[str, Any]) -> Line:
    unit, now_ns = fact.get("unit", ""), time.time_ns()
    words = fact.get("host", "") if value else ""
    line = f"{_time_of_day(now_ns)}  {name} = {show_with_unit(value, unit)}"
    data = {"time_ns": now_ns, "point": name, "value": value, "unit": unit}
    return (f"{line} ({words})", data | {"host": words}) if words else (line, data)


def _units(client: "Client", devices: Iterable[str]) -> dict[str, Any]:
    """Return the facts of the points of each device that answers."""
    from fieldrig.control.messages import NoAnswerError

    units: dict[str, Any] = {}
    for device in devices:
        with suppress(NoAnswerError):
            units[device] = client.ask(f"device/{device}/keys")
    return units


def _check_keys(patterns: Iterable[str], units: Mapping[str, Mapping[str, Any]]) -> None:
    """ControlError for a pattern that fits no point."""
    for pattern in patterns:
        device = pattern.partition("/")[0]
        points = [f"{name}/{key}" for name, keys in units.items() if fnmatchcase(name, device) for key in keys]
        check_patterns([pattern], points, "there is no value")


_missing = object()


def _time_of_day(unix_ns: int) -> str:
    seconds, fraction_ns = divmod(unix_ns, S)
    return f"{time.strftime('%H:%M:%S', time.localtime(seconds))}.{fraction_ns // 1000:06}"
