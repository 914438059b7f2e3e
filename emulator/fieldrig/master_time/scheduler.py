"""The baton: of the threads of a master, exactly one runs at any time.

A member is the thread that entered the block, and each thread that a member starts.  A member that has to wait hands
the baton on to the next member that can run.  If there is none, it lets time pass: the rig goes on to the earliest
instant at which a member wakes up, or until a message for one arrives.  At an instant the rig comes first, then members
in the order in which they became able to run.  So a run depends on nothing but its inputs: neither on the host's speed
nor on its other load.

Computing takes no virtual time.  But a member that looks at the clock again and again without waiting would never
end; after `FREE_READS` looks, each further one takes `READ_NS`.
"""

import heapq
import sys
import threading
from collections import deque
from collections.abc import Callable
from enum import Enum, auto
from random import Random
from typing import Final, Protocol

from fieldrig.clock import US, S
from fieldrig.master_time.errors import EndedError, VirtualTimeError
from fieldrig.master_time.member import Member, new_lock, this_thread
from fieldrig.master_time.one_cpu import OneCpu
from fieldrig.master_time.places import where
from fieldrig.virtual.rig import Rig

FREE_READS: Final = 1000
READ_NS: Final = 100 * US
LONGEST_TIMEOUT_S: Final = 1e9
"""A wait that is at least this long has no end."""
FOREVER_NS: Final = 3600 * S
"""Virtual time for which a rig goes on while all members wait without a time-out."""
MOST_REFUSALS: Final = 100
"""How often a thread may swallow the end of the block before it is stopped where it is."""


class Place(Enum):
    """The part whose code runs."""

    MEMBER = auto()
    RIG = auto()
    """Devices and buses, which have a clock of their own and may use the real one."""
    DOORS = auto()
    """The ports of the rig, which see virtual time and never wait."""


class Doors(Protocol):
    """The ports of the rig at which the master connects."""

    def look(self) -> None:
        """Handle everything that clients have sent, without waiting."""

    def next_ns(self) -> int | None:
        """Return the instant of the next timer of a port; None without one."""

    @property
    def have_written(self) -> bool:
        """True if a port may have written to a client since the last look."""

    @property
    def have_clients(self) -> bool:
        """True if a port may still write to a client."""


