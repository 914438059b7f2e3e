"""The drive function that the power drive state machine controls: a motor with its power, and ramps to rest."""

from collections.abc import Callable
from typing import Protocol

from fieldrig_devices.cia402.options import Options, Ramp


class Drive(Protocol):
    """The drive function as the state machine sees it."""

    @property
    def is_there(self) -> bool:
        """True once the drive is initialised and can report its state."""

    @property
    def is_ready(self) -> bool:
        """True if power is on and the drive can be enabled."""

    @property
    def is_following(self) -> bool:
        """True if the drive is enabled and follows set values."""

    @property
    def is_moving_by_itself(self) -> bool:
        """True while the drive stops on its own and follows no set values until it is at rest."""

    @property
    def is_at_rest(self) -> bool:
        """True if the ramp that was started has ended and the axis stands."""

    @property
    def errors(self) -> tuple[int, ...]:
        """Present error codes as in 603Fh."""

    @property
    def options(self) -> Options: ...

    def enable(self) -> None: ...

    def disable(self) -> None: ...

    def brake(self, ramp: Ramp) -> None:
        """Bring the axis to rest and hold it there."""

    def go_on(self) -> None:
        """Follow set values again after a ramp."""

    def reset_fault(self, done: Callable[[], None]) -> None:
        """Reset the error if its cause is gone, then call `done`, possibly many cycles later."""
