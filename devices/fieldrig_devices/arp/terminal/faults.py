"""The faults of an operator terminal: those of its CANopen node, and a key that sticks."""

from collections.abc import Mapping
from typing import Any, Final, Literal

from pydantic import Field

from fieldrig.faults.faults import Timed
from fieldrig_devices.canopen.node_faults import MODELS as NODE_MODELS


class StuckKey(Timed):
    """A key sticks: the terminal takes it for pressed, or for released, whatever the operator does."""

    what: Literal["stuck_key"]
    key: str = Field(description="name of the key, such as F1")
    pressed: bool = Field(default=True, description="true: as pressed; false: as released")


OWN: Final[Mapping[str, type[Any]]] = {"stuck_key": StuckKey}
MODELS: Final[Mapping[str, type[Any]]] = {**OWN, **NODE_MODELS}