class Scheduler:
    def __init__(self, rig: Rig, limit_s: float, jitter_s: float, seed: int) -> None:
        """`jitter_s` is the longest time by which wake-ups are late, by chance from `seed`."""
        self.rig = rig
        self.limit_ns = rig.now_ns + round(limit_s * S)
        self.place = Place.MEMBER
        self.worker = 0
        """The number of the thread that lets time pass, for all."""
        self.main = self.running = Member(threading.current_thread().name)
        self.main.ident, self.main.native = this_thread(), threading.get_native_id()
        self.members: dict[int, Member] = {self.main.ident: self.main}
        """The threads that run or wait, by their numbers."""
        self.alive: dict[Member, None] = {self.main: None}
        self.one_cpu = OneCpu()
        self.doors: Doors | None = None
        self.is_over = False
        self.failure: VirtualTimeError | None = None
        """The first error that a thread was given; from then on, each wait of the main thread raises it."""
        self.left: list[str] = []
        """The threads that would not end."""
        self.lost: list[int] = []
        """The numbers of those that had their baton taken away."""
        self.switches = 0
        self.is_main_punctual = False
        """True if jitter is for the other threads only."""
        self._jitter_ns, self._random = round(jitter_s * S), Random(seed)
        self._runnable: deque[Member] = deque()
        self._timers: list[tuple[int, int, Member, int]] = []
        self._polled: dict[Member, None] = {}
        self._orders = 0
        self._is_main_wanted = False
        """True if the main thread was interrupted, and should have the baton next."""

    # ---- waiting

    def until(self, timeout_s: float | None) -> int | None:
        """Return the instant at which a time-out ends; None for one that never does."""
        if timeout_s is None or timeout_s >= LONGEST_TIMEOUT_S:
            return None
        # To the nearest: rounding up would let periods of 0.1 s drift by a nanosecond each.
        return self.rig.now_ns + (max(1, round(timeout_s * S)) if timeout_s > 0 else 0)

    def wait(
        self,
        until_ns: int | None = None,
        queue: deque[Member] | None = None,
        ready: Callable[[], bool] | None = None,
        hears_rig: bool = False,
    ) -> bool:
        """Let others run until this thread is woken, `ready()` holds, or the instant comes; return False for the last.

        `queue` is where those find it who wake it.  With `hears_rig` an event of the rig may wake it, without a socket.
        """
        me = self._at_turn()
        me.reads = 0
        me.hears_rig = hears_rig
        try:
            return self._wait(me, until_ns, queue, ready)
        finally:
            me.hears_rig = False

    def give_way(self) -> None:
        """Let all others run that can."""
        me = self._at_turn()
        me.is_waiting = True
        self.wake(me)
        self._hand_on(me)
        self._resume(me)

    def settle(self) -> None:
        """Let the rig and its ports first do what this thread has caused at this instant, such as a fault."""
        if self.place is not Place.MEMBER:
            return
        next_ns = self.rig.next_ns()
        if next_ns is not None and next_ns <= self.rig.now_ns:
            self.wait(self.rig.now_ns)
        self.serve()

    def count_read(self) -> None:
        """Count a look at the clock, or at anything else that may have changed; time passes after very many."""
        me = self.running
        me.reads += 1
        if me.reads > FREE_READS:
            self._wait(self._at_turn(), self.rig.now_ns + READ_NS, None, None)

    def poll(self) -> None:
        """Count a look that does not wait, and let the ports send before it what they have ready."""
        self.count_read()
        self.serve()

    def wake(self, member: Member, is_notified: bool = True) -> None:
        """Let a member that waits run on, after all others that can run already.

        With jitter, what comes from outside the master wakes it late.
        """
        if not member.is_waiting or member.is_delayed:
            return
        member.is_notified = is_notified
        self._forget_descriptors(member)
        if self._jitter_ns and self.place is not Place.MEMBER:
            member.is_delayed = True
            member.turn += 1
            self._set_timer(member, self.rig.now_ns)
        else:
            self._run(member)

    def _run(self, member: Member) -> None:
        member.is_waiting = member.is_delayed = False
        self._runnable.append(member)

    def wake_one(self, queue: deque[Member]) -> None:
        """Wake the member that has waited longest in this queue."""
        while queue:
            member = queue.popleft()
            if member.is_waiting:
                self.wake(member)
                return

    def _wait(
        self, me: Member, until_ns: int | None, queue: deque[Member] | None, ready: Callable[[], bool] | None
    ) -> bool:
        me.is_notified, me.is_waiting = False, True
        me.turn += 1
        if queue is not None:
            queue.append(me)
        if until_ns is not None:
            self._set_timer(me, until_ns)
        if ready is not None:
            me.ready = ready
            self._polled[me] = None
        self._hand_on(me)
        if queue is not None and not me.is_notified and me in queue:
            queue.remove(me)
        self._resume(me)
        return me.is_notified

    def _set_timer(self, me: Member, until_ns: int) -> None:
        if self._jitter_ns and not (self.is_main_punctual and me is self.main):
            until_ns += self._random.randrange(self._jitter_ns + 1)
        self._orders += 1
        heapq.heappush(self._timers, (until_ns, self._orders, me, me.turn))

    def _at_turn(self) -> Member:
        """Return the running member, which is the caller, if it may still wait."""
        me = self.members.get(this_thread())
        if me is None or me.is_lost:
            raise EndedError
        assert me is self.running, "a thread without the baton waits"
        self._end_if_over(me)
        if me is self.main and self.failure is not None and not self.is_over:
            raise self.failure
        return me

    def _resume(self, me: Member) -> None:
        """Raise what the member was woken for, if that is an error."""
        if me.error is not None:
            error, me.error = me.error, None
            raise error
        self._end_if_over(me)

    def _end_if_over(self, me: Member) -> None:
        if not self.is_over or me is self.main:
            return
        me.refused += 1
        if me.refused > MOST_REFUSALS:
            self.left.append(me.name)
            self._forget(me)
            self._hand_on(me)
            _stand_still()
        raise EndedError

    # ---- whose turn it is

    def _hand_on(self, me: Member) -> None:
        self.worker = this_thread()
        try:
            following = self._next()
        except BaseException as error:  # noqa: BLE001  of a device, or a standstill; the test gets it
            self.place = Place.MEMBER
            following = self._main_with(self.failure or error)
        if following is me:
            return
        self.switches += 1
        self.running = following
        following.baton.release()
        if me.is_done:
            return
        try:
            me.baton.acquire()
        except BaseException as interrupt:  # noqa: BLE001  Ctrl-C, which only the main thread gets
            self._take_back(interrupt)

    def _take_back(self, interrupt: BaseException) -> None:
        """Let the interrupted main thread have the baton as soon as its holder waits."""
        self._is_main_wanted = True
        while True:
            try:
                # An interrupt may come before the baton, or with it; then the lock may be taken already.
                if self.main.baton.acquire(True, 0.1) or self.running is self.main:
                    break
            except BaseException as again:  # noqa: BLE001
                interrupt = again
        self._is_main_wanted = False
        raise interrupt

    def _main_with(self, error: BaseException) -> Member:
        """Return the main thread, ready to run and to raise this error."""
        main = self.main
        if isinstance(error, VirtualTimeError) and self.failure is None:
            self.failure = error
        main.error = error
        main.is_waiting = main.is_delayed = False
        main.turn += 1
        self._forget_descriptors(main)
        if main in self._runnable:
            self._runnable.remove(main)
        return main

    def _next(self) -> Member:
        """Return the member that runs next; let time pass until there is one."""
        if self.failure is not None and not self.is_over:  # of another thread; the main thread gets it at once
            raise self.failure
        while not self._runnable:
            self._look()
            if not self._runnable:
                self._pass_time()
        if self._is_main_wanted:
            if self.main.is_waiting:
                self._forget_descriptors(self.main)
                self._run(self.main)
            if self.main in self._runnable:
                self._runnable.remove(self.main)
                return self.main
        return self._runnable.popleft()

    def _look(self) -> None:
        """Let the ports handle what was sent to them, and wake the members whose descriptors are ready."""
        self.serve()
        if not self._polled:
            return
        self.place = Place.RIG
        for member in list(self._polled):
            if member.ready is not None and member.ready():
                self.wake(member)
        self.place = Place.MEMBER

    def serve(self) -> None:
        """Let the ports handle what was sent to them."""
        if self.doors is not None:
            self.worker, self.place = this_thread(), Place.DOORS
            try:
                self.doors.look()
            finally:
                self.place = Place.MEMBER

    def _pass_time(self) -> None:
        rig, wake_ns, doors_ns = self.rig, self._wake_ns(), self.doors.next_ns() if self.doors is not None else None
        if wake_ns is None or (doors_ns is not None and doors_ns < wake_ns):
            wake_ns = doors_ns
        until_ns = self._forever_ns() if wake_ns is None else max(wake_ns, rig.now_ns)
        self.place = Place.RIG
        try:
            is_reached = rig.run_until(min(until_ns, self.limit_ns), self._has_news)
        finally:
            self.place = Place.MEMBER
        if is_reached and (wake_ns is None or until_ns > self.limit_ns):
            if self._has_news():
                return
            raise self._standstill(f"the limit of {rig.now_ns / S:g} s of virtual time is reached")
        self._wake_due()

    def _has_news(self) -> bool:
        return bool(self._runnable) or (self.doors is not None and self.doors.have_written)

    def _forever_ns(self) -> int:
        """Return how far the rig may go on for members without a time-out.  VirtualTimeError if nothing can come."""
        rig = self.rig
        if rig.next_ns() is None:
            raise self._standstill("all threads wait forever, and nothing is left to happen in the rig")
        if not self._hears_rig:
            raise self._standstill("all threads wait forever, and nothing in the rig can wake one of them")
        return rig.now_ns + FOREVER_NS

    @property
    def _hears_rig(self) -> bool:
        """True if an event of the rig may wake a member: by a call of the test, a bus, or a client of a port."""
        if not self.rig.clients.are_alone or any(member.hears_rig for member in self.alive):
            return True
        return bool(self._polled) and self.doors is not None and self.doors.have_clients

    def _wake_ns(self) -> int | None:
        timers = self._timers
        while timers and not _is_current(timers[0][2], timers[0][3]):
            heapq.heappop(timers)
        return timers[0][0] if timers else None

    def _wake_due(self) -> None:
        timers, now_ns = self._timers, self.rig.now_ns
        while timers and timers[0][0] <= now_ns:
            _, _, member, turn = heapq.heappop(timers)
            if _is_current(member, turn):
                self._forget_descriptors(member)
                self._run(member)

    def _forget_descriptors(self, member: Member) -> None:
        if member.ready is not None:
            member.ready = None
            self._polled.pop(member, None)

    # ---- threads

    def started(self, member: Member) -> None:
        """Add the thread that calls, which waits for its first turn."""
        member.baton.acquire()
        member.ident, member.native = this_thread(), threading.get_native_id()
        self.one_cpu.take(member.native)
        self.members[member.ident] = member

    def add(self, member: Member) -> None:
        """Let a thread that is being started run when it is its turn."""
        self.alive[member] = None
        member.is_waiting = True
        self.wake(member)

    def finished(self, member: Member) -> None:
        """End a thread: its turn is the next one's."""
        if member.is_lost:
            return
        member.is_done = True
        self._forget(member)
        for joiner in list(member.joiners):
            self.wake(joiner)
        self._hand_on(member)

    def _forget(self, member: Member) -> None:
        member.is_done = True
        self.one_cpu.forget(member.native)
        self.alive.pop(member, None)
        if self.members.get(member.ident) is member:
            del self.members[member.ident]

    def give_up(self, member: Member, error: VirtualTimeError) -> None:
        """Take the baton away from a thread that will not hand it on, in the watchdog's thread."""
        member.is_lost = True
        self._forget(member)
        self.left.append(member.name)
        self.lost.append(member.ident)
        self.switches += 1
        self.running = self._main_with(error)
        self.main.baton.release()

    # ---- the end

    def end(self) -> None:
        """Let all other threads unwind, and end."""
        self.is_over = True
        for _ in range(MOST_REFUSALS + 2):
            if len(self.alive) == 1:
                return
            for member in list(self.alive):
                if member is not self.main and member.is_waiting:
                    self._forget_descriptors(member)
                    self._run(member)
            self.give_way()

    def report(self) -> str:
        """Return a line for each thread, with what it waits in."""
        frames = sys._current_frames()
        return "\n".join(f"  {member.name}: {where(frames.get(member.ident))}" for member in self.alive)

    def _standstill(self, what: str) -> VirtualTimeError:
        return VirtualTimeError(what, f"the threads wait at\n{self.report()}")


def _is_current(member: Member, turn: int) -> bool:
    return member.is_waiting and member.turn == turn


def _stand_still() -> None:
    """Never return."""
    lock = new_lock()
    lock.acquire()
    lock.acquire()
