"""The HTTP API of the picture of a rig: what there is, and which place it has on a page of some width."""

from collections.abc import Iterator
from dataclasses import asdict
from typing import Any, Final

from fieldrig_page.api import Call, Operation
from fieldrig_page.graph import graph_of
from fieldrig_page.layout import columns_for, layout, partners_of
from fieldrig_page.rig_link import RigLink

USUAL_PX: Final = "1200"
WIDEST_PX: Final = 20_000


def operations(link: RigLink) -> Iterator[Operation]:
    """Yield the operations of the picture.  The rig file does not change, so neither does the graph."""
    graph = graph_of(link.config)
    picture = {**asdict(graph), "partners": {name: partners_of(graph, name) for name in graph.devices}}

    async def rig(_call: Call) -> dict[str, Any]:
        return picture

    async def places(call: Call) -> dict[str, Any]:
        width_px = int(call.query.get("width", USUAL_PX))
        if not 0 < width_px <= WIDEST_PX:
            raise ValueError(f"width={width_px}, expected 1 to {WIDEST_PX}")
        return asdict(layout(graph, columns_for(len(graph.devices), width_px)))

    yield Operation("GET", "rig", "Return the devices, buses and wires of the rig, and the order of its rings.", rig)
    yield Operation(
        "GET",
        "rig/layout",
        "Return the place of each device in the picture of the rig.",
        places,
        queries={"width": f"width of the picture in pixels; {USUAL_PX} without it"},
    )
