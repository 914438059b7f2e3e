"""Parts of the fronts of all drives: a shaft that turns, with its position, speed and torque."""

from fieldrig.front import Drawing, Gauge, Group, Number, Part


def shaft(point: str, unit_per_turn: float, about: str = "the shaft of the load") -> Drawing:
    """Return the drawing of a shaft whose position is a point; `unit_per_turn` is its value for a turn."""
    return Drawing("shaft", about=about, shape="shaft", roles={"angle": point}, scale={"turn": unit_per_turn})


def motion(position: Part, speed: tuple[str, float], torque: tuple[str, float] | None, drawing: Drawing) -> Group:
    """Return the group of a moving axis; speed and torque are points with the limits of their gauges."""
    gauges: list[Part] = [Gauge("speed", speed[0], low=-speed[1], high=speed[1], decimals=1)]
    if torque is not None:
        gauges.append(Gauge("torque", torque[0], low=-torque[1], high=torque[1], decimals=2))
    return Group([drawing, position, *gauges], "axis")


def position(decimals: int | None = None, low: float | None = None, high: float | None = None) -> Number:
    """Return the position as a number, or as a gauge if the axis has both limits."""
    if low is None or high is None:
        return Number("position", "position", decimals=decimals)
    return Gauge("position", "position", "between its limits", decimals=decimals, low=low, high=high)
