"""The HTTP API of the rig as a whole: what runs, and pause, run, step, stop and restart."""

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from fieldrig.control.messages import NoAnswerError
from fieldrig.control.rig_status import joined
from fieldrig.text.durations import duration_ns
from fieldrig_page.api import Call, Operation
from fieldrig_page.guard import DeniedError
from fieldrig_page.rig_link import RigLink


class Speed(BaseModel):
    """The speed of virtual time."""

    model_config = ConfigDict(extra="forbid")
    speed: Annotated[float, Field(gt=0)] | Literal["max"] | None = Field(
        None, description="virtual seconds per second, or max; without it the rig goes on at its last speed"
    )


class Step(BaseModel):
    """A step of virtual time."""

    model_config = ConfigDict(extra="forbid")
    duration: str = Field(alias="for", description="how long to run, such as 10 ms", examples=["10 ms"])


class Back(BaseModel):
    """A way back in virtual time."""

    model_config = ConfigDict(extra="forbid")
    to: str = Field(
        description="the instant of the rig that becomes the present, such as 12.34 s", examples=["12.34 s"]
    )


class Time(BaseModel):
    """The state of virtual time."""

    now_ns: int = Field(description="the rig's time in nanoseconds")
    is_paused: bool


def operations(link: RigLink) -> Iterator[Operation]:
    """Yield the operations of the rig as a whole."""

    async def status(_call: Call) -> dict[str, Any]:
        rig, details = await link.ask("rig/status"), await link.ask_all("process/*/status")
        return joined(rig, details, await link.ask("ui/status") if "ui" in rig else {})

    async def pause(_call: Call) -> Any:
        return await link.ask("rig/pause")

    async def run(call: Call) -> Any:
        speed: Speed = call.body
        if "speed" not in speed.model_fields_set:
            return await link.ask("rig/run")
        return await link.ask("rig/run", {"speed": None if speed.speed == "max" else speed.speed})

    async def step(call: Call) -> Any:
        duration: Step = call.body
        return await link.ask("rig/step", {"ns": duration_ns(duration.duration)}, LONGEST_STEP_S)

    async def back(call: Call) -> Any:
        instant: Back = call.body
        return await link.ask("rig/back", {"ns": duration_ns(instant.to)}, LONGEST_STEP_S)

    async def timeline(_call: Call) -> Any:
        try:
            return await link.ask("prelude/timeline")
        except NoAnswerError as cause:
            remedy = "`fieldrig scenario open FILE` starts one that has"
            raise DeniedError(404, "this rig has not been played a scenario", remedy) from cause

    async def stop(_call: Call) -> dict[str, Any]:
        await link.ask("rig/stop")
        return {}

    async def restart(call: Call) -> dict[str, Any]:
        await link.ask("rig/restart", {"name": call.path["name"]})
        return {}

    yield Operation("GET", "status", "Return what runs, as `fieldrig status --json` does.", status)
    yield Operation("POST", "rig/pause", "Pause virtual time.", pause, gives=Time)
    yield Operation("POST", "rig/run", "Let virtual time run, at a speed if one is given.", run, Speed, Time)
    yield Operation("POST", "rig/step", "Let virtual time run for a duration, then pause.", step, Step, Time)
    yield Operation("POST", "rig/back", "Make an instant of the past the present, and pause.", back, Back, Time)
    yield Operation(
        "GET",
        "timeline",
        "Return what a scenario did to the rig, its signals and violations.",
        timeline,
        is_absent_if="the rig has not been played a scenario",
    )
    yield Operation("POST", "rig/stop", "Stop the rig, and with it this page.", stop)
    yield Operation(
        "POST",
        "restart/{name}",
        "Switch a device off and on; start a process, or that of a bus or of a device that hangs, again.",
        restart,
        parameters={"name": "name of a process, device or bus"},
    )


LONGEST_STEP_S = 600.0
"""Time limit of a step, in seconds of the host."""
