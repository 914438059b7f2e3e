"""The include files of a VME master in C: PAM_VME.H, PAM_DEF.H and VMECLASS.H.

Source: manual lines 9130 to 9173 and 9567 to 9581.  It prints the structures of the panel and of the whole memory; the
fields of the other two are named after its figures.
"""

from collections.abc import Mapping
from typing import Final

from fieldrig_devices.pam.language.ports import PortPlan
from fieldrig_devices.pam.ports.options import PortOptions
from fieldrig_devices.pam.ports.panel import VME_PANEL
from fieldrig_devices.pam.ports.vme.layout import Answer, Command, class_codes

_STRUCTURES: Final = {
    "S_header_fifo_dp_vme": ("fifo_offset", "head", "tail", "max_bloc_number", "bloc_size"),
    "S_port_cmd_host": ("command", "vme_parameter[3]", "acknowledge", "pam_parameter[5]"),
    "S_error_panel": ("mess_origin", "fatal_err_nb", "date", "time", "info_tag", "info_1", "info_2"),
}
_MEMORY: Final = """typedef struct {
    S_header_fifo_dp_vme header_fifo_in;
    S_header_fifo_dp_vme header_fifo_out;
    short watchdog;
    short synchro;
    S_port_cmd_host cmd_port;
    S_error_panel fatal_error_panel;
} S_dual_vme;"""
_CELLS: Final = ("MESS_ORIGIN", "MESS_NUMBER", "DATE", "TIME", "INFO_TAG", "INFO_1", "INFO_2")


def headers(plan: PortPlan, options: PortOptions) -> Mapping[str, str]:
    """Return the texts of the files by their names."""
    codes = {var_class.removesuffix("_VAR"): str(code) for var_class, code in class_codes(options.class_codes).items()}
    return {
        "PAM_VME.H": _defines(
            "CRC of each variable of the VME DualPort",
            {variable.name: f"0x{variable.crc:04X}" for variable in plan.variables},
        ),
        "PAM_DEF.H": _memory(),
        "VMECLASS.H": _defines(
            "Class codes of variables",
            {var_class.removesuffix("_VAR"): str(code) for var_class, code in codes.items()},
            "VME_CLASS_",
        ),
    }


def _memory() -> str:
    structures = [
        "\n".join(["typedef struct {", *(f"    short {field};" for field in fields), f"}} {name};"])
        for name, fields in _STRUCTURES.items()
    ]
    cells = {name: str(VME_PANEL + 2 * index) for index, name in enumerate(_CELLS)}
    return "\n".join(
        (
            "/* Memory of the VME DualPort: every field has 16 bits. */\n",
            "\n\n".join((*structures, _MEMORY)),
            "",
            _defines("Commands of the master", {code.name: str(int(code)) for code in Command}, "VME_"),
            _defines("Acknowledges of the PAM", {code.name: str(int(code)) for code in Answer}, "PAM_"),
            _defines("Byte offsets of the fatal error panel", cells, "VME_FATAL_ERROR_"),
        )
    )


def _defines(about: str, values: Mapping[str, str], prefix: str = "") -> str:
    width = max((len(name) for name in values), default=0)
    lines = [f"#define {prefix}{name:<{width}} {value}" for name, value in values.items()]
    return "\n".join([f"/* {about}. */", *lines, ""])
