"""The faults that can be injected into a PAM; `device.py` implements their effects."""

from collections.abc import Mapping
from typing import Final, Literal

from fieldrig.faults.faults import Timed


class PowerOff(Timed):
    """The PAM has no power; it starts again when the fault ends."""

    what: Literal["power_off"]


MODELS: Final[Mapping[str, type[Timed]]] = {"power_off": PowerOff}
