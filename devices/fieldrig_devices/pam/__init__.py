"""The Socapel PAM axes manager, release 2.5 (manual 006.8007.B)."""

from typing import TYPE_CHECKING

from fieldrig.lazy import lazy_names

__all__ = [
    "Memory",
    "Ports",
    "Rs422Master",
    "VmeMaster",
    "carry_out",
    "checked",
    "ports_of",
]

if TYPE_CHECKING:
    from fieldrig_devices.pam.language.compiler import checked
    from fieldrig_devices.pam.language.ports import ports_of
    from fieldrig_devices.pam.ports import Ports
    from fieldrig_devices.pam.ports.masters.rs422 import Rs422Master
    from fieldrig_devices.pam.ports.masters.script import carry_out
    from fieldrig_devices.pam.ports.masters.vme import VmeMaster
    from fieldrig_devices.pam.ports.memory import Memory
else:
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "fieldrig_devices.pam.language.compiler": "checked",
            "fieldrig_devices.pam.language.ports": "ports_of",
            "fieldrig_devices.pam.ports": "Ports",
            "fieldrig_devices.pam.ports.masters.rs422": "Rs422Master",
            "fieldrig_devices.pam.ports.masters.script": "carry_out",
            "fieldrig_devices.pam.ports.masters.vme": "VmeMaster",
            "fieldrig_devices.pam.ports.memory": "Memory",
        },
    )
