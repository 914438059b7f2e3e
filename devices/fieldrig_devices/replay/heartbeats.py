"""Heartbeats of the rig compared with those of a log: states with their instants, and the period.

Source: CiA 301 version 4.2, 7.2.8.3.2.2.
"""

from dataclasses import dataclass, field
from typing import Final

from fieldrig.traces.trace import TraceEntry
from fieldrig_devices.canopen.names import NMT_STATES
from fieldrig_devices.replay.gaps import Gaps
from fieldrig_devices.replay.grounds import Grounds
from fieldrig_devices.replay.replay_result import Difference, What
from fieldrig_devices.replay.words import late_words, time_words

STATE: Final = 0x7F
BOOT_UP: Final = 0
MOST_STATES: Final = 10_000
UNEVEN: Final = 0.1
"""Part of a period by which that of another device may differ, beside the tolerance."""


@dataclass(slots=True)
class _Side:
    states: list[tuple[int, int]] = field(default_factory=list)
    """The instants of the changes, and the states."""
    gaps: Gaps = field(default_factory=Gaps)
    boot_ns: int | None = None
    from_boot_ns: int = 0

    def take(self, time_ns: int, own_ns: int, state: int) -> None:
        if (not self.states or self.states[-1][1] != state) and len(self.states) < MOST_STATES:
            self.states.append((time_ns, state))
        if state == BOOT_UP:
            self.boot_ns, self.gaps.last_ns = own_ns, None  # the period begins with the first heartbeat
            return
        if self.boot_ns is not None and self.gaps.last_ns is None:
            self.from_boot_ns = own_ns - self.boot_ns
        self.gaps.take(time_ns, own_ns)

    @property
    def period_ns(self) -> int:
        """The period; that from the boot-up to a single heartbeat says it too, and 0 without one."""
        return self.gaps.period_ns or self.from_boot_ns


class Heartbeats:
    """The error control messages of all nodes, of the log and of the rig."""

    def __init__(self, grounds: Grounds) -> None:
        self._grounds = grounds
        self._nodes: dict[tuple[str, int], tuple[_Side, _Side]] = {}

    def take(self, side: int, node_id: int, entry: TraceEntry, own_ns: int) -> None:
        """Take a heartbeat; `own_ns` is its instant by the clock of its own side, which periods go by."""
        sides = self._nodes.setdefault((entry.bus, node_id), (_Side(), _Side()))
        sides[side].take(entry.time_ns, own_ns, entry.data[-1] & STATE)

    def finish(self, end_ns: int) -> None:
        for (bus, node_id), (log, rig) in self._nodes.items():
            node = self._grounds.node(bus, node_id)
            if bus not in self._grounds.buses:
                continue
            if self._grounds.tolerances.is_left_out(node, f"{0x700 + node_id:03X}", "heartbeat"):
                continue
            self._grounds.compared(bus, node, "heartbeat")
            if not log.states and all(state == BOOT_UP for _, state in rig.states):
                # a node must send one (CiA 301), and the log of one that was on before cannot show it
                self._grounds.result.note(f"{node} sent a boot-up, and the log has no error control of it")
            elif not log.states:
                self._add(What.MORE, rig.states[0][0], bus, node, f"{node} sent heartbeats, and the log has none of it")
            elif log.period_ns and not rig.period_ns and len(rig.states) <= 1:
                words = f"{node} sent no heartbeat, the log has one every {time_words(log.period_ns)}"
                self._add(What.MISSING, log.states[0][0], bus, node, words)
            elif not rig.states:
                self._add(What.MISSING, log.states[0][0], bus, node, f"{node} sent no heartbeat")
            else:
                self._states(bus, node, log, rig, end_ns)
                self._periods(bus, node, log, rig)

    def _states(self, bus: str, node: str, log: _Side, rig: _Side, end_ns: int) -> None:
        period_ns = max(log.period_ns, rig.period_ns)
        came = [each for each in rig.states if each[0] <= end_ns]
        states = log.states
        if states[0][1] != BOOT_UP and len(came) > 1 and came[0][1] == BOOT_UP:
            self._grounds.result.note(f"{node} sent a boot-up, and it was on before the log began")
            del came[0]
        if self._grounds.was_on and states[0][1] == 0 and (not came or came[0][1]):
            states = states[1:]  # the rig booted before the log began
        while self._grounds.was_on and states and len(came) > 1 and came[0][1] != states[0][1] and came[0] < states[0]:
            del came[0]  # the log's first heartbeat was later
        for place, (at_ns, state) in enumerate(states):
            name = NMT_STATES.get(state, f"state {state}")
            if place >= len(came):
                if at_ns + period_ns <= end_ns:
                    self._add(What.MISSING, at_ns, bus, node, f"{node} did not become {name}")
                return
            rig_ns, rig_state = came[place]
            if rig_state != state:
                was = NMT_STATES.get(rig_state, f"state {rig_state}")
                self._add(What.OTHER, at_ns, bus, node, f"{node} was {was} by its heartbeat, the log says {name}")
                return  # what follows is a consequence
            if place and abs(rig_ns - at_ns) > period_ns + self._grounds.tolerances.time_ns:
                late_ns = rig_ns - at_ns
                words = f"{node} became {name} {late_words(late_ns)} by its heartbeat"
                self._add(What.LATE, at_ns, bus, node, words, late_ns)

    def _periods(self, bus: str, node: str, log: _Side, rig: _Side) -> None:
        period_ns, tolerance_ns = log.period_ns, self._grounds.tolerances.time_ns
        if not period_ns or not rig.period_ns:
            return
        begin_ns, of_log, of_rig = log.states[0][0], log.gaps, rig.gaps
        if abs(period_ns - rig.period_ns) > max(tolerance_ns, round(UNEVEN * period_ns)):
            words = f"{node} sent a heartbeat every {time_words(rig.period_ns)}, the log says {time_words(period_ns)}"
            self._add(What.PERIOD, begin_ns, bus, node, words)
        elif not of_log.count or not of_rig.count:
            return
        elif of_rig.longest_ns > of_log.longest_ns + period_ns // 2 + tolerance_ns:
            words = f"{node} sent no heartbeat for {time_words(of_rig.longest_ns)}"
            self._add(What.MISSING, of_rig.longest_at_ns, bus, node, words)
        elif of_log.longest_ns > of_rig.longest_ns + period_ns // 2 + tolerance_ns:
            words = f"{node} sent heartbeats where the log has none for {time_words(of_log.longest_ns)}"
            self._add(What.MORE, of_log.longest_at_ns, bus, node, words)

    def _add(self, what: What, time_ns: int, bus: str, node: str, words: str, late_ns: int = 0) -> None:
        result = self._grounds.result
        result.add(Difference(self._grounds.since(time_ns), what, bus, node, "heartbeat", words, late_ns))
