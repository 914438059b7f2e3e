"""The signs by which real drives differ, as far as a recording shows them.

Each sign is a key of a drive's `behaviour` with the value that the recording shows; a sign that it does not show is
left out.  The sign of bit 4 is whether it means the enabled drive.  Those of bits 14 and 15 are that they were set: the
drive may have done nothing that would set them, such as turning backwards.

Source: CiA 402-2 for the words, docs/devices/drive-personalities.md for the differences.
"""

from collections.abc import Iterable, Iterator, Sequence
from math import inf
from typing import Any, Final, NamedTuple

from fieldrig.clock import MS
from fieldrig_devices.canopen.nmt import Command
from fieldrig_devices.cia402.objects import CONTROL_WORD, MODE, MODE_DISPLAY, STATUS_WORD, SUPPORTED_MODES
from fieldrig_devices.drive_profile.states import State
from fieldrig_devices.from_recording.can_log import NodeLog
from fieldrig_devices.from_recording.drive_words import Word

STATE_MASK: Final = 0x6F
VOLTAGE, REMOTE, ACKNOWLEDGE, BIT_14, BIT_15 = 0x10, 0x200, 0x1000, 0x4000, 0x8000
COMMAND_MASK, ENABLE, NEW_SET_POINT = 0x8F, 0x0F, 0x10
HOMING, POSITIONING = 6, 1
REACHED: Final = 0x400
ATTAINED: Final = ACKNOWLEDGE
"""Bit 12 of the status word, which says in homing that a method has found its place."""
FEWEST_WORDS: Final = 3
SOON_NS: Final = 5 * MS
LATEST_MS: Final = 2_000.0
LEAST_LIFT_MS: Final = 5.0
"""Time after which an answer of the drive has nothing to do with a command."""
Signs = dict[str, Any]


class Delay(NamedTuple):
    """A time that lies between two instants at which the master looked, in milliseconds; the second may be infinite."""

    least_ms: float
    most_ms: float


def signs_of(log: NodeLog, words: Sequence[Word]) -> Signs:
    """Return the signs of a drive."""
    found: Signs = {}
    for rule in (_bits, _enabling, _delays, _acknowledge, _homing, _frames, _modes):
        found |= dict(rule(log, words))
    return found


def _status(words: Sequence[Word]) -> list[int]:
    return [word.value for word in words if word.object == STATUS_WORD]


def _bits(log: NodeLog, words: Sequence[Word]) -> Iterator[tuple[str, Any]]:
    status = _status(words)
    if len(status) < FEWEST_WORDS:
        return
    yield "remote_bit", any(word & REMOTE for word in status)
    enabled = State.OPERATION_ENABLED.value
    others = [word for word in status if word & STATE_MASK != enabled]
    if len(others) >= FEWEST_WORDS and any(word & STATE_MASK == enabled for word in status):
        yield "voltage_bit", not any(word & VOLTAGE for word in others)
    for name, bit in (("bit_14", BIT_14), ("bit_15", BIT_15)):
        if any(word & bit for word in status):
            yield name, True


def _enabling(log: NodeLog, words: Sequence[Word]) -> Iterator[tuple[str, Any]]:
    """0Fh in 'ready to switch on' enables the drive, or takes one step, after which the drive waits for another one."""
    state, is_tried = -1, False
    for word in (*words, Word(0, 0, CONTROL_WORD, 0)):
        if word.object == STATUS_WORD:
            state = word.value & STATE_MASK
        elif word.object == CONTROL_WORD:
            if is_tried and state in (State.OPERATION_ENABLED.value, State.SWITCHED_ON.value):
                yield "passes_switched_on", state == State.OPERATION_ENABLED.value
                return
            is_tried = word.value & COMMAND_MASK == ENABLE and state == State.READY_TO_SWITCH_ON.value


def brake_lift_ms(words: Sequence[Word]) -> float | None:
    """Return the time from 0Fh to the enabled drive, in ms; None if it is as good as none, or if the master polls."""
    state, asked_ns, not_yet_ns = -1, 0, 0
    delays: list[Delay] = []
    for word in words:
        if word.object == CONTROL_WORD:
            is_enable = word.value & COMMAND_MASK == ENABLE and state == State.SWITCHED_ON.value
            asked_ns = not_yet_ns = word.begin_ns if is_enable else 0
        elif word.object == STATUS_WORD:
            state = word.value & STATE_MASK
            if asked_ns and state == State.OPERATION_ENABLED.value:
                delays.append(_between(asked_ns, not_yet_ns, word))
                asked_ns = 0
            not_yet_ns = word.begin_ns
    delay = _usual(delays)
    is_sure = delay is not None and delay.most_ms >= LEAST_LIFT_MS and delay.least_ms > 0.8 * delay.most_ms
    return float(f"{delay.most_ms:.2g}") if delay is not None and is_sure else None


def _between(asked_ns: int, not_yet_ns: int, word: Word) -> Delay:
    """Return the time from a command to its effect, which was not there yet when the master looked before."""
    most_ms = (word.end_ns - asked_ns) / MS
    return Delay(most_ms if word.is_exact else (not_yet_ns - asked_ns) / MS, most_ms)


