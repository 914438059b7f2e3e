"""Plays one side of a log to a rig, and waits for its answers where the log shows them.

It is driven by a clock and by what the rig sends, so it is the same in virtual time and in real time.  A message of the
log is sent at its instant, later by as much as the rig has answered later than the log so far: a dialogue goes on when
the answer came, and what follows is shifted.  In a log of Modbus alone, an answer that comes earlier than in the log
makes up for that, and so do shorter pauses, so that values which move by themselves are those of the instants of the
log; where devices send by themselves, the instants of what they send would no longer be those expected.
"""

import struct
from collections import deque
from collections.abc import Callable, Iterator
from itertools import count
from typing import Any, Final

from fieldrig.clock import MS, NEVER_NS, Clock, S, Timer
from fieldrig.link import Link
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.acceptance import REMOTE
from fieldrig_bus.can.frame import STANDARD_MASK, CanFrame
from fieldrig_bus.modbus.codec import is_response, unit_in
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_devices.canopen.names import ERROR_CONTROL, LSS_MASTER, LSS_SLAVE, NODES
from fieldrig_devices.dialogues import ModbusDialogues, ModbusExchange
from fieldrig_devices.replay.first_requests import LONGEST_NS, FirstRequests
from fieldrig_devices.replay.gates import AnswerGate, ByteGate, FrameGate, Gate
from fieldrig_devices.replay.judge import Judge
from fieldrig_devices.replay.pace import Pace
from fieldrig_devices.replay.replay_result import ReplayResult
from fieldrig_devices.replay.schedule import Due

AHEAD_NS: Final = 500 * MS
"""How far before its instant an expected message of the log is read."""
EARLY_NS: Final = 100 * MS
"""How much earlier than the log a rig may send its first messages."""
LATEST_NS: Final = 60 * S
"""Longest wait for what may come late after the end of a log, whatever the tolerance is."""
SETTLED_NS: Final = S
"""Time between two looks at what can be decided."""
HEAD_OF_FRAME: Final = 5
ABORT: Final = struct.Struct("<B3sI")
ABORTED, TIMED_OUT = 0x80, 0x0504_0000
"""An abort of a client (CiA 301 version 4.2, 7.2.4.3.17 and table 22)."""
MOST_EXCHANGES: Final = 4_096

LinkOf = Callable[[str, str], Link[Any]]
"""Returns the end of a bus that plays a sender of the log, by sender and bus."""


