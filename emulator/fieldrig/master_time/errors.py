"""The errors that end a master in virtual time."""

from fieldrig.errors import RigError


class VirtualTimeError(RigError):
    """A master in virtual time cannot go on, or would leave virtual time.

    It is no OSError, because masters take that for a peer that is not there.
    """


class EndedError(SystemExit):
    """Raised in threads that still wait when the block ends, so that they unwind."""
