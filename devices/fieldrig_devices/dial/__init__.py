"""The client of `fieldrig dial`, which calls a controller by modem, PPP and the stack of `ip`."""

from typing import TYPE_CHECKING

from fieldrig.lazy import lazy_names

__all__ = [
    "Caller",
    "Login",
    "Plan",
]

if TYPE_CHECKING:
    from fieldrig_devices.dial.caller import Caller, Plan
    from fieldrig_devices.ppp.settings import Login
else:
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "fieldrig_devices.dial.caller": "Caller Plan",
            "fieldrig_devices.ppp.settings": "Login",
        },
    )
