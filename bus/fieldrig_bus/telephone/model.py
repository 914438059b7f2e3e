"""The telephone network as a function of time: an exchange, its lines, and the carriers of modems between them.

A member that seizes its line hears the dial tone and dials; the called line rings in the cadence of the network until
its member seizes it or the caller hangs up.  Then what modems say to each other passes after the delay of the network,
and their data at the rate of their carriers.  The tones of the exchange take no time.
Left out: speech, charges, and a limit for how long a call may ring.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from random import Random
from typing import Any, Final, cast

from fieldrig.bus import BusModel, Delivery
from fieldrig.clock import MS
from fieldrig.faults import faults
from fieldrig.faults.note import FaultNote
from fieldrig.text.nearest import closest
from fieldrig_bus.telephone.agenda import Agenda, Deliveries
from fieldrig_bus.telephone.faults import (
    MODELS,
    Busy,
    Cut,
    Delay,
    LineFaults,
    NoDialTone,
    NoRinging,
    Slow,
    TelephoneFault,
)
from fieldrig_bus.telephone.lines import EVERYTHING, Call, Line, Network
from fieldrig_bus.telephone.message import (
    KINDS,
    Carrier,
    Dial,
    Heard,
    Hook,
    Offer,
    Ready,
    Ring,
    TelephoneMessage,
    Tone,
    check_interest,
)
from fieldrig_bus.telephone.numbering import Numbering
from fieldrig_bus.telephone.transmitter import Transmitter

EXCHANGE: Final = "exchange"
"""The sender of tones and ringing in traces."""
CHUNK_NS: Final = 5 * MS


class TelephoneModel(BusModel[TelephoneMessage]):
    def __init__(self, network: Network) -> None:
        self._network = network
        self._lines: dict[str, Line] = {}
        self._numbering = Numbering(network.numbers, network.outside_prefix)
        self._agenda = Agenda()
        self._faults = LineFaults()
        self._planned: set[int] = set()
        self._arrived: list[Delivery[TelephoneMessage]] = []
        """Deliveries that a late host has not collected before the next message came."""
        self._calls_made = self._characters = 0

    def begin(self, now_ns: int, random: Random) -> None:
        self._faults, self._agenda.passed_ns = LineFaults(random), now_ns
        for fault in self._network.faults:
            self._faults.add(now_ns, fault)
        self._apply_faults(now_ns)

    def join(self, member: str) -> None:
        number = self._network.numbers.get(member, "")
        self._lines[member] = Line(member, number, Transmitter(CHUNK_NS, self._network.is_paced))

    def leave(self, member: str) -> None:
        line = self._lines.pop(member)
        self._end_call(self._agenda.passed_ns, line)

    def listen(self, now_ns: int, member: str, interest: Sequence[Any] | None) -> None:
        check_interest(interest)
        self._lines[member].interest = EVERYTHING if interest is None else frozenset(interest)

    def submit(self, now_ns: int, member: str, message: TelephoneMessage) -> None:
        line, now_ns = self._lines[member], max(now_ns, self._agenda.passed_ns)
        self._go_on_to(now_ns - 1)
        if type(message) is bytes:
            self._characters += len(message)
            if not line.transmitter.put(now_ns, message):
                self._lose_call(now_ns, line)  # as V.42 gives a link up after too many repetitions
            return
        if not (isinstance(message, Hook) and message.is_off is line.is_off):
            self._agenda.at(now_ns, lambda _: [Delivery(now_ns, member, message, ())])  # for the trace
        match message:
            case Hook(is_off=True):
                self._seize(now_ns, line)
            case Hook():
                self._release(now_ns, line)
            case Dial(digits=digits):
                self._dial(now_ns, line, digits)
            case Offer():
                quality_bps = self._quality_bps(now_ns, line)
                self._pass_on(now_ns, line, replace(message, line_bps=min(message.line_bps, quality_bps)))
            case Carrier():
                self._begin_carrier(now_ns, line, replace(message, is_paced=self._network.is_paced))
            case Ready():
                self._pass_on(now_ns, line, message)

    def next_ns(self) -> int | None:
        return self._arrived[0].time_ns if self._arrived else self._next_event_ns()

    def collect(self, now_ns: int) -> list[Delivery[TelephoneMessage]]:
        self._go_on_to(now_ns)
        arrived, self._arrived = self._arrived, []
        return arrived

    def _next_event_ns(self) -> int | None:
        next_ns = self._agenda.next_ns()
        for line in self._lines.values():
            line_ns = line.transmitter.next_ns()
            if line_ns is not None and (next_ns is None or line_ns < next_ns):
                next_ns = line_ns
        return next_ns

    def _go_on_to(self, now_ns: int) -> None:
        """Let happen what is due by now, so that a message finds the network as it is then, even on a late host."""
        while (next_ns := self._next_event_ns()) is not None and next_ns <= now_ns:
            self._agenda.passed_ns = max(self._agenda.passed_ns, next_ns)
            for line in self._lines.values():
                for done_ns, chunk in line.transmitter.take(next_ns):
                    self._send(done_ns, line, chunk)
            self._arrived += self._agenda.take(next_ns)

    def statistics(self, now_ns: int) -> dict[str, float]:
        calls = {id(line.call) for line in self._lines.values() if line.call is not None}
        counts = {"calls": self._calls_made, "calls at present": len(calls), "characters": self._characters}
        return {name: float(count) for name, count in counts.items()}

    # ---- the exchange

    def _seize(self, now_ns: int, line: Line) -> None:
        if line.is_off:
            return
        line.is_off, line.digits = True, ""
        call = line.call
        if call is not None:
            call.is_ringing, call.is_answered = False, True
            call.is_silent = self._faults.is_silent(now_ns, *call.members)
            self._tell(now_ns, line, Ring(False, call.caller.number))
            self._tell(now_ns, call.caller, Heard(Tone.SILENCE))
        elif self._has_no_tone(now_ns, line):
            line.waits_for_tone = True
        else:
            self._give_tone(now_ns, line)

    def _has_no_tone(self, now_ns: int, line: Line) -> bool:
        return any(self._faults.has(now_ns, model, line.member) for model in (Cut, NoDialTone))

    def _give_tone(self, now_ns: int, line: Line) -> None:
        line.has_dial_tone, line.waits_for_tone = True, False
        self._tell(now_ns, line, Heard(Tone.DIAL))

    def _release(self, now_ns: int, line: Line) -> None:
        if line.is_off:
            self._end_call(now_ns, line)
            line.is_off = line.has_dial_tone = line.waits_for_tone = False

    def _end_call(self, now_ns: int, line: Line) -> None:
        """End the call of a line that hangs up or is cut."""
        call = line.call
        if call is None:
            return
        other = call.other(line)
        call.over_ns = now_ns + (self._delay_ns(now_ns, call) if call.is_answered else 0)
        for end in (line, other):
            end.call = None
            end.carrier = Carrier(0)
            end.transmitter.start(now_ns, end.carrier)
        if not call.is_answered:
            self._tell(now_ns, call.called, Ring(False, call.caller.number))
        if other.is_off:
            self._tell(call.over_ns, other, Heard(Tone.BUSY))

    def _lose_call(self, now_ns: int, line: Line) -> None:
        """End the call of a line that is still seized."""
        if line.call is not None:
            self._end_call(now_ns, line)
            self._tell(now_ns, line, Carrier(0))

    def _dial(self, now_ns: int, line: Line, digits: str) -> None:
        if not line.is_off or not line.has_dial_tone:
            return
        line.digits += digits
        meaning = self._numbering.meaning(line.digits)
        called = None if isinstance(meaning, Tone) else self._lines.get(meaning)
        line.has_dial_tone = meaning in (Tone.DIAL, Tone.SILENCE)  # more digits may follow
        if called is not None:
            self._call(now_ns, line, called)
        else:
            self._tell(now_ns, line, Heard(meaning if isinstance(meaning, Tone) else Tone.SILENCE))

    def _call(self, now_ns: int, caller: Line, called: Line) -> None:
        self._calls_made += 1
        is_busy = called.is_off or called.call is not None or self._faults.has(now_ns, Busy, called.member)
        self._tell(now_ns, caller, Heard(Tone.BUSY if is_busy else Tone.RINGING))
        if is_busy or any(self._faults.has(now_ns, model, called.member) for model in (Cut, NoRinging)):
            return
        caller.call = called.call = call = Call(caller, called, is_ringing=True)
        self._agenda.at(now_ns, lambda when_ns: self._ring(when_ns, call, True))

    def _ring(self, now_ns: int, call: Call, is_on: bool) -> Iterator[Delivery[TelephoneMessage]]:
        if call.is_ringing and call.called.call is call:
            network = self._network
            pause_ns = network.ring_on_ns if is_on else network.ring_off_ns
            self._agenda.at(now_ns + pause_ns, lambda when_ns: self._ring(when_ns, call, not is_on))
            yield self._delivery(now_ns, EXCHANGE, Ring(is_on, call.caller.number), call.called)

    # ---- carriers and data

    def _begin_carrier(self, now_ns: int, line: Line, carrier: Carrier) -> None:
        if line.call is not None and line.call.is_answered:
            line.carrier = carrier
            line.transmitter.start(now_ns, carrier)
            if not line.call.is_silent:
                self._pass_on(now_ns, line, carrier)

    def _pass_on(self, now_ns: int, line: Line, message: TelephoneMessage) -> None:
        """Deliver what a modem says to the modem at the other end, unless the call ends before it arrives."""
        call = line.call
        if call is None or not call.is_answered:
            return
        other = call.other(line)
        is_lost = call.is_silent and not isinstance(message, Ready | bytes)

        def arrive(when_ns: int) -> Iterator[Delivery[TelephoneMessage]]:
            if when_ns <= call.over_ns and other.call in (call, None) and not is_lost:
                yield self._delivery(when_ns, line.member, message, other)

        line.heard_ns = max(line.heard_ns, now_ns + self._delay_ns(now_ns, call))
        self._agenda.at(line.heard_ns, arrive)

    def _send(self, now_ns: int, line: Line, chunk: bytes) -> None:
        """Send what has left a transmitter.  Modems that correct errors repeat what a drop-out or noise has hit."""
        call = line.call
        if call is None:
            return
        heard = b"" if call.is_silent else self._faults.with_noise(now_ns, chunk, *call.members)
        if line.carrier.is_corrected and heard != chunk:
            line.transmitter.repeat(chunk, max(2 * self._delay_ns(now_ns, call), MS))
        elif heard:
            self._pass_on(now_ns, line, heard)

    def _delay_ns(self, now_ns: int, call: Call) -> int:
        added = [fault.delay_ms for fault in self._faults.active(now_ns, Delay, *call.members)]
        return self._network.delay_ns + round(float(sum(added)) * MS)

    def _quality_bps(self, now_ns: int, line: Line) -> int:
        members = [line.member] if line.call is None else [line.member, line.call.other(line).member]
        slow: list[int] = [fault.highest_bps for fault in self._faults.active(now_ns, Slow, *members)]
        return min([self._network.highest_bps, *slow])

    # ---- faults

    def add_fault(self, now_ns: int, fault: Mapping[str, Any]) -> int:
        settings = cast(TelephoneFault, faults.fault_of(fault, MODELS))
        if settings.line is not None and settings.line not in self._lines:
            raise ValueError(f"there is no line of {settings.line!r}\n{closest(settings.line, list(self._lines))}")
        number = self._faults.add(now_ns, settings).number
        self._apply_faults(max(now_ns, self._agenda.passed_ns))
        return number

    def begin_fault(self, now_ns: int, number: int) -> None:
        self._faults.release(now_ns, number)
        self._apply_faults(max(now_ns, self._agenda.passed_ns))

    def clear_fault(self, now_ns: int, number: int) -> None:
        self._faults.clear(number)
        self._apply_faults(max(now_ns, self._agenda.passed_ns))

    def all_faults(self, now_ns: int) -> dict[int, dict[str, Any]]:
        return self._faults.about(now_ns)

    def _apply_faults(self, now_ns: int) -> None:
        """End the calls of lines that are cut now, take and give dial tones, and hide or show the carriers of calls.

        A line that is seized while it has no tone gets one when the exchange is back, which then sees it seized.
        """
        for line in self._lines.values():
            if self._has_no_tone(now_ns, line):
                self._take_tone(now_ns, line)
            elif line.waits_for_tone:
                self._give_tone(now_ns, line)
        for call in {id(line.call): line.call for line in self._lines.values()}.values():
            if call is not None and call.is_answered:
                self._hide(now_ns, call, self._faults.is_silent(now_ns, *call.members))
        for fault in self._faults:
            if fault.is_on(now_ns) and not fault.applied:  # it counts once, as a state
                self._note(now_ns, fault)
        self._plan_faults(now_ns)

    def _note(self, now_ns: int, fault: faults.Fault[Any]) -> None:
        fault.applied = 1
        note = FaultNote(fault.number, fault.settings.what)
        self._agenda.at(now_ns, lambda _: [Delivery[Any](now_ns, fault.settings.line or EXCHANGE, note, ())])

    def _take_tone(self, now_ns: int, line: Line) -> None:
        if line.has_dial_tone:
            self._tell(now_ns, line, Heard(Tone.SILENCE))
            line.has_dial_tone, line.waits_for_tone, line.digits = False, True, ""
        if self._faults.has(now_ns, Cut, line.member):
            line.waits_for_tone |= line.is_off
            self._lose_call(now_ns, line)

    def _hide(self, now_ns: int, call: Call, is_silent: bool) -> None:
        if is_silent is not call.is_silent:
            call.is_silent = is_silent
            for line in (call.caller, call.called):
                if line.carrier.bps:
                    self._tell(now_ns, call.other(line), Carrier(0) if is_silent else line.carrier)

    def _plan_faults(self, now_ns: int) -> None:
        next_ns = self._faults.next_change_ns(now_ns)
        if next_ns is not None and next_ns not in self._planned:
            self._planned.add(next_ns)
            self._agenda.at(next_ns, self._on_fault_due)

    def _on_fault_due(self, now_ns: int) -> Deliveries:
        self._planned.discard(now_ns)
        self._apply_faults(now_ns)
        return ()

    # ---- deliveries

    def _tell(self, now_ns: int, line: Line, message: TelephoneMessage) -> None:
        self._agenda.at(now_ns, lambda when_ns: [self._delivery(when_ns, EXCHANGE, message, line)])

    def _delivery(self, now_ns: int, sender: str, message: TelephoneMessage, line: Line) -> Delivery[TelephoneMessage]:
        is_wanted = self._lines.get(line.member) is line and KINDS[type(message)] in line.interest
        return Delivery(now_ns, sender, message, (line.member,) if is_wanted else ())
