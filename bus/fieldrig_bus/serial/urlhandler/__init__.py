"""URLs of pyserial: `serial_for_url("fieldrig://NAME")` opens a serial line of a rig by its name in the rig file.

pyserial finds the module `protocol_fieldrig` in the packages of its list.  A rig with a serial line adds this one.
"""

from contextlib import suppress


def register() -> None:
    """Let pyserial look for its protocols here as well.

    A rig needs no pyserial, so one that cannot be imported, as it has modules of its system, is no fault of the rig.
    """
    with suppress(ImportError):
        import serial

        if __name__ not in serial.protocol_handler_packages:
            serial.protocol_handler_packages.append(__name__)
