"""The time before a log is played: the nodes that are on when it begins have to boot in the rig, which was off.

A node has booted when anything of it is heard (CiA 301, 7.3.2.2.3: its boot-up message is the first).  One that answers
SDOs in the log has to answer here too, so it is asked for its device type, an object that every node has.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Final

from fieldrig.clock import MS, Clock, S
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_devices.canopen.names import SDO_REQUEST, SDO_RESPONSE
from fieldrig_devices.replay.judge import Judge
from fieldrig_devices.replay.pace import Pace
from fieldrig_devices.replay.player import EARLY_NS, LinkOf, Player
from fieldrig_devices.replay.sides import Sides
from fieldrig_devices.replay.words import time_words

LONGEST_NS: Final = 60 * S
"""The longest time for which the rig is waited for."""
ASKED_BEFORE_NS: Final = 500 * MS
"""How long before it has to be ready a node is asked."""
AFTER_NS: Final = 200 * MS
"""Time between the boot-up of a node that was late and the first message of the log."""
ASKED_NS: Final = 250 * MS
"""Time between two questions."""
READ_DEVICE_TYPE: Final = bytes.fromhex("40 00 10 00 00 00 00 00")
"""Read 1000h:00 (CiA 301, 7.2.4.3.5 and 7.5.2.1)."""
MOST_EARLY: Final = 100_000


class Opening:
    """Waits until the nodes have booted, and then begins the player.  The owner hands over what the rig sends."""

    def __init__(
        self,
        player_of: Callable[[Pace], Player],
        pace: Pace,
        sides: Sides,
        judge: Judge,
        clock: Clock,
        now_ns: Callable[[], int],
        link_of: LinkOf,
        silent_ns: int,
    ) -> None:
        """`player_of` makes the player when it begins.

        A node that was not heard for `silent_ns` is asked nevertheless: it may have been on before this end of the bus.
        """
        self._player_of, self._pace, self._sides, self._judge = player_of, pace, sides, judge
        self._clock, self._now_ns, self._link_of, self._silent_ns = clock, now_ns, link_of, silent_ns
        self._unheard = {(each.bus, each.node): None for each in pace.awaited}
        self._unanswered = {(each.bus, each.node): None for each in pace.awaited if each.answers}
        self._asks = pace.heard_ns - pace.ready_ns >= AFTER_NS
        """False if the log begins with the rig, and nothing of it is late: an answer would take time."""
        self._late: dict[tuple[str, int], None] = {}
        """The nodes that have not booted when the log would have begun."""
        self._heard = deque[TraceEntry](maxlen=MOST_EARLY)
        """The last messages of the rig, which may be early ones of those that the log has."""
        self._asked = deque[Callable[[Player], None]](maxlen=MOST_EARLY)
        self._player: Player | None = None

    def start(self) -> None:
        """Begin to wait."""
        if self._unheard:
            self._clock.call_at(max(self._pace.ready_ns - ASKED_BEFORE_NS, self._now_ns()), self._look)
        else:
            self._begin()

    @property
    def is_ended(self) -> bool:
        """True when the log was played."""
        return self._player is not None and self._player.is_ended

    def heard(self, entry: TraceEntry) -> None:
        """Take a message that a device of the rig has sent, with its instant."""
        if self._player is not None:
            self._player.heard(entry)
            return
        while self._heard and self._heard[0].time_ns < entry.time_ns - EARLY_NS:
            self._judge.unasked.sent_before(self._heard.popleft())
        self._heard.append(entry)
        if self._is_waiting and entry.family == "can":
            self._hear(entry)

    def heard_own(self, entry: TraceEntry) -> None:
        """Take a message that was played, with the instant at which it arrived."""
        if self._player is not None:
            self._player.heard_own(entry)

    def answered(self, bus: str, response: ModbusResponse, time_ns: int) -> None:
        """Take the answer of the rig to a request that was played."""
        if self._player is not None:
            self._player.answered(bus, response, time_ns)

    def asked(self, bus: str, request: ModbusRequest) -> None:
        """Take a request of the rig that the log has to answer."""
        if self._player is not None:
            self._player.asked(bus, request)
        else:
            self._asked.append(partial(Player.asked, bus=bus, request=request))

    @property
    def _is_waiting(self) -> bool:
        return bool(self._unheard or (self._asks and self._unanswered))

    def _hear(self, entry: TraceEntry) -> None:
        node = self._sides.sending_node(entry)
        if node is None:
            return
        self._unheard.pop((entry.bus, node), None)
        if int.from_bytes(entry.data[:4], "little") == SDO_RESPONSE + node:
            self._unanswered.pop((entry.bus, node), None)
        if not self._is_waiting and self._now_ns() >= self._pace.ready_ns:
            self._clock.call_at(self._now_ns(), self._look)

    def _look(self) -> None:
        if self._player is not None:
            return
        now_ns, ready_ns = self._now_ns(), self._pace.ready_ns
        if now_ns >= ready_ns:
            if not self._is_waiting or now_ns >= ready_ns + LONGEST_NS:
                self._begin()
                return
            self._asks |= now_ns >= ready_ns + MS
            self._late.update(self._unheard | (self._unanswered if self._asks else {}))
        asked = [each for each in self._unanswered if each not in self._unheard] if self._asks else []
        if now_ns >= ready_ns + self._silent_ns:
            asked += self._unheard
        for bus, node in asked:
            self._link_of("", bus).send(CanFrame(SDO_REQUEST + node, READ_DEVICE_TYPE))
        again_ns = now_ns + ASKED_NS
        self._clock.call_at(min(again_ns, ready_ns) if now_ns < ready_ns else again_ns, self._look)

    def _begin(self) -> None:
        pace = self._pace
        if self._late:
            late_ns = self._now_ns() - pace.ready_ns
            if late_ns >= MS:  # a machine that was on has booted for longer
                late_ns += max(0, AFTER_NS - (pace.heard_ns - pace.ready_ns))
            pace = replace(pace, begin_ns=pace.begin_ns + late_ns, heard_ns=pace.heard_ns + late_ns)
            self._judge.was_on = True
            self._tell(late_ns)
        self._player = self._player_of(pace)
        self._player.start()
        for entry in self._heard:
            self._player.heard(entry)
        for ask in self._asked:
            ask(self._player)

    def _tell(self, late_ns: int) -> None:
        missing = self._unheard | (self._unanswered if self._asks else {})
        booted = [self._judge.node(*each) for each in self._late if each not in missing]
        if booted and late_ns >= MS:  # the time of a boot-up message on the bus is not worth a word
            words = f"the log was held back for {time_words(late_ns)}, until {', '.join(booted)} had booted"
            self._judge.result.note(words)
        for bus, node in missing:
            did = "sent nothing" if (bus, node) in self._unheard else "did not answer"
            words = f"{self._judge.node(bus, node)} {did} in {time_words(LONGEST_NS)}, so the log began without it"
            self._judge.result.note(words)
