"""How a bus model runs in virtual and in real time."""

from collections.abc import Callable, Mapping
from typing import Final

from fieldrig.text.svg import Drawing

TEXT: Final = ("name", "tiny")


def two_clocks() -> str:
    """The same device and bus model under the scheduler of a rig, and under a hub."""
    about = (
        "In virtual time the rig calls devices and bus models in one process. In real time each device has a process "
        "that is attached to a hub, and outside programs connect to the ports of the hub."
    )
    drawing = Drawing(880, "A bus model under two clocks", about)
    drawing.text(200, 30, "virtual time: one process", "small", "middle")
    drawing.text(650, 30, "real time: a process per device and hub", "small", "middle")
    box(drawing, "outside", 20, 50, 360, 150, "rig", "the scheduler: moves the clock to the next event", 20)
    box(drawing, "device", 40, 110, 90, 70, "device", "reacts", 32)
    box(drawing, "bus", 155, 110, 90, 70, "BusModel", "submit, collect", 32)
    box(drawing, "device", 270, 110, 90, 70, "device", "reacts", 32)
    drawing.line("line", [(130, 145), (155, 145)])
    drawing.line("line", [(245, 145), (270, 145)])
    box(drawing, "device", 420, 110, 110, 70, "device", "event loop, clock", 32)
    box(drawing, "outside", 580, 50, 150, 150, "hub", "event loop, clock", 20)
    box(drawing, "bus", 605, 110, 100, 70, "BusModel", "submit, collect", 32)
    box(drawing, "device", 420, 210, 110, 60, "device", "event loop, clock", 26)
    box(drawing, "outside", 765, 110, 108, 70, "your master", "socketcand, TCP", 32)
    drawing.line("line", [(530, 145), (605, 145)])
    drawing.line("line", [(530, 240), (655, 240), (655, 180)])
    drawing.line("line", [(705, 145), (765, 145)])
    drawing.text(555, 138, "socket", "tiny halo", "middle")
    drawing.text(748, 138, "port", "tiny halo", "middle")
    return drawing.render(290)


def box(
    drawing: Drawing, style: str, x: float, y: float, width: float, height: float, name: str, about: str, base: float
) -> None:
    """A box with its name at `base` below its upper edge and a smaller line under it."""
    drawing.rect(style, x, y, width, height, radius=6)
    for row, (text, text_style) in enumerate(zip((name, about), TEXT, strict=True)):
        drawing.text(x + width / 2, y + base + 16 * row, text, text_style, "middle")


PICTURES: Final[Mapping[str, Callable[[], str]]] = {"two-clocks": two_clocks}
