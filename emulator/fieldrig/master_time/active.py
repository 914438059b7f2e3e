"""Which scheduler the calling thread belongs to.

The stand-ins of the standard library's calls ask this each time, so they lead to the real calls in all other threads,
while a device of the rig works, and after the block, where a module that was imported in it still has them.
"""

from fieldrig.master_time.member import this_thread
from fieldrig.master_time.scheduler import Place, Scheduler

_active: Scheduler | None = None


def activate(scheduler: Scheduler | None) -> None:
    """Set the one scheduler of this process; None after the block."""
    global _active
    _active = scheduler


def any_scheduler() -> Scheduler | None:
    """Return the scheduler of the block, also to threads that are no members; None outside of a block."""
    return _active


def waiting_scheduler() -> Scheduler | None:
    """Return the scheduler if the caller is a member that may wait."""
    scheduler = _active
    if scheduler is None or scheduler.place is not Place.MEMBER or this_thread() not in scheduler.members:
        return None
    return scheduler


def seeing_scheduler() -> Scheduler | None:
    """Return the scheduler if the caller sees virtual time: a member, or a port of the rig."""
    scheduler = _active
    if scheduler is None or scheduler.place is Place.RIG:
        return None
    if scheduler.place is Place.DOORS:
        return scheduler if scheduler.worker == this_thread() else None
    return scheduler if this_thread() in scheduler.members else None
