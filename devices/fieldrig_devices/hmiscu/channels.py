"""Uses of the two channels, and which of them exclude each other (SCU-001 to SCU-004, SCU-010, SCU-011)."""

from collections.abc import Iterator
from typing import Annotated, Final, Literal, Self

from pydantic import Field, model_validator

from fieldrig.settings import Settings, WrongKey, refuse_all
from fieldrig_devices.hmiscu.pto.settings import PtoSettings
from fieldrig_devices.hmiscu.pwm.settings import PwmSettings


class NotUsed(Settings):
    """A channel whose output belongs to the program."""

    mode: Literal["not_used"]


NOT_USED: Final = NotUsed(mode="not_used")

# The modes Not Used, PTO and PWM are described; Frequency Generator is only named once, so it is refused (S-28).
AnyUse = Annotated[PtoSettings | PwmSettings | NotUsed, Field(discriminator="mode")]
UseOfChannel1 = Annotated[PwmSettings | NotUsed, Field(discriminator="mode")]


class Channels(Settings):
    """The use of both channels.  A PTO on channel 0 uses both fast outputs, so channel 1 must be free."""

    channel_0: AnyUse = NOT_USED
    channel_1: UseOfChannel1 = NOT_USED

    @model_validator(mode="after")
    def _fits(self) -> Self:
        refuse_all(self._wrong())
        return self

    def _wrong(self) -> Iterator[WrongKey]:
        if self.channel_0.mode == "pto" and self.channel_1.mode != "not_used":
            remedy = "expected not_used, because the PTO of channel 0 uses both fast outputs"
            yield WrongKey(("channel_1", "mode"), "pwm is not possible here", remedy)
        names = [name.lower() for name in self.variables if name is not None]
        if len(set(names)) < len(names):
            yield WrongKey(("channel_1", "variable"), f"{self.variables[1]} is used twice", "expected another name")

    @property
    def variables(self) -> tuple[str | None, str | None]:
        """Return the names of the instances of both channels; None for a channel that is not used."""
        return _variable(self.channel_0, "PWM00"), _variable(self.channel_1, "PWM01")


def _variable(use: PtoSettings | PwmSettings | NotUsed, default: str) -> str | None:
    return None if isinstance(use, NotUsed) else use.variable or default
