"""Models of the keys of a rig file that do not belong to a kind."""

import json
from typing import Annotated, Any, Literal, TypeVar

from pydantic import Field, ValidationError

from fieldrig.bus import Time
from fieldrig.outside.addresses import DEFAULT_ENDPOINT, ENDPOINT
from fieldrig.outside.page_seat import DEFAULT_PAGE
from fieldrig.settings import Address, Settings

S = TypeVar("S", bound=Settings)

NAME = r"^[a-z][a-z0-9_-]*$"
SECTIONS = ("buses", "devices", "extends")
"""Keys of a rig file that are not in `RigKeys`."""

Name = Annotated[str, Field(pattern=NAME, examples=["rack-1"])]
OnExit = Literal["restart", "stop", "ignore"]
Names = str | list[str]


class PageKeys(Settings):
    """The keys of the page of a rig."""

    listen: Address | None = Field(
        default=None, description=f"host:port; without it {DEFAULT_PAGE}, or any free port if that is taken"
    )
    hosts: list[Address] = Field(
        default_factory=list, description="further names under which browsers reach it, as host:port"
    )


class RigKeys(Settings):
    """The keys of a rig file beside its sections."""

    time: Time = Field(description="real: the system's clock; virtual: a clock that the rig moves")
    name: Name | None = Field(None, description="name of the rig; without it the file's")
    seed: int = Field(0, description="all chance in the rig follows from it")
    speed: Annotated[float, Field(gt=0)] | Literal["max"] | None = Field(
        1.0, description="virtual seconds per second; only with time: virtual"
    )
    processes: Literal["one", "each"] | dict[Name, Names] = Field(
        "one",
        description="with time: real, the devices that share a process, as buses or patterns of names, by the name of"
        " the process; with time: virtual, one process for all devices, or one for each",
    )
    control: str = Field(
        DEFAULT_ENDPOINT,
        pattern=ENDPOINT,
        examples=[DEFAULT_ENDPOINT],
        description="Zenoh endpoint of the control service",
    )
    run: str | None = Field(
        None, min_length=1, description="folder for sockets, ptys, logs and memories; without it run/NAME"
    )
    ui: PageKeys | Literal[False] = Field(
        default_factory=lambda: PageKeys(), description="the page of the rig in a browser; false: none"
    )
    start_timeout_s: float = Field(10.0, gt=0, description="how long a process may make no progress while it starts")


class BusKeys(Settings):
    """The keys that every bus has beside the settings of its kind."""

    kind: str = Field(description='what it is: a kind that is installed, or "module:Class" of your own')
    process: Name | None = Field(None, description="process that runs its hub; without it one of its own")


class DeviceKeys(Settings):
    """The keys that every device has beside the settings of its kind."""

    kind: str = Field(description='what it is: a kind that is installed, or "module:Class" of your own')
    links: dict[str, Names] = Field(default_factory=dict, description="the bus, or the buses, at each of its links")
    process: Name | None = Field(None, description="process that it runs in; without it one of its own")
    on_exit: OnExit = Field("restart", description="what happens when its process dies")
    after: Names = Field(default_factory=list, description="device, or list of devices, that start before it")


def right_part(model: type[S], own: dict[Any, Any]) -> S | None:
    """Return an entry without its wrong keys, so that the settings of its kind can still be checked.

    None if its kind or links are wrong.
    """
    try:
        return model.model_validate_json(json.dumps(own))
    except ValidationError as wrong:
        bad = {error["loc"][0] for error in wrong.errors(include_url=False)}
        return None if bad & {"kind", "links"} else right_part(model, {key: own[key] for key in own.keys() - bad})


def as_tuple(names: Names) -> tuple[str, ...]:
    return tuple(names) if isinstance(names, list) else (names,)
