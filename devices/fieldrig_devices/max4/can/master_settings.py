"""What a rig file says about the MAx-4 as CANopen master, and what is in its file \\CANMA.CON."""

from collections.abc import Iterator
from typing import Annotated, Final, Literal, Self

from pydantic import Field, model_validator

from fieldrig.settings import ConfigFile, Settings
from fieldrig_devices.canopen.eds import reader as eds
from fieldrig_devices.canopen.managed_slave import Write
from fieldrig_devices.max4.configuration.files import Symbol
from fieldrig_devices.max4.field_data import Element

MOST_BITS: Final = 64
"""Of a PDO."""
Pdo = Annotated[int, Field(ge=1, le=4)]
Pdos = dict[Pdo, list[Element]]
ObjectValue = bool | int | float | str


class CanNodeSettings(Settings):
    """One slave."""

    node_id: int = Field(ge=1, le=127, description="node-ID")
    eds: ConfigFile | None = Field(default=None, description="says which types the objects under `sdo` have")
    heartbeat_ms: int = Field(default=100, ge=0, le=0xFFFF, description="written to 1017h; 0: it is not watched")
    limit_ms: int | None = Field(default=None, ge=1, description="silence that is a loss; null: two heartbeats")
    sdo: dict[str, ObjectValue] = Field(
        default_factory=dict,
        description="what is written before it is started: '1800:02': 255; without `eds` as bytes, '1800:02': 'ff'",
    )
    inputs: Pdos = Field(default_factory=dict, description="values in its TPDOs 1 to 4, lowest bits first")
    outputs: Pdos = Field(default_factory=dict, description="values in its RPDOs 1 to 4")
    ask: bool = Field(default=True, description="TPDOs are asked for by remote frames when it was started")
    lost_inputs: Literal["zero", "hold"] = Field(default="zero", description="what inputs of a lost node show")

    def configuration(self) -> list[Write]:
        """ValueError for an object that the EDS doesn't have, or that can't have this value."""
        return list(self._writes())

    def _writes(self) -> Iterator[Write]:
        dictionary = None if self.eds is None else eds.load(self.eds, self.node_id)
        for key, value in self.sdo.items():
            try:
                if dictionary is None:
                    yield _plain(key, value)
                else:
                    variable = dictionary.by_key(key)
                    variable.put(value)
                    yield Write(variable.index, variable.subindex, bytes(variable.data))
            except (KeyError, ValueError) as wrong:
                raise ValueError(f"sdo: {key}: {wrong}") from wrong

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        self.configuration()
        names: list[str] = []
        for pdos, kind in ((self.inputs, "TPDO"), (self.outputs, "RPDO")):
            for number, elements in pdos.items():
                bits = sum(one.form.bits for one in elements)
                if bits > MOST_BITS:
                    raise ValueError(f"{kind} {number}: {bits} bits, and {MOST_BITS} are the most")
                names += [one.name.casefold() for one in elements]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(f"values {', '.join(twice)}: each name once would be right")
        return self


class CanMasterSettings(Settings):
    node_id: int = Field(default=127, ge=1, le=127, description="its own, in its heartbeat")
    heartbeat_ms: int = Field(default=0, ge=0, le=0xFFFF, description="of its own; 0: none")
    sync_ms: int = Field(default=0, ge=0, le=10_000, description="period of its SYNC; 0: none")
    nodes: dict[Symbol, CanNodeSettings] = Field(default_factory=dict, description="slaves by symbolic name")

    @model_validator(mode="after")
    def _nodes_differ(self) -> Self:
        numbers = [self.node_id, *(node.node_id for node in self.nodes.values())]
        for number in numbers:
            if numbers.count(number) > 1:
                raise ValueError(f"node_id {number}: two nodes have it (the master is {self.node_id})")
        return self


def _plain(key: str, value: ObjectValue) -> Write:
    """Without an EDS: index and sub-index in hex, the value in bytes."""
    index, _, subindex = key.partition(":")
    if not isinstance(value, str):
        raise ValueError("its bytes in hex would be right, or an `eds` that says its type")
    number, sub, data = int(index, 16), int(subindex or "0", 16), bytes.fromhex(value)
    if not (0 <= number <= 0xFFFF and 0 <= sub <= 0xFF and data):
        raise ValueError("'1800:02': 'ff' would be right")
    return Write(number, sub, data)
