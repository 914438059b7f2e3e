"""The HTTP API of the points of devices: read and write, as `fieldrig get` and `fieldrig set` do."""

from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from fieldrig.device import Value
from fieldrig.text.nearest import closest
from fieldrig_page.api import Call, GivenValue, Operation, known
from fieldrig_page.guard import DeniedError
from fieldrig_page.long_wholes import as_given
from fieldrig_page.rig_link import RigLink

DEVICE = "name of a device"
POINT = "key of the point, such as level or 6200:01"


class NewValue(BaseModel):
    """The new value of a point."""

    model_config = ConfigDict(extra="forbid")
    value: GivenValue = Field(description="a number, a text, true or false; a whole number beyond 2^53 may be a text")


class Point(BaseModel):
    """A point of a device."""

    model_config = ConfigDict(extra="allow")
    key: str
    value: GivenValue
    unit: str = Field(description="its unit, or an empty text")


def operations(link: RigLink) -> Iterator[Operation]:
    """Yield the operations on points."""

    async def points(call: Call) -> list[dict[str, Any]]:
        device = known(call.path["name"], link.config.devices, "device")
        facts = await link.ask(f"device/{device}/keys")
        values = await link.ask(f"device/{device}/get")
        return [{"key": key, "value": values[key], **facts[key]} for key in facts if key in values]

    async def point(call: Call) -> dict[str, Any]:
        device, key = known(call.path["name"], link.config.devices, "device"), call.path["key"]
        facts = await link.ask(f"device/{device}/keys")
        if key not in facts:
            raise DeniedError(404, f"{device} has no value {key!r}", closest(key, list(facts)))
        values = await link.ask(f"device/{device}/get", {"keys": [key]})
        return {"key": key, "value": values[key], **facts[key]}

    async def set_point(call: Call) -> dict[str, Value]:
        device, key = known(call.path["name"], link.config.devices, "device"), call.path["key"]
        value = await as_given(link, device, key, call.body.value)
        values = await link.ask(f"device/{device}/set", {"values": {key: value}})
        return {"value": values[key]}

    names = {"name": DEVICE, "key": POINT}
    yield Operation(
        "GET",
        "devices/{name}/points",
        "Return all points of a device with their values.",
        points,
        gives=list[Point],
        parameters={"name": DEVICE},
    )
    yield Operation(
        "GET", "devices/{name}/points/{key:path}", "Return one point.", point, gives=Point, parameters=names
    )
    yield Operation(
        "PUT",
        "devices/{name}/points/{key:path}",
        "Write a point, and return its new value; a value that is refused is answered with 409.",
        set_point,
        NewValue,
        NewValue,
        names,
    )