class Player:
    """Plays a log.  The owner hands over what the rig sends, and is called at the end."""

    def __init__(
        self,
        dues: Iterator[Due],
        judge: Judge,
        pace: Pace,
        clock: Clock,
        now_ns: Callable[[], int],
        link_of: LinkOf,
        on_end: Callable[[], None],
        served: frozenset[int] = frozenset(),
    ) -> None:
        """`served` are the Modbus units whose answers are played."""
        self._dues, self._judge, self._pace = dues, judge, pace
        self._clock, self._now_ns, self._link_of, self._on_end = clock, now_ns, link_of, on_end
        self._result: ReplayResult = judge.result
        self._served = served
        self._next: Due | None = None
        self._shift_ns = 0
        self._caught_up = -1
        """The number of the message before which the pause was shortened last."""
        self._has_streams = False
        """True if devices of the log have sent something besides answers of Modbus."""
        self._last_ns = pace.begin_ns
        self._sent_ns = pace.begin_ns
        """The instant at which something was sent last."""
        self._timer: Timer | None = None
        self._gates: dict[tuple[str, str, int], Gate] = {}
        self._waiting_since_ns = NEVER_NS
        self._settle_ns = pace.begin_ns + SETTLED_NS
        self._numbers = count(1)
        self._exchanges = ModbusDialogues()
        self._exchange_of: dict[int, int] = {}
        self._first = FirstRequests(judge, pace.begin_ns + LONGEST_NS if pace.awaits_units else 0)
        self._asked: dict[tuple[str, int], deque[int]] = {}
        """The requests of the rig's clients that the log has to answer, by bus and unit."""
        self.is_ended = False
        judge.begin_ns, judge.first_ns, judge.timeout_ns = pace.begin_ns, pace.heard_ns, pace.timeout_ns

    def start(self) -> None:
        """Begin, at the instant of `Pace.begin_ns`."""
        self._next = next(self._dues, None)
        self._at(self._pace.begin_ns)

    # what the rig does

    def heard(self, entry: TraceEntry) -> None:
        """Take a message that a device of the rig has sent, with its instant."""
        if self.is_ended:
            return
        if entry.time_ns < self._pace.heard_ns - EARLY_NS:
            self._judge.unasked.sent_before(entry)
            return
        self._judge.heard(entry)
        if entry.family == "can":
            self._heard_frame(entry)
        elif entry.family == "serial" and entry.data[:1] == b"\0":
            self._bytes(entry.bus).heard(entry.time_ns, len(entry.data) - 1)
        self._go_on()

    def heard_own(self, entry: TraceEntry) -> None:
        """Take a message that was played, with the instant at which it arrived."""
        if not self.is_ended and entry.family == "can":
            self._judge.sdo.take_own(entry)

    def answered(self, bus: str, response: ModbusResponse, time_ns: int) -> None:
        """Take the answer of the rig to a request that was played."""
        self._judge.modbus.heard(response.exchange, response.pdu, time_ns)
        gate = self._gates.get((bus, "modbus", response.exchange))
        if isinstance(gate, AnswerGate):
            self._first.answered(response.exchange, 0 if gate.since_ns is None else time_ns - gate.since_ns)
            if gate.since_ns is not None and not self._has_streams:
                self._shift_ns -= min(self._shift_ns, max(gate.since_ns - time_ns, 0))
            gate.heard(time_ns)
        self._go_on()

    def asked(self, bus: str, request: ModbusRequest) -> None:
        """Take a request of the rig that the log has to answer."""
        waiting = self._asked.setdefault((bus, request.unit), deque(maxlen=MOST_EXCHANGES))
        waiting.append(request.exchange)
        gate = self._gates.get((bus, "server", request.unit))
        if isinstance(gate, AnswerGate):
            gate.heard(self._now_ns())
        self._go_on()

    # the log

    def _go_on(self) -> None:
        if self._waiting_since_ns != NEVER_NS and self._gate() is None:
            self._advance()

    def _advance(self) -> None:
        """Do everything that is due now, and set the timer to what is next."""
        now_ns = self._now_ns()
        if now_ns >= self._settle_ns and self._next is not None:  # after the end, `_end` decides everything
            self._settle_ns = now_ns + SETTLED_NS
            self._judge.settle(now_ns - AHEAD_NS)
        while (due := self._next) is not None:
            at_ns = self._instant(due.due_ns)
            if due.message is None:
                if at_ns - AHEAD_NS > now_ns:
                    self._at(at_ns - AHEAD_NS)
                    return
                self._expect(due, at_ns)
            else:
                if at_ns - AHEAD_NS > now_ns or not self._may_send(now_ns):
                    if self._waiting_since_ns == NEVER_NS:
                        self._at(at_ns - AHEAD_NS)
                    return
                self._catch_up(due, now_ns)
                at_ns = self._instant(due.due_ns)
                if at_ns > now_ns:
                    self._at(at_ns)
                    return
                self._play(due, now_ns)
            self._next = next(self._dues, None)
        if not self._may_send(now_ns):
            return
        end_ns = self._last_ns + min(self._judge.tolerances.time_ns, LATEST_NS) + MS
        if now_ns < end_ns:
            self._at(end_ns)
        else:
            self._end()

    def _may_send(self, now_ns: int) -> bool:
        """Return whether nothing is awaited; if something is, wait for it until its time-out."""
        gate = self._gate()
        while gate is not None:
            since_ns = gate.since_ns
            assert since_ns is not None
            until_ns = max(since_ns, self._sent_ns) + self._pace.timeout_ns  # this host may have sent late
            if now_ns < until_ns:
                self._waiting_since_ns = since_ns
                self._at(until_ns)
                return False
            if not self._ask_again(gate, now_ns):
                gate.give_up()
            gate = self._gate()
        if self._waiting_since_ns != NEVER_NS:
            self._judge.unasked.waited(self._waiting_since_ns, now_ns)
            self._shift_ns += max(0, now_ns - self._waiting_since_ns)
            self._waiting_since_ns = NEVER_NS
        for key in [key for key, each in self._gates.items() if isinstance(each, AnswerGate)]:
            del self._gates[key]
        return True

    def _ask_again(self, gate: Gate, now_ns: int) -> bool:
        """Send the first request to a unit again that has not booted; return False if the gate is of another one."""
        number = gate.number if isinstance(gate, AnswerGate) else 0
        asked = self._first.again(number, now_ns)
        if asked is None:
            return False
        self._judge.modbus.asked_again(number, now_ns)
        self._sent_ns = now_ns
        self._link_of(asked.sender, asked.bus).send(asked.request)
        return True

    def _gate(self) -> Gate | None:
        """Return the gate that has waited least, as the others are open by its time-out at the latest."""
        waiting = [gate for gate in self._gates.values() if gate.since_ns is not None]
        return max(waiting, key=lambda gate: gate.since_ns or 0) if waiting else None

    def _instant(self, log_ns: int) -> int:
        """Return the instant of the rig for one of the log."""
        since_ns = log_ns - self._pace.log_ns
        if self._pace.speed != 1.0:
            since_ns = round(since_ns / self._pace.speed)
        return self._pace.begin_ns + since_ns + self._shift_ns

    def _catch_up(self, due: Due, now_ns: int) -> None:
        """Shorten the pause before a message by half of it, at most, in a log of Modbus alone that is played late."""
        if self._shift_ns and not self._has_streams and due.number != self._caught_up:
            self._caught_up = due.number
            pause_ns = self._instant(due.due_ns) - now_ns
            self._shift_ns -= min(self._shift_ns, max(pause_ns // 2, 0))

    def _at(self, when_ns: int) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._timer = self._clock.call_at(max(when_ns, self._now_ns()), self._advance)

    def _end(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
        if self.is_ended:
            return
        self.is_ended = True
        self._result.shift_ns = self._shift_ns
        self._result.duration_ns = self._last_ns - self._pace.begin_ns
        self._judge.finish(self._last_ns)
        self._on_end()

    # expected

    def _expect(self, due: Due, at_ns: int) -> None:
        entry = TraceEntry(at_ns, due.entry.bus, due.entry.family, due.entry.sender, due.entry.data)
        self._last_ns = max(self._last_ns, at_ns)
        if entry.family == "modbus":
            self._expect_modbus(due, entry)
            return
        self._has_streams = True
        self._judge.expect(entry, due.due_ns)
        if entry.family == "can":
            self._expect_frame(entry)
        elif entry.family == "serial" and entry.data[:1] == b"\0":
            self._bytes(entry.bus).expect(at_ns, len(entry.data) - 1)

    def _expect_modbus(self, due: Due, entry: TraceEntry) -> None:
        for exchange in self._exchanges.take(due.number, entry):
            mine = self._exchange_of.pop(exchange.entries[0], None) if isinstance(exchange, ModbusExchange) else None
            if mine is None or not isinstance(exchange, ModbusExchange) or exchange.response is None:
                continue
            is_there = self._judge.modbus.is_answered(mine)
            self._judge.modbus.expect(mine, exchange.response, entry.time_ns, entry.time_ns - self._shift_ns)
            if not is_there:
                self._gates[entry.bus, "modbus", mine] = AnswerGate(entry.time_ns, mine)
        self._judge.expect(entry, due.due_ns)
        unit = unit_in(entry.data)
        if not is_response(entry.data) and unit in self._served and not self._asked.get((entry.bus, unit)):
            self._gates[entry.bus, "server", unit] = AnswerGate(entry.time_ns)

    def _expect_frame(self, entry: TraceEntry) -> None:
        gate = self._frames(entry)
        if gate is not None and len(entry.data) > HEAD_OF_FRAME:
            gate.expect(entry.time_ns, entry.data[HEAD_OF_FRAME])

    def _heard_frame(self, entry: TraceEntry) -> None:
        gate = self._frames(entry)
        if gate is not None and len(entry.data) > HEAD_OF_FRAME:
            gate.heard(entry.time_ns, entry.data[HEAD_OF_FRAME])

    def _frames(self, entry: TraceEntry) -> FrameGate | None:
        """Return the gate of a frame that is an answer; None for one that is no answer."""
        word = int.from_bytes(entry.data[:4], "little")
        end = self._judge.sdo.end_of(entry.bus, word)
        if end is not None:
            return self._frame_gate(entry.bus, "sdo", end.request_key)
        key = entry.bus, "asked", word & ~REMOTE
        found = self._gates.get(key)
        return found if isinstance(found, FrameGate) else None

    def _frame_gate(self, bus: str, what: str, number: int) -> FrameGate:
        gate = self._gates.get((bus, what, number))
        if not isinstance(gate, FrameGate):
            gate = self._gates[bus, what, number] = FrameGate()
        return gate

    def _bytes(self, bus: str) -> ByteGate:
        gate = self._gates.get((bus, "bytes", 0))
        if not isinstance(gate, ByteGate):
            gate = self._gates[bus, "bytes", 0] = ByteGate()
        return gate

    # played

    def _play(self, due: Due, now_ns: int) -> None:
        at_ns = now_ns + due.lead_ns
        entry = TraceEntry(at_ns, due.entry.bus, due.entry.family, due.entry.sender, due.entry.data)
        self._last_ns = max(self._last_ns, at_ns)
        message = due.message
        self._judge.buses.add(entry.bus)
        if entry.family == "can" and not self._begin_or_go_on(entry):
            return
        if isinstance(message, ModbusRequest):
            message = self._as_ours(due, message, at_ns)
        elif isinstance(message, ModbusResponse):
            waiting = self._asked.get((entry.bus, message.request.unit))
            if not waiting:
                self._result.note(f"unit {message.unit}: the rig did not ask for all answers of the log")
                return
            message = ModbusResponse(message.unit, message.pdu, waiting.popleft())
        self._result.played += 1
        self._sent_ns = now_ns
        self._link_of(entry.sender, entry.bus).send(message)

    def _as_ours(self, due: Due, request: ModbusRequest, at_ns: int) -> ModbusRequest:
        """Return a request with a number of our own, so that its answer is found."""
        number = next(self._numbers)
        self._exchange_of[due.number] = number
        if len(self._exchange_of) > MOST_EXCHANGES:
            del self._exchange_of[next(iter(self._exchange_of))]
        self._exchanges.take(due.number, due.entry)
        log_ns = self._instant(due.due_ns) - self._shift_ns + due.lead_ns
        self._judge.modbus.asked(number, due.entry.bus, request.unit, request.pdu, log_ns, at_ns)
        ours = ModbusRequest(request.unit, request.pdu, number)
        self._first.sent(due.entry.sender, due.entry.bus, ours)
        return ours

    def _begin_or_go_on(self, entry: TraceEntry) -> bool:
        """Return whether a frame is to be sent: one of a transfer that the rig has ended in another way is not."""
        word = int.from_bytes(entry.data[:4], "little")
        sdo = self._judge.sdo
        end = sdo.end_of(entry.bus, word)
        if end is None:
            self._judge.played(entry)
            if word & REMOTE and (word & ~REMOTE) - ERROR_CONTROL in NODES:
                self._gates[entry.bus, "asked", word & ~REMOTE] = FrameGate()
            elif word == LSS_MASTER:
                self._gates[entry.bus, "asked", LSS_SLAVE] = FrameGate()
            return True
        begins = sdo.take_log(entry)
        gate = self._frame_gate(entry.bus, "sdo", end.request_key)
        if begins:
            if gate.is_broken:
                self._give_up_transfer(entry, end.request_key)
            gate.begin()
        return not gate.is_broken

    def _give_up_transfer(self, entry: TraceEntry, request_key: int) -> None:
        """End a transfer with which the log cannot go on, as a client does that has no use for the answer."""
        left_open = self._judge.sdo.left_open(entry.bus, request_key)
        if left_open is not None:
            abort = CanFrame(request_key & STANDARD_MASK, ABORT.pack(ABORTED, left_open, TIMED_OUT))
            self._link_of(entry.sender, entry.bus).send(abort)
