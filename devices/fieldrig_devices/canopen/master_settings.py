"""Settings of a controller as a CANopen master; those of a MAx-4 are also the content of its file \\CANMA.CON."""

from collections.abc import Iterator
from typing import Annotated, Final, Literal, Self

from pydantic import Field, model_validator

from fieldrig.settings import ConfigFile, Settings
from fieldrig_devices.canopen.eds import reader as eds
from fieldrig_devices.canopen.managed_slave import Write
from fieldrig_devices.registers.packed import CellName, Element

MOST_BITS: Final = 64
"""Size of a PDO in bits."""
Pdo = Annotated[int, Field(ge=1, le=4)]
Pdos = dict[Pdo, list[Element]]
ObjectValue = bool | int | float | str


class CanNodeSettings(Settings):
    """Settings of one slave."""

    node_id: int = Field(ge=1, le=127, description="node-ID")
    eds: ConfigFile | None = Field(default=None, description="EDS with the types of the objects under `sdo`")
    heartbeat_ms: int = Field(
        default=100, ge=0, le=0xFFFF, description="heartbeat time, written to 1017h; 0: no supervision"
    )
    limit_ms: int | None = Field(
        default=None, ge=1, description="time without a heartbeat after which the slave is lost; null: two heartbeats"
    )
    sdo: dict[str, ObjectValue] = Field(
        default_factory=dict,
        description="values written before the slave starts, '1800:02': 255; without `eds` as bytes, '1800:02': 'ff'",
    )
    inputs: Pdos = Field(default_factory=dict, description="values in its TPDOs 1 to 4, lowest bits first")
    outputs: Pdos = Field(default_factory=dict, description="values in its RPDOs 1 to 4")
    ask: bool = Field(default=True, description="whether TPDOs are requested with remote frames after the slave starts")
    lost_inputs: Literal["zero", "hold"] = Field(
        default="zero", description="values of the inputs of a lost slave: 0, or the last ones"
    )

    def configuration(self) -> list[Write]:
        """The writes before the slave starts.  ValueError for an object that is not in the EDS, or a wrong value."""
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
                bits = sum(element.form.bits for element in elements)
                if bits > MOST_BITS:
                    raise ValueError(f"{kind} {number}: expected at most {MOST_BITS} bits, got {bits}")
                names += [element.name.casefold() for element in elements]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(f"values: expected each name once, got {', '.join(twice)} several times")
        return self


class CanMasterSettings(Settings):
    node_id: int = Field(default=127, ge=1, le=127, description="node-ID of the master, for its heartbeat")
    heartbeat_ms: int = Field(default=0, ge=0, le=0xFFFF, description="period of the heartbeat of the master; 0: none")
    sync_ms: int = Field(default=0, ge=0, le=10_000, description="period of SYNC; 0: none")
    nodes: dict[CellName, CanNodeSettings] = Field(default_factory=dict, description="slaves by name")

    @model_validator(mode="after")
    def _nodes_differ(self) -> Self:
        numbers = [self.node_id, *(node.node_id for node in self.nodes.values())]
        for number in numbers:
            if numbers.count(number) > 1:
                raise ValueError(
                    f"node_id {number}: expected each node-ID once, but it is used twice (master: {self.node_id})"
                )
        return self


def _plain(key: str, value: ObjectValue) -> Write:
    """A write without an EDS: index and sub-index in hex, the value in bytes."""
    index, _, subindex = key.partition(":")
    if not isinstance(value, str):
        raise ValueError("expected the bytes in hex, or an `eds` with the type")
    number, sub, data = int(index, 16), int(subindex or "0", 16), bytes.fromhex(value)
    if not (0 <= number <= 0xFFFF and 0 <= sub <= 0xFF and data):
        raise ValueError("expected an object and bytes, such as '1800:02': 'ff'")
    return Write(number, sub, data)
