"""What a rig file says about the CAN face of a MAx-4."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from fieldrig.settings import Settings
from fieldrig_devices.cia402.objects import AXES
from fieldrig_devices.max4.configuration import Symbol


class AxisTerminals(Settings):
    """Digital inputs and outputs of the controller that belong to an axis, by their symbolic names."""

    negative_limit: str = Field(default="", description="input: negative limit switch (60FDh bit 0)")
    positive_limit: str = Field(default="", description="input: positive limit switch (bit 1)")
    home: str = Field(default="", description="input: home switch (bit 2)")
    inputs: list[Symbol] = Field(default_factory=list, max_length=16, description="60FDh from bit 16 on")
    outputs: list[Symbol] = Field(default_factory=list, max_length=16, description="60FEh from bit 16 on")

    @property
    def all_inputs(self) -> dict[int, str]:
        """By their bits."""
        switches = {0: self.negative_limit, 1: self.positive_limit, 2: self.home}
        named = switches | dict(enumerate(self.inputs, 16))
        return {bit: symbol for bit, symbol in named.items() if symbol}

    @property
    def all_outputs(self) -> dict[int, str]:
        return dict(enumerate(self.outputs, 16))


class CanFaceSettings(Settings):
    node_ids: Annotated[
        list[Annotated[int, Field(ge=1, le=127)]],
        Field(min_length=1, max_length=16, description="of the nodes; axes are dealt out in the order of the drives"),
    ]
    axes_per_node: int = Field(default=AXES, ge=1, le=AXES, description="CiA 402-3 has room for 8")
    terminals: dict[Symbol, AxisTerminals] = Field(
        default_factory=dict, description="inputs and outputs of axes, by the symbolic names of the axes"
    )
    objects: dict[str, bool | int | float | str] = Field(
        default_factory=dict, description="power-on values other than the EDS's of all nodes, such as '1017:00': 500"
    )

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if len(set(self.node_ids)) < len(self.node_ids):
            raise ValueError("node_ids: one is there twice; each node needs its own")
        return self
