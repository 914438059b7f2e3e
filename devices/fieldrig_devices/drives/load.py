"""The load that a motor drives: its keys in a rig file, and the plant that it makes with the motor."""

from math import sqrt
from typing import Final, Self

from pydantic import ConfigDict, Field, model_validator

from fieldrig.settings import Settings, WrongKey, refuse_all
from fieldrig_devices.drives.loops import Elastic, Plant
from fieldrig_devices.drives.motor import MotorData

BANDWIDTH: Final = 400.0
"""Bandwidth to which the speed regulator is tuned, in rad/s."""


class LoadSettings(Settings):
    """The load that the motor drives."""

    model_config = ConfigDict(allow_inf_nan=False)

    gear_ratio: float = Field(default=1.0, gt=0, description="turns of the motor for one of the load")
    inertia_kg_m2: float = Field(default=0.0, ge=0, description="inertia of the load, behind the gear")
    viscous_nm_s_per_rad: float = Field(default=1e-4, ge=0, description="viscous friction at the motor")
    coulomb_nm: float = Field(default=0.0, ge=0, description="dry friction at the motor")
    torque_nm: float = Field(
        default=0.0, description="constant torque at the load, for example of a weight; positive acts backwards"
    )
    stiffness_nm_per_rad: float | None = Field(
        default=None, gt=0, description="stiffness of an elastic coupling, at the load; default: rigid"
    )
    damping_nm_s_per_rad: float = Field(default=0.0, ge=0, description="damping of the coupling")

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.stiffness_nm_per_rad is not None and not self.inertia_kg_m2:
            refuse_all([WrongKey(("stiffness_nm_per_rad",), "this needs a load", "expected inertia_kg_m2 above 0")])
        return self


def plant_of(load: LoadSettings, motor: MotorData) -> Plant:
    if load.stiffness_nm_per_rad is None:
        return Plant(all_inertia(load, motor), load.viscous_nm_s_per_rad)
    square = load.gear_ratio**2
    inertia, stiffness, damping = (
        value / square for value in (load.inertia_kg_m2, load.stiffness_nm_per_rad, load.damping_nm_s_per_rad)
    )
    return Plant(motor.inertia_kg_m2, load.viscous_nm_s_per_rad, elastic=Elastic(inertia, stiffness, damping))


def all_inertia(load: LoadSettings, motor: MotorData) -> float:
    """Return the inertia of motor and load, referred to the motor."""
    return motor.inertia_kg_m2 + load.inertia_kg_m2 / load.gear_ratio**2


def bandwidth(load: LoadSettings) -> float:
    """Return the bandwidth of the speed regulator, well below the resonance of an elastic coupling."""
    if load.stiffness_nm_per_rad is None:
        return BANDWIDTH
    return min(BANDWIDTH, 0.5 * sqrt(load.stiffness_nm_per_rad / load.inertia_kg_m2))
