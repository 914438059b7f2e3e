"""The keys and the faults of a conveyor in a rig file."""

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Final, Literal, Self

from pydantic import Field, model_validator

from fieldrig.faults.faults import Timed, models_of
from fieldrig.settings import Claim
from fieldrig_devices.plants.settings import PlantSettings

MOST_PRODUCTS: Final = 1000


class SensorSettings(PlantSettings):
    """A light barrier across the belt."""

    at_m: float = Field(ge=0, description="its place along the belt, from the feed end")
    wire: str | None = Field(
        default=None, description="output: digital, true while a product covers it; default: NAME.SENSOR"
    )


class ConveyorSettings(PlantSettings):
    length_m: float = Field(gt=0, description="from the feed end to the discharge end")
    roller_radius_m: float = Field(gt=0, description="radius of the driven roller")
    drive_wire: str = Field(description="input: position of the driven roller, rad")
    product_m: float = Field(gt=0, description="length of a product")
    pitch_m: float | None = Field(
        default=None, gt=0, description="way of the belt after which the feeder puts the next product on it"
    )
    sensors: dict[str, SensorSettings] = Field(default={}, description="light barriers by name")
    feed_wire: str | None = Field(
        default=None, description="input: digital, a rising edge puts a product on the belt; default: NAME.feed"
    )
    discharge_wire: str | None = Field(
        default=None, description="output: number of products that left at the discharge end; default: NAME.discharge"
    )

    @model_validator(mode="after")
    def _fits(self) -> Self:
        for name, sensor in self.sensors.items():
            if sensor.at_m > self.length_m:
                raise ValueError(
                    f"sensors.{name}.at_m: expected at most {self.length_m:g} (length_m), got {sensor.at_m:g}"
                )
        if self.pitch_m is not None and self.pitch_m < self.product_m:
            raise ValueError(f"pitch_m: expected at least {self.product_m:g} (product_m), got {self.pitch_m:g}")
        if self.length_m / self.product_m > MOST_PRODUCTS:
            raise ValueError(f"product_m: expected room for at most {MOST_PRODUCTS} products on length_m")
        return self

    def wire_of(self, device: str, sensor: str) -> str:
        return self.sensors[sensor].wire or f"{device}.{sensor}"

    def claims(self, device: str) -> Iterator[Claim]:
        for name in self.sensors:
            yield Claim("wires", "wire", self.wire_of(device, name), ("sensors", name))
        yield Claim("wires", "wire", self.wire_for(device, "discharge"), ("discharge_wire",))


class Slip(Timed):
    """Products slip: they move less than the belt."""

    what: Literal["slip"]
    percent: float = Field(default=100.0, gt=0, le=100, description="part of the belt's way that they lose")
    product: int | None = Field(default=None, ge=1, description="number of the product, as fed; default: all")


class Dirty(Timed):
    """A sensor is dirty, or its mirror is gone, and always shows the same."""

    what: Literal["dirty"]
    sensor: str = Field(description="name of the sensor")
    shows: bool = Field(default=True, description="true: as if covered; false: as if free")


ConveyorFault = Annotated[Slip | Dirty, Field(discriminator="what")]
MODELS: Final[Mapping[str, type[Any]]] = models_of(ConveyorFault)
