"""The past of a rig: its checkpoints, which may come at any instant, and what is asked of it in between.

The branches that end with the rig are here as well, as each way back is one of them.
"""

from collections.abc import Callable, Mapping
from typing import Any, Final, Protocol

from fieldrig.clock import NEVER_NS
from fieldrig.errors import ArgumentError, RigError
from fieldrig.outside.untrusted import shown
from fieldrig.virtual.branch import Branch, Parking
from fieldrig.virtual.checkpoints import Checkpoints
from fieldrig.virtual.readings import seconds

UNREPEATED: Final = "what a member sends between two runs cannot be repeated; use set, answer and faults"


class Present(Protocol):
    """The engine of the rig, as far as its past needs it."""

    now_ns: int
    is_playing: bool
    is_telling: bool
    outside: dict[str, Any]


class Past:
    def __init__(self, rig: Parking, present: Present) -> None:
        self._rig, self._present = rig, present
        self._branches: list[Branch] = []
        self._checkpoints: Checkpoints | None = None
        self.due_ns = NEVER_NS
        """The instant of the next checkpoint, or `NEVER_NS`."""

    def keep_every(self, period_ns: int, keep: int) -> Callable[[], None]:
        """Take checkpoints from now on, and return a function that ends it.  The errors are those of the rig's call."""
        if type(period_ns) is not int or period_ns < 1:
            raise ArgumentError(f"checkpoint_every cannot take {shown(period_ns)}", "expected a period, such as 5 * S")
        if type(keep) is not int or keep < 2:
            raise ArgumentError(f"checkpoint_every cannot keep {shown(keep)}", "expected at least 2")
        if self._present.outside:
            raise RigError(
                f"a rig with members from outside has no checkpoints: {', '.join(self._present.outside)}", UNREPEATED
            )
        self._end_checkpoints()
        checkpoints = self._checkpoints = Checkpoints(self._rig, period_ns, keep)
        self.due_ns = checkpoints.due_ns(self._present.now_ns)

        def end() -> None:
            if self._checkpoints is checkpoints:
                self._end_checkpoints()

        return end

    def park(self, next_ns: int) -> None:
        """Take the checkpoint that is due before `next_ns`; if the rig sleeps over several, the last of them.

        It is no event, so a rig makes the same steps with checkpoints and without.
        """
        if self._checkpoints is not None and self.due_ns < next_ns:
            self.due_ns = self._checkpoints.due_ns(next_ns - 1)
            self._present.now_ns = max(self._present.now_ns, self.due_ns - self._checkpoints.period_ns)
            self._checkpoints.take()

    def note(self, call: str, *arguments: Any) -> None:
        """Note a call from outside that changes the rig, so that it can be repeated."""
        if self._checkpoints is not None and not self._present.is_playing and not self._present.is_telling:
            self._checkpoints.note(call, *arguments)

    def note_run(self) -> None:
        """Note that the rig runs: what is asked of it next comes after what happens at the present instant."""
        if self._checkpoints is not None:
            self._checkpoints.has_run = True

    def keep_now(self) -> None:
        """Take a checkpoint after something that cannot be repeated, such as a call for changes."""
        if self._checkpoints is not None and not self._present.is_playing:
            self._checkpoints.take(is_fixed=True)

    def check_takes_members(self) -> None:
        """RigError if a member from outside could send what no way back repeats."""
        if self._checkpoints is not None:
            raise RigError("a rig with checkpoints takes no members from outside", UNREPEATED)

    def back(self, instant_ns: int) -> Branch:
        """Return a branch of the rig as it was when its clock came to an instant.  The errors are the rig's."""
        if self._checkpoints is None:
            raise RigError("the rig has no checkpoints to go back to", "call checkpoint_every(5 * S) before")
        if instant_ns > self._present.now_ns:
            raise ArgumentError(
                f"the rig cannot go back to {seconds(instant_ns)}: it is at {seconds(self._present.now_ns)}", "run it"
            )
        return self.owned(self._checkpoints.back(instant_ns))

    def owned(self, branch: Branch) -> Branch:
        """Return a branch that ends with the rig at the latest."""
        self._branches = [*(each for each in self._branches if not each.is_closed), branch]
        return branch

    def memory(self) -> Mapping[int, int]:
        """Return the bytes of memory that each checkpoint has for itself, by its instant."""
        return {} if self._checkpoints is None else self._checkpoints.memory()

    def close(self) -> None:
        self._end_checkpoints()
        while self._branches:
            self._branches.pop().close()

    def _end_checkpoints(self) -> None:
        if self._checkpoints is not None:
            self._checkpoints.close()
            self._checkpoints, self.due_ns = None, NEVER_NS
