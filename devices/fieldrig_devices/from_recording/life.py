"""The life of a node in a recording: boot-ups, NMT states, heartbeats, node guarding, emergencies.

Source: CiA 301, 7.2.8 (NMT, boot-up, heartbeat, node guarding) and 7.2.7 (EMCY).
"""

from array import array
from collections import Counter
from statistics import median_low
from typing import Final, NamedTuple

from fieldrig.clock import MS, S
from fieldrig_devices.canopen.guarding import TOGGLE
from fieldrig_devices.canopen.nmt import BOOT_UP, RESETS, Command
from fieldrig_devices.canopen.service import State
from fieldrig_devices.from_recording.rhythm import period_of

MOST: Final = 1_024
RESET_TAKES_NS: Final = 30 * S
"""Longest time from the reset of a node to its boot-up."""
OPERATIONAL: Final = State.OPERATIONAL.value


class BootUp(NamedTuple):
    instant_ns: int
    command: Command | None
    """The reset that led to it; None if the node was switched on."""
    took_ns: int
    """Time since the reset; 0 without one."""
    was_on: bool = False
    """True if the node had sent something before the reset.  Otherwise it may have been booting already."""


class Emergency(NamedTuple):
    instant_ns: int
    code: int
    register: int
    info: bytes = b""
    """The bytes of the maker."""


class Life:
    """One node."""

    def __init__(self) -> None:
        self.boots: list[BootUp] = []
        self.heartbeats = array("q")
        self.guarded = array("q")
        """Instants of the requests of node guarding."""
        self.breaks = array("q")
        """Instants at which the node booted, or its master let it send no PDOs."""
        self.states: Counter[int] = Counter()
        self.first_state: int | None = None
        self.started_ns: int | None = None
        """When the master started the node first."""
        self.runs_by_itself = False
        self.emergencies: list[Emergency] = []
        self.emergency_count = 0
        self.answers = 0
        """Answers to node guarding."""
        self.needs_reset: bool | None = None
        """True if a start had no effect before the first reset of the node; None if the recording does not show it."""
        self._is_reset = self._is_start_open = False
        self._reset: tuple[int, Command, bool] | None = None
        self._is_asked = False

    @property
    def is_seen(self) -> bool:
        """True if the node itself has sent something that only a CANopen node sends."""
        return bool(self.boots or self.states)

    def command(self, time_ns: int, command: Command, *, is_on: bool) -> None:
        """Take a command of the NMT master for this node or for all; `is_on` says that the node has sent something."""
        if command in RESETS:
            self._reset = time_ns, command, is_on
        if command is not Command.START:
            self._note_break(time_ns)
        if command is Command.START and self.started_ns is None:
            self.started_ns = time_ns
        self._is_reset |= command is Command.RESET_NODE
        self._is_start_open = command is Command.START and not self._is_reset

    def guard(self, time_ns: int) -> None:
        """Take a remote frame of the master."""
        self._is_asked = True
        if len(self.guarded) < MOST:
            self.guarded.append(time_ns)

    def error_control(self, time_ns: int, data: bytes) -> bool:
        """Take a message of error control; return True for a boot-up."""
        if data == BOOT_UP and not self._is_asked:
            self._boot(time_ns)
            return True
        state = data[0] & ~TOGGLE & 0xFF
        if self._is_asked:
            self.answers += 1
        elif len(self.heartbeats) < MOST:
            self.heartbeats.append(time_ns)
        self._is_asked = False
        if self._is_start_open:
            self.needs_reset, self._is_start_open = state != OPERATIONAL, False
        if state == OPERATIONAL and self.started_ns is None:
            self.runs_by_itself = True
        self.first_state = state if self.first_state is None else self.first_state
        self.states[state] += 1
        return False

    def emergency(self, time_ns: int, data: bytes) -> None:
        self.emergency_count += 1
        if len(self.emergencies) < MOST:
            self.emergencies.append(Emergency(time_ns, int.from_bytes(data[:2], "little"), data[2], data[3:]))

    def _note_break(self, time_ns: int) -> None:
        if len(self.breaks) < MOST and not (self.breaks and time_ns < self.breaks[-1]):
            self.breaks.append(time_ns)

    def _boot(self, time_ns: int) -> None:
        self._note_break(time_ns)
        reset, self._reset = self._reset, None
        is_reset = reset is not None and 0 <= time_ns - reset[0] <= RESET_TAKES_NS
        if len(self.boots) < MOST:
            self.boots.append(
                BootUp(time_ns, reset[1], time_ns - reset[0], reset[2])
                if reset is not None and is_reset
                else BootUp(time_ns, None, 0)
            )

    @property
    def boot_up_ns(self) -> int:
        """The usual time from a reset to the boot-up; 0 if the recording shows none, or one that is hardly any."""
        resets = [boot for boot in self.boots if boot.command is not None]
        took = [boot.took_ns for boot in resets if boot.was_on] or [boot.took_ns for boot in resets]
        usual_ns = median_low(took) if took else 0
        return usual_ns if usual_ns >= MS else 0

    @property
    def heartbeat_ns(self) -> int:
        """The usual time between two heartbeats; 0 if there are none."""
        return period_of(self.heartbeats)

    @property
    def guarding_ns(self) -> int:
        """The usual time between two requests of node guarding; 0 if there are none."""
        return period_of(self.guarded) if self.answers else 0

    def begins_ns(self, start_ns: int) -> int:
        """Return the instant from which the emulated node counts: its last reset by a master, else the first message.

        A node that is reset begins its recorded values again, as it does in the rig.
        """
        resets = [boot.instant_ns for boot in self.boots if boot.command is Command.RESET_NODE]
        return resets[-1] if resets else start_ns
