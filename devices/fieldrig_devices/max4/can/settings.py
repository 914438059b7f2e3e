"""Settings of the CAN face of a MAx-4."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from fieldrig.settings import Settings
from fieldrig_devices.cia402.objects import AXES
from fieldrig_devices.max4.axis_inputs import SwitchSettings
from fieldrig_devices.max4.configuration.files import Symbol


class AxisTerminals(SwitchSettings):
    """Digital inputs and outputs of the controller that belong to an axis, by their symbolic names."""

    home: str = Field(default="", description="input: home switch (bit 2)")
    inputs: list[Symbol] = Field(
        default_factory=list, max_length=16, description="inputs shown in 60FDh from bit 16 up"
    )
    outputs: list[Symbol] = Field(
        default_factory=list, max_length=16, description="outputs set by 60FEh from bit 16 up"
    )

    @property
    def all_inputs(self) -> dict[int, str]:
        """Names of the inputs by bit."""
        home = {2: self.home} if self.home else {}
        return self.switches | home | dict(enumerate(self.inputs, 16))

    @property
    def all_outputs(self) -> dict[int, str]:
        """Names of the outputs by bit."""
        return dict(enumerate(self.outputs, 16))


class CanFaceSettings(Settings):
    """Settings of all nodes."""

    node_ids: Annotated[
        list[Annotated[int, Field(ge=1, le=127)]],
        Field(min_length=1, max_length=16, description="node-IDs; the nodes take the axes in the order of the drives"),
    ]
    axes_per_node: int = Field(default=AXES, ge=1, le=AXES, description="number of axes per node; CiA 402-3 allows 8")
    terminals: dict[Symbol, AxisTerminals] = Field(
        default_factory=dict, description="inputs and outputs by the symbolic names of the axes"
    )
    objects: dict[str, bool | int | float | str] = Field(
        default_factory=dict,
        description="power-on values of all nodes that replace those of the EDS, such as '1017:00': 500",
    )

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if len(set(self.node_ids)) < len(self.node_ids):
            raise ValueError("node_ids: expected each node-ID once, but one is used twice")
        return self
