"""The end of a single step: the place at which a program that steps stops again."""

from fieldrig_devices.languages.debugging.debuggee import At, Step


class Goal:
    """A step that has begun at a source line, inside `depth` calls."""

    def __init__(self, kind: Step, line: int, depth: int) -> None:
        self._kind, self._line, self._depth = kind, line, depth

    def is_reached(self, line: int, depth: int, *, is_beginning: bool) -> bool:
        """Return whether a program in front of this line, inside `depth` calls, has made the step.

        A step over a call ends at the next line of the same routine, or in its caller; a step out ends in the caller.
        Within a routine, a line is the next one only at its beginning: behind an IF whose body is left out, the jump or
        the end that follows belongs to the last line of that body, which has not run.
        """
        is_next = line != self._line and is_beginning
        match self._kind:
            case Step.INTO:
                return depth != self._depth or is_next
            case Step.OVER:
                return depth < self._depth or (depth == self._depth and is_next)
            case Step.OUT:
                return depth < self._depth


class Stepping:
    """A step of a thread from where it stands, over all breakpoints that let the program run on."""

    def __init__(self, thread: int, kind: Step, at: At) -> None:
        self.thread, self._kind, self._depth = thread, kind, at.depth
        self._goal = Goal(kind, at.line, at.depth)
        self._is_in_parts = False
        """True if the thread makes other steps on the way."""

    def is_done(self, at: At, *, is_at_breakpoint: bool) -> bool:
        """Return whether a thread that has stopped here has made the step.

        Without a breakpoint there, its own step has ended; a part of one is the last at the begin of the next cycle.
        """
        if self._goal.is_reached(at.line, at.depth, is_beginning=at.is_beginning):
            return True
        return not is_at_breakpoint and (not self._is_in_parts or (at.is_beginning and at.depth <= self._depth))

    def part_from(self, at: At) -> Step:
        """Return the step that goes on from a place on the way: out of a call that the step is to go over."""
        self._is_in_parts = True
        return Step.OUT if self._kind is Step.OVER and at.depth > self._depth else self._kind
