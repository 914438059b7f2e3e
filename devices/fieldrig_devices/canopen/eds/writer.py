"""Writes DCF files: an EDS with the present values of a device.

Source: CiA 306-1 4.3, CiA 306-1 4.7 (DCF).  The sections, keys and values of the EDS are kept, and its `;` comments
(unlike the section Comments) are not.  The present values are ParameterValue, without domains and without texts that
don't fit on a line.  A value that is written is read back as the same bytes.
"""

from collections.abc import Iterator

from fieldrig_devices.canopen.datatypes import DOMAIN, Boolean, Integer, Real
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.eds.source import EdsSource, Section
from fieldrig_devices.canopen.variable import Variable


def write_dcf(source: EdsSource, dictionary: Dictionary, node_id: int, name: str) -> str:
    """Return the present configuration of the device as a DCF, for node `node_id` with the name `name`."""
    values = {
        (variable.index, variable.subindex): text
        for variable in dictionary
        if (text := _value(variable)) is not None and variable.access.is_writable
    }
    described = {(index, sub or 0): section for index, sub, section in source.objects()}
    present = {id(section): values[where] for where, section in described.items() if where in values}

    def sections() -> Iterator[tuple[str, dict[str, str]]]:
        for section in source.sections.values():
            entries = _entries(section)
            if id(section) in present and entries.get("ObjectType", "0x7").strip() not in ("8", "9", "0x8", "0x9"):
                entries["ParameterValue"] = present[id(section)]
            if section.name.lower() == "fileinfo":
                entries["LastEDS"] = source.path.name
            yield section.name, entries
        yield "DeviceComissioning", {"NodeID": f"{node_id:#x}", "NodeName": name}  # the standard's spelling

    return _text(sections())


def _entries(section: Section) -> dict[str, str]:
    return {entry.key: entry.value for entry in section.entries.values()}


def _text(sections: Iterator[tuple[str, dict[str, str]]]) -> str:
    blocks = [
        "\n".join([f"[{name}]", *(f"{key}={value}" for key, value in entries.items()), ""])
        for name, entries in sections
    ]
    return "\n".join(blocks)


def _value(variable: Variable) -> str | None:
    value = variable.value
    if variable.type is DOMAIN:
        return None
    if isinstance(variable.type, Integer | Boolean):
        return f"{int(value)}"
    if isinstance(variable.type, Real) and variable.type.encode(float(value)) != variable.data:
        return f"0x{variable.number:0{variable.type.size * 2}X}"  # not-a-number, with all its bits
    text = str(value)
    if variable.type.encode(text if isinstance(value, str) else value) != variable.data:
        return None  # the bytes are not a valid text of the type
    return text if text == text.strip() and text.isprintable() and ";" not in text and text else None
