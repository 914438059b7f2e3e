"""Ends a block in which a thread will not hand the baton on, so that no run ever hangs.

A thread of real time looks at the running member.  If the system shows it asleep all the time, with next to no
processor time, it waits for something that the scheduler does not know, such as a device or a lock of a C library; that
cannot end well, however busy the host is.  A member that computes may take `patience_s` of processor time, and so may
a device at one instant of the rig.  A member in a debugger waits for a person, and has all the time that it needs.
Left out: systems without /proc, where `patience_s` is real time.
"""

import _thread
import ctypes
import os
import signal
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path
from types import FrameType
from typing import Final

from fieldrig.clock import MS, S
from fieldrig.master_time.errors import EndedError, VirtualTimeError
from fieldrig.master_time.member import Member, new_lock
from fieldrig.master_time.places import is_debugged, where
from fieldrig.master_time.scheduler import Place, Scheduler

LOOK_S: Final = 0.25
"""Real time between two looks."""
ASLEEP_S: Final = 2.0
"""Real time for which a running member may be asleep."""
SLACK: Final = 20
"""Real time for `patience_s` of processor time, on a host that has other work: this number of times as long."""
TICKS: Final = os.sysconf("SC_CLK_TCK") if hasattr(os, "sysconf") else 0
"""Ticks of processor time in a second; 0 where the system does not tell them."""
AWAKE_NS: Final = 1 * MS
"""Processor time in `ASLEEP_S` from which on a member is awake.  One that waits for the lock of Python asks for it each
5 ms, which takes 2 ms in two seconds; who waits in C looks some times a second, if at all."""
UNWIND_S: Final = 0.5
SIGNAL: Final[signal.Signals] = getattr(signal, "SIGUSR2", signal.SIGTERM)
"""Interrupts the main thread.  On Windows no program sends SIGTERM to another."""
_real_monotonic = time.monotonic


class Watchdog:
    def __init__(self, scheduler: Scheduler, patience_s: float) -> None:
        self._scheduler, self._patience_s = scheduler, patience_s
        self._is_over = _RealEvent()
        self._error: VirtualTimeError | None = None
        self._before = signal.signal(SIGNAL, self._on_signal)
        self._thread = threading.Thread(target=self._run, name="fieldrig watchdog", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End the watch, after a moment for the threads that were given up to unwind."""
        end_s = _real_monotonic() + UNWIND_S
        while any(ident in sys._current_frames() for ident in self._scheduler.lost) and _real_monotonic() < end_s:
            self._is_over.wait(0.01)
        self._is_over.set()
        self._thread.join()
        signal.signal(SIGNAL, self._before)

    def _on_signal(self, *_: object) -> None:
        error, self._error = self._error, None
        if error is not None:
            raise error

    def _run(self) -> None:
        # On another processor it is woken at each switch of the members, and is too late for the lock of Python.
        native = threading.get_native_id()
        self._scheduler.one_cpu.take(native)
        try:
            self._watch()
        finally:
            self._scheduler.one_cpu.forget(native)

    def _watch(self) -> None:
        seen, since_s, asleep_s, spent_ns, first_ns = (-1, -1), _real_monotonic(), _real_monotonic(), -1, -1
        while not self._is_over.wait(LOOK_S):
            scheduler, now_s = self._scheduler, _real_monotonic()
            scheduler.one_cpu.look()
            at, member = (scheduler.switches, scheduler.rig.now_ns // MS), scheduler.running
            is_rig = scheduler.place is Place.RIG
            if scheduler.place is not Place.MEMBER:
                member = scheduler.members.get(scheduler.worker, member)
            frame = sys._current_frames().get(member.ident)
            if at != seen or is_debugged(frame):
                seen, since_s, asleep_s, spent_ns, first_ns = at, now_s, now_s, -1, -1
                continue
            is_asleep, now_ns = _state(member.native)  # not before: while threads switch, each call costs 5 ms
            if first_ns < 0:
                first_ns = now_ns
            if not is_asleep or spent_ns < 0 or now_ns - spent_ns >= AWAKE_NS or is_rig:
                asleep_s, spent_ns = now_s, now_ns
            if now_s - asleep_s >= ASLEEP_S:
                self._end(member, f"thread {member.name} waits for something outside of virtual time", frame)
            elif self._is_over_time(now_s - since_s, now_ns - first_ns):
                who, end = ("a device", "time passing") if is_rig else (f"thread {member.name}", "waiting")
                self._end(member, f"{who} has run for {self._patience_s:g} s without {end}", frame, is_rig=is_rig)
            else:
                continue
            seen = (-1, -1)

    def _is_over_time(self, real_s: float, spent_ns: int) -> bool:
        if not TICKS:
            return real_s >= self._patience_s
        return spent_ns >= self._patience_s * S or real_s >= self._patience_s * SLACK

    def _end(self, member: Member, what: str, frame: FrameType | None, *, is_rig: bool = False) -> None:
        scheduler = self._scheduler
        remedy = "a wait in C, a device of this host or an endless loop cannot be in virtual time"
        error = VirtualTimeError(f"{what}: {where(frame)}", remedy)
        if scheduler.failure is None:
            scheduler.failure = error
        if member is scheduler.main:
            self._error = error
            _interrupt(member.ident)
            return
        if not is_rig:  # in the rig it lets go of the baton as soon as the device has ended
            scheduler.give_up(member, error)
        ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(member.ident), ctypes.py_object(EndedError))


def _interrupt(ident: int) -> None:
    """Let the main thread handle `SIGNAL`, also if it is in a call of the system where the system can end that."""
    if hasattr(signal, "pthread_kill"):
        signal.pthread_kill(ident, SIGNAL)
    else:
        _thread.interrupt_main(SIGNAL)


class _RealEvent:
    """An event for a thread of real time, whatever `threading` leads to."""

    def __init__(self) -> None:
        self._lock = new_lock()
        self._lock.acquire()

    def set(self) -> None:
        self._lock.release()

    def wait(self, timeout_s: float) -> bool:
        return self._lock.acquire(True, timeout_s)


def _state(native: int) -> tuple[bool, int]:
    """Return whether the system shows a thread asleep, and its processor time in ns."""
    thread = Path(f"/proc/self/task/{native}")
    try:
        fields = (thread / "stat").read_bytes().rpartition(b")")[2].split()
        return fields[0] == b"S", _spent_ns(thread, int(fields[11]) + int(fields[12]))
    except OSError:
        return False, 0


def _spent_ns(thread: Path, ticks: int) -> int:
    """Return the processor time of a thread: to the nanosecond where the kernel counts so, else in its ticks."""
    exact_ns = 0
    with suppress(OSError):
        exact_ns = int((thread / "schedstat").read_bytes().split()[0])  # 0 where the kernel has the file alone
    return max(exact_ns, ticks * S // TICKS)
