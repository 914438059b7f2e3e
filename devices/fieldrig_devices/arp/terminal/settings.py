"""Settings of an operator terminal in a rig file."""

from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import Any, Final

from pydantic import Field, field_validator

from fieldrig.settings import Claim, Settings
from fieldrig_devices.arp.terminal.editor import LONGEST_PASSWORD
from fieldrig_devices.arp.terminal.panel import Model
from fieldrig_devices.arp.terminal.pattern import Decimals
from fieldrig_devices.canopen.described import DescribedNode
from fieldrig_devices.canopen.node import CanopenSettings
from fieldrig_devices.canopen.time_of_day import EPOCH

EDS: Final = Path(__file__).with_name("terminal.eds")
_PRODUCT_CODES: Final[dict[Model, int]] = {"TR4": 4, "TR5": 5}


class TerminalSettings(Settings):
    model: Model = Field(default="TR4", description="model, which determines the keys and LEDs")
    node_id: int = Field(default=20, ge=1, le=127, description="node-ID; the card's @Par[8] must have the same value")
    password: str = Field(
        default="0000",
        pattern=rf"^[0-9]{{1,{LONGEST_PASSWORD}}}$",
        description="password of fields in mode P, in digits",
    )
    time: str = Field(
        default=EPOCH.isoformat(),
        description="clock at power-on, such as 2026-11-21T10:00:00; a TIME message sets it too",
    )
    decimals: Decimals = Field(
        default="cut", description="how excess decimals of a value are removed: cut off or rounded (digest 16)"
    )

    def claims(self, device: str) -> Iterator[Claim]:
        yield Claim("can", "node-ID", self.node_id, ("node_id",))

    @field_validator("time")
    @classmethod
    def _is_time(cls, value: str) -> str:
        try:
            days = (datetime.fromisoformat(value).replace(tzinfo=None) - EPOCH).days
        except ValueError as cause:
            raise ValueError(f"{value!r} is not a time; expected a time such as 2026-11-21T10:00:00") from cause
        if not 0 <= days <= 0xFFFF:
            raise ValueError(f"{value!r} is out of range; expected a time within 65536 days from 1984-01-01")
        return value

    def canopen_nodes(self) -> Iterator[DescribedNode]:
        node = self.canopen
        yield DescribedNode(node.node_id, node.eds, node.objects)

    @property
    def canopen(self) -> CanopenSettings:
        objects: dict[str, Any] = {"1008:00": self.model, "1018:02": _PRODUCT_CODES[self.model]}
        return CanopenSettings(node_id=self.node_id, eds=EDS, signals={}, objects=objects)
