"""`/metrics`: figures of the rig for Prometheus, in its text format.

Source: prometheus.io/docs/instrumenting/exposition_formats, text format 0.0.4.  Names end with their unit, in base
units.  What a kind of bus counts has the name that it has in `fieldrig status`, and no type, as only the bus knows
whether it can fall.
"""

import re
from collections.abc import Container, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from fieldrig.errors import ControlError
from fieldrig_page.live import Live
from fieldrig_page.part_faults import is_active
from fieldrig_page.rig_link import RigLink

TYPE: Final = "text/plain; version=0.0.4; charset=utf-8"
PREFIX: Final = "fieldrig"


@dataclass(frozen=True, slots=True)
class Sample:
    """One figure."""

    name: str
    value: float
    labels: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True, slots=True)
class Family:
    """The description of all samples of one name."""

    about: str
    type: str = "gauge"


BASE_UNITS: Final = {
    "_percent": ("_ratio", 1e2),
    "_ms": ("_seconds", 1e3),
    "_us": ("_seconds", 1e6),
    "_ns": ("_seconds", 1e9),
}
"""The base unit in the place of a unit at the end of a figure of a bus, and how many of that unit are one of it."""
FAMILIES: Final[Mapping[str, Family]] = {
    "up": Family("1 if the rig answers"),
    "ready": Family("1 if every process of the rig is ready"),
    "uptime_seconds": Family("time since the rig was started"),
    "virtual_time_seconds": Family("the rig's own time; only in virtual time"),
    "process_ready": Family("1 if the process is ready"),
    "process_restarts_total": Family("restarts of the process", "counter"),
    "process_memory_bytes": Family("memory of the process, with what it shares with others"),
    "process_cpu_seconds_total": Family("processor time of the process", "counter"),
    "process_lateness_worst_seconds": Family("largest lateness since the process began"),
    "process_late": Family("1 while the host is late for the process"),
    "faults_active": Family("injected faults that act on the part now"),
    "page_sockets": Family("pages that are open"),
    "page_restarts_total": Family("restarts of the page's process", "counter"),
    "page_frames_left_out_total": Family("frames that pages were too slow for", "counter"),
}


def routes(link: RigLink, live: Live) -> Iterator[Route]:
    """Yield the route of the figures."""

    async def metrics(_request: Request) -> Response:
        return Response(text(await samples(link, live)), headers={"content-type": TYPE})

    yield Route("/metrics", metrics)


async def samples(link: RigLink, live: Live) -> list[Sample]:
    """Return all figures of this moment; only `fieldrig_up` and those of the page if the rig does not answer."""
    page = [Sample("page_sockets", len(live.pages)), Sample("page_frames_left_out_total", live.left_out)]
    try:
        rig = await link.recent("rig/status")
        processes = await link.recent("process/*/brief")
        buses = await link.recent("bus/*/status")
        faults = {**await link.recent("device/*/faults"), **await link.recent("bus/*/faults")}
    except ControlError:
        return [Sample("up", 0), *page]
    return [
        Sample("up", 1),
        *_of_rig(rig),
        *(sample for name, process in rig["processes"].items() for sample in _of_process(name, process)),
        *(sample for name, details in processes.items() for sample in _of_details(name, details)),
        *(sample for name, statistics in buses.items() for sample in _of_bus(name, statistics, link.config.devices)),
        *(
            Sample("faults_active", sum(map(is_active, found.values())), (("part", name),))
            for name, found in faults.items()
        ),
        *page,
    ]


def _of_rig(rig: Mapping[str, Any]) -> Iterator[Sample]:
    yield Sample("ready", rig["state"] in ("ready", "paused"))
    yield Sample("uptime_seconds", rig["uptime_s"])
    if "now_ns" in rig:
        yield Sample("virtual_time_seconds", rig["now_ns"] / 1e9)
    if "ui" in rig:
        yield Sample("page_restarts_total", rig["ui"]["restarts"])


def _of_process(name: str, process: Mapping[str, Any]) -> Iterator[Sample]:
    labels = (("process", name),)
    yield Sample("process_ready", process["state"] == "ready", labels)
    yield Sample("process_restarts_total", process["restarts"], labels)


def _of_details(name: str, details: Mapping[str, Any]) -> Iterator[Sample]:
    labels = (("process", name),)
    yield Sample("process_memory_bytes", details["memory_mb"] * 1e6, labels)
    yield Sample("process_cpu_seconds_total", details["cpu_s"], labels)
    if "late" in details:
        yield Sample("process_late", bool(details["late"]["words"]), labels)
        yield Sample("process_lateness_worst_seconds", details["late"]["worst_ms"] / 1e3, labels)


def _of_bus(name: str, statistics: Mapping[str, float], devices: Container[str]) -> Iterator[Sample]:
    """Yield the statistics of a bus; those of a member (`io.tec`, or on a ring `late.film`) have it as a label.

    What a ring counts of a member has a name of its own, as it counts the same of all of them together.
    """
    for key, value in statistics.items():
        member, _, figure = key.rpartition(".")
        of_all, _, last = key.partition(".")
        if last in devices and member not in devices:
            member, figure = last, f"member_{of_all}"
        labels = (("bus", name), *((("member", member),) if member else ()))
        unit = next((unit for unit in BASE_UNITS if figure.endswith(unit)), "")
        base, size = BASE_UNITS.get(unit, ("", 1))
        yield Sample(f"bus_{_safe(figure.removesuffix(unit) + base)}", value / size, labels)


def text(found: Iterable[Sample]) -> str:
    """Return samples in the text format, those of one name together."""
    by_name: dict[str, list[Sample]] = {}
    for sample in found:
        by_name.setdefault(sample.name, []).append(sample)
    return "".join(line for name, family in by_name.items() for line in _lines(name, family))


def _lines(name: str, family: list[Sample]) -> Iterator[str]:
    about = FAMILIES.get(
        name, Family(f"{name.removeprefix('bus_')} of the bus, as `fieldrig status` has it", "untyped")
    )
    yield f"# HELP {PREFIX}_{name} {about.about}\n# TYPE {PREFIX}_{name} {about.type}\n"
    for sample in family:
        labels = ",".join(f'{label}="{_quoted(value)}"' for label, value in sample.labels)
        yield f"{PREFIX}_{name}{f'{{{labels}}}' if labels else ''} {float(sample.value)!r}\n"


def _safe(name: str) -> str:
    """Return a name with only the characters that the format allows."""
    return re.sub(r"[^a-zA-Z0-9_]", "_", name)


def _quoted(value: str) -> str:
    return value.replace("\\", r"\\").replace('"', r"\"").replace("\n", r"\n")
