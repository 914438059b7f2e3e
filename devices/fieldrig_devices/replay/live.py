"""A log played to a rig in real time: to the one that runs at the control endpoint, or to one that is started for it.

The host decides how exact that is: a message is sent when the timer of this process is served, and arrives when the
process of the bus has taken it.
"""

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, Final

from fieldrig.bus import Bus
from fieldrig.clock import MS, Clock, S
from fieldrig.config.rig_file import RigConfig
from fieldrig.errors import UsageError
from fieldrig.hub.tool_member import OnEnd, join_all
from fieldrig.link import Link
from fieldrig.real.running_rig import running
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_devices.replay.families import OUTER
from fieldrig_devices.replay.judge import Judge
from fieldrig_devices.replay.opening import Opening
from fieldrig_devices.replay.pace import Pace
from fieldrig_devices.replay.player import Player
from fieldrig_devices.replay.schedule import schedule
from fieldrig_devices.replay.sides import Sides

MEMBER: Final = "replay"
LEAD_NS: Final = 200 * MS
"""Time until the log begins, in which the links become ready."""
SILENT_NS: Final = S
"""Time after which a node of which nothing was heard is asked, as it may run for long."""
FAMILIES: Final = OUTER | {"wires"}
"""Families to which a log can be played in real time.  Wires have no sender there, so they are not compared."""

Begin = Callable[[int], tuple[Iterable[TraceEntry], Pace]]
"""Returns the log and its pace, for the instant at which it may begin."""


def play(begin: Begin, config: RigConfig, sides: Sides, judge: Judge) -> None:
    """Play a log in real time.  BusError, RigError or UsageError if the rig does not run and cannot be started."""
    buses = {name: entry.bus for name, entry in config.buses.items() if entry.bus.family in FAMILIES}
    for name, bus in buses.items():  # reading files would make the first messages late
        sides.bus_of(TraceEntry(0, name, bus.family, "", b""))
        for side in (0, 1):
            judge.names[side].prepare(name, bus.family)
    if config.time != "real":
        raise UsageError(f"{config.name} has virtual time", "leave out --real and --speed, or --set time=real")
    with running(config) as rig:
        run = Path(rig.status()["run"])
        join_all(list(buses.values()), run, MEMBER, _Performance(begin, sides, judge, buses).start)


class _Performance:
    """One log played to the ends of the buses."""

    def __init__(self, begin: Begin, sides: Sides, judge: Judge, buses: Mapping[str, Bus[Any]]) -> None:
        self._begin, self._sides, self._judge, self._buses = begin, sides, judge, buses

    def start(self, clock: Clock, links: Mapping[str, Link[Any]], on_end: OnEnd) -> None:
        log, pace = self._begin(clock.now_ns() + LEAD_NS)
        dues = schedule(log, self._sides, self._buses, self._judge.result, OUTER)
        own = {name: _OwnLink(link, self._buses[name], clock) for name, link in links.items()}
        served = self._sides.selection.units

        def player_of(pace: Pace) -> Player:
            return Player(
                dues, self._judge, pace, clock, clock.now_ns, lambda _, bus: own[bus], lambda: on_end(None), served
            )

        player = Opening(
            player_of, pace, self._sides, self._judge, clock, clock.now_ns, lambda _, bus: own[bus], SILENT_NS
        )
        for name, link in links.items():
            own[name].player = player
            self._listen(player, name, link, clock)
        player.start()

    def _listen(self, player: Opening, name: str, link: Link[Any], clock: Clock) -> None:
        bus = self._buses[name]

        def hear(message: Any) -> None:
            if isinstance(message, ModbusResponse):
                player.answered(name, message, clock.now_ns())
            elif isinstance(message, ModbusRequest):
                player.asked(name, message)
            elif bus.family in OUTER:
                player.heard(TraceEntry(clock.now_ns(), name, bus.family, "", bus.encode(message)))

        link.on_receive(hear, sorted(self._sides.selection.units) if bus.family == "modbus" else None)


class _OwnLink:
    """An end that plays: what it sends has arrived, as far as this process knows."""

    player: Opening

    def __init__(self, link: Link[Any], bus: Bus[Any], clock: Clock) -> None:
        self._link, self._bus, self._clock = link, bus, clock

    def send(self, message: Any) -> None:
        self.player.heard_own(
            TraceEntry(self._clock.now_ns(), self._bus.name, self._bus.family, MEMBER, self._bus.encode(message))
        )
        self._link.send(message)

    def on_receive(self, handler: Callable[[Any], None], interest: Any = None) -> None:
        """Do nothing, as the end is listened to itself."""
