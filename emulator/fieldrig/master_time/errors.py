"""The errors that end a master in virtual time."""


class VirtualTimeError(BaseException):
    """A master in virtual time cannot go on, or would leave virtual time; `remedy` says what to do.

    It is no Exception: a library takes any Exception of a connection for a peer that is not there, and tries again.
    """

    def __init__(self, what: str, remedy: str = "") -> None:
        super().__init__(f"{what}\n  {remedy}" if remedy else what)
        self.what = what
        self.remedy = remedy


class EndedError(SystemExit):
    """Raised in threads that still wait when the block ends, so that they unwind."""
