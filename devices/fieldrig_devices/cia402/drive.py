"""What the power drive state machine moves: a motor with its power, and ramps that bring it to rest."""

from collections.abc import Callable
from typing import Protocol

from fieldrig_devices.cia402.options import Options, Ramp


class Drive(Protocol):
    """What the state machine moves."""

    @property
    def is_there(self) -> bool:
        """Initialised: it can say what state it is in."""

    @property
    def is_ready(self) -> bool:
        """Power is there, and nothing hinders enabling."""

    @property
    def is_following(self) -> bool:
        """Enabled, and set values are followed."""

    @property
    def is_moving_by_itself(self) -> bool:
        """It stops on its own and follows nothing until it stands."""

    @property
    def is_at_rest(self) -> bool:
        """A ramp that was begun is over."""

    @property
    def error(self) -> int:
        """What is wrong, as for 603Fh; 0: nothing."""

    @property
    def options(self) -> Options: ...

    def enable(self) -> None: ...

    def disable(self) -> None: ...

    def brake(self, ramp: Ramp) -> None:
        """Bring the axis to rest, and keep it there."""

    def go_on(self) -> None:
        """Set values count again, after a ramp."""

    def reset_fault(self, done: Callable[[], None]) -> None:
        """Take away what is wrong, if its cause is gone; may take its time."""
