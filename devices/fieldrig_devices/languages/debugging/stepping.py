"""The end of a single step: the place at which a program that steps stops again."""

from fieldrig_devices.languages.debugging.debuggee import Step


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