def _delays(log: NodeLog, words: Sequence[Word]) -> Iterator[tuple[str, Any]]:
    delay = _usual(_follows(words))
    if delay is not None:
        yield "mode_display_ms", delay


def _follows(words: Sequence[Word]) -> Iterator[Delay]:
    """Yield the times from each new mode to its display."""
    wanted, asked_ns, not_yet_ns = -1, 0, 0
    for word in words:
        if word.object == MODE and word.value != wanted:
            wanted, asked_ns = word.value, word.begin_ns
            not_yet_ns = asked_ns
        elif word.object == MODE_DISPLAY and asked_ns:
            if word.value == wanted:
                yield _between(asked_ns, not_yet_ns, word)
                asked_ns = 0
            not_yet_ns = word.begin_ns


def _usual(delays: Iterable[Delay]) -> Delay | None:
    """Return the narrowest delay, which says most; None without one."""
    usual = [delay for delay in delays if 0 <= delay.least_ms <= delay.most_ms <= LATEST_MS]
    return min(usual, key=lambda delay: delay.most_ms - delay.least_ms, default=None)


def _acknowledge(log: NodeLog, words: Sequence[Word]) -> Iterator[tuple[str, Any]]:
    delay = _usual(_acknowledged(words))
    if delay is not None:
        yield "acknowledge_ms", delay
    mode, is_asked = 0, False
    for word in words:
        if word.object in (MODE, MODE_DISPLAY):
            mode = word.value
        elif word.object == CONTROL_WORD:
            is_asked |= bool(word.value & NEW_SET_POINT)
        elif mode == POSITIONING and not is_asked and word.value & STATE_MASK == State.OPERATION_ENABLED.value:
            yield "acknowledges_at_start", bool(word.value & ACKNOWLEDGE)
            return


def _acknowledged(words: Sequence[Word]) -> Iterator[Delay]:
    """Yield the times from bit 4 of the control word to bit 12 of the status word."""
    control, asked_ns, not_yet_ns = 0, 0, 0
    for word in words:
        if word.object == CONTROL_WORD:
            if word.value & NEW_SET_POINT and not control & NEW_SET_POINT:
                asked_ns = not_yet_ns = word.begin_ns
            control = word.value
        elif word.object == STATUS_WORD and asked_ns:
            if word.value & ACKNOWLEDGE:
                yield _between(asked_ns, not_yet_ns, word)
                asked_ns = 0
            not_yet_ns = word.begin_ns


def _homing(log: NodeLog, words: Sequence[Word]) -> Iterator[tuple[str, Any]]:
    """Bit 10 is set while the axis stands, also before homing; or it comes after a method has ended, or never."""
    mode, wanted, is_begun, is_unset = 0, 0, False, False
    for word in words:
        if word.object == MODE_DISPLAY:
            mode = word.value
        elif word.object == MODE:
            wanted = word.value
        elif word.object == CONTROL_WORD:
            is_begun |= HOMING in {mode, wanted} and bool(word.value & NEW_SET_POINT)
        elif mode != HOMING or word.value & STATE_MASK != State.OPERATION_ENABLED.value:
            continue
        elif not is_begun:
            if word.value & REACHED:
                yield "homing_bit", "standing"
                return
            is_unset = True
        elif is_unset and word.value & ATTAINED:
            yield "homing_bit", "after" if word.value & REACHED else "never"
            return


def _frames(log: NodeLog, words: Sequence[Word]) -> Iterator[tuple[str, Any]]:
    """Yield the signs besides the profile: boot-up, SDO answers, NMT."""
    resets = [boot for boot in log.life.boots if boot.command is Command.RESET_NODE]
    if took := [boot.took_ns / MS for boot in resets if boot.was_on]:
        yield "boot_up_ms", Delay(min(took), max(took))
    elif resets:
        yield "boot_up_ms", Delay(max(boot.took_ns for boot in resets) / MS, inf)
    if log.life.boots and log.life.heartbeats:
        yield (
            "says_preoperational",
            any(0 <= beat - boot.instant_ns <= SOON_NS for boot in log.life.boots for beat in log.life.heartbeats),
        )
    if log.objects.answer_ns:
        answers = sorted(log.objects.answer_ns)
        edge = len(answers) // 20  # a few answers are late because the bus is busy, or because the node stores
        yield "sdo_answer_ms", Delay(answers[0] / MS, answers[edge] / MS)
        yield "sdo_answer_most_ms", Delay(answers[-1 - edge] / MS, answers[-1 - edge] / MS)
    if log.objects.lost_first is not None:
        yield "loses_first_sdo", log.objects.lost_first
    if log.life.needs_reset is not None:
        yield "needs_reset_node", log.life.needs_reset


def _modes(log: NodeLog, words: Sequence[Word]) -> Iterator[tuple[str, Any]]:
    supported = log.objects.number(SUPPORTED_MODES)
    if supported:
        yield "modes", [mode for mode in range(1, 11) if supported >> (mode - 1) & 1]
