"""The CRCs of variables, which those of an original compiler may replace."""

from collections.abc import Iterable
from dataclasses import replace

from fieldrig_devices.pam.language.ports import PortVariable
from fieldrig_devices.pam.ports.crc_file import crcs_in
from fieldrig_devices.pam.ports.options import PortOptions


def with_crcs(variables: Iterable[PortVariable], options: PortOptions) -> tuple[PortVariable, ...]:
    """Return the variables with the CRCs of the settings; a variable that the file lacks keeps its own."""
    given = crcs_in(options.pam_vme_h) if options.pam_vme_h is not None else {}
    return tuple(replace(variable, given_crc=given.get(variable.name)) for variable in variables)
