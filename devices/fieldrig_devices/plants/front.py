"""The fronts of the plants: one plain drawing each, and the numbers beside it."""

from collections.abc import Iterable, Sequence
from math import tau

from fieldrig.front import Clamp, Drawing, Front, Gauge, Group, Key, Knob, Led, Number, Part, Plate, Switch
from fieldrig_devices.motion.front import shaft


def tank(height_m: float, high_m: float, low_m: float) -> Front:
    scale = {"height": height_m, "high": high_m, "low": low_m}
    roles = {"level": "level", "inflow": "inflow", "outflow": "outflow", "leak": "leak"}
    return _plant(
        "tank",
        [
            Drawing("tank", about="level of the water", shape="tank", roles=roles, scale=scale),
            Knob("level", "level", "of the water above the outlet", low=0.0, high=height_m, decimals=3),
            Gauge("outlet", "outlet", "opening of its valve", decimals=0),
            Number("inflow", "inflow", "from the pump", decimals=5),
            Number("outflow", "outflow", "through the outlet", decimals=5),
            Led("high", "high", "the switch for a high level", colour="yellow"),
            Led("low", "low", "the switch for a low level", colour="yellow"),
            Number("overflows", "overflows", "number of overflows"),
        ],
    )


def winder(core_m: float, full_m: float, has_dancer: bool) -> Front:
    roles = {"radius": "radius", "angle": "position", "speed": "line_speed", "broken": "break_web"}
    roles |= {"dancer": "dancer"} if has_dancer else {}
    scale = {"core": core_m, "full": full_m}
    states = ((False, "whole"), (True, "broken"))
    return _plant(
        "winder",
        [
            Drawing(
                "roll",
                about="the roll and its web",
                shape="winder",
                roles=roles,
                scale=scale,
            ),
            Number("tension", "tension", "of the web", decimals=1),
            Number("radius", "radius", "of the roll", decimals=4),
            Number("length", "length", "of the web on the roll", decimals=1),
            Number("speed", "speed", "of the roll", decimals=2),
            Number("line speed", "line_speed", decimals=3),
            Switch(
                "web",
                "break_web",
                "breaks the web, or threads a new one",
                positions=states,
            ),
        ],
    )


def conveyor(length_m: float, product_m: float, sensors: dict[str, float]) -> Front:
    roles = {"position": "position", "fronts": "fronts", **{f"sensor.{name}": name for name in sensors}}
    scale = {"length": length_m, "product": product_m, **{f"sensor.{name}": at_m for name, at_m in sensors.items()}}
    return _plant(
        "conveyor",
        [
            Drawing("belt", about="the belt with its products", shape="conveyor", roles=roles, scale=scale),
            Number("way", "position", "of the belt since the start", decimals=3),
            Number("speed", "speed", "of the belt", decimals=3),
            *(Led(name, name, "light barrier", colour="red") for name in sensors),
            Number("products", "products", "on the belt"),
            Number("fed", "fed"),
            Number("discharged", "discharged"),
            Key("Feed", "feed", "puts a product on the belt"),
        ],
    )


def servo(switches: Sequence[Part] = ()) -> Front:
    """Return the front of a servo axis."""
    return _plant(
        "servo axis",
        [
            shaft("position", tau),
            Number("position", "position", "of the load", decimals=3),
            Number("speed", "speed", "of the load", decimals=2),
            Number("torque", "torque", "of the motor", decimals=3),
            Gauge("reference", "reference", "to the amplifier", low=-10.0, high=10.0, decimals=2),
            Led("brake", "brake", "the brake is applied", colour="yellow"),
            Led("stop", "at_stop", "the load is at a stop", colour="red"),
            Switch("blocked", "blocked", "the axis is jammed"),
            Knob("load torque", "load_torque", "external, at the load"),
            *switches,
        ],
    )


def pulse_axis(title: str, extra: Iterable[Part]) -> Front:
    """Return the front of an axis that follows pulses, with a reset button on its drive."""
    return _plant(
        title,
        [
            shaft("position", tau),
            Number("position", "position", "of the load", decimals=3),
            Number("speed", "speed", "of the load", decimals=2),
            *extra,
            Led("ready", "ready", "the ready contact"),
            Led("enabled", "enabled", "by its input"),
            Led("alarm", "alarm", "of the drive", colour="red"),
            Key("Reset", "reset", "clears the alarm"),
        ],
    )


def stepper() -> Front:
    extra = [
        Number("frequency", "frequency", "of the pulses", decimals=0),
        Number("lost", "lost", "received, but not followed by the motor"),
        Led("in step", "in_step", "the motor follows, or would"),
        Knob("load torque", "load_torque", "external, at the load"),
    ]
    return pulse_axis("stepper", extra)


def pulse_servo() -> Front:
    extra = [
        Number("command", "command", "wanted position"),
        Number("error", "error", "following error"),
        Led("in position", "in_position", "the error is within the window, and no pulses come"),
    ]
    return pulse_axis("servo drive with a pulse input", extra)


def heater(limit_degc: float | None) -> Front:
    scale = {} if limit_degc is None else {"limit": limit_degc}
    roles = {"temperature": "temperature", "duty": "duty"}
    return _plant(
        "heater",
        [
            Drawing("body", about="the heated body", shape="heater", roles=roles, scale=scale),
            Number("temperature", "temperature", decimals=1),
            Gauge("duty", "duty", "of the input", decimals=0),
            Number("power", "power", decimals=0),
            Led("over", "over", "above the limit", colour="red"),
            Knob("load", "load", "heat that is taken away"),
        ],
    )


def dc_motor(zero_from: float | None, zero_to: float) -> Front:
    scale = {"to": zero_to} | ({} if zero_from is None else {"from": zero_from})
    roles = {"position": "position", "zero": "zero"}
    return _plant(
        "DC motor",
        [
            Drawing("slide", about="the slide", shape="slide", roles=roles, scale=scale),
            Number("position", "position", "of the shaft", decimals=1),
            Number("speed", "speed", decimals=1),
            Number("direction", "direction", "that the contacts give"),
            Led("pulse", "pulse", "level of the sensor", colour="yellow"),
            Led("zero", "zero", "the zero switch is closed"),
        ],
    )


def cam_switches(names: Iterable[str]) -> Front:
    return _plant(
        "cam switches",
        [
            Number("position", "position", "of the shaft or slide", decimals=3),
            *(Clamp(name, name, "closed by its cam", side="out") for name in names),
        ],
    )


def _plant(model: str, parts: Sequence[Part]) -> Front:
    return Front(Plate("", model), [Group(parts)])
