"""A linter for EDS and DCF files: deviations from CiA 306-1, each with the remedy.

Source: CiA 306-1 4.3 to 4.6; CiA 301 7.5 for the communication objects.  Left out: modules, dynamic channels.  A
finding is an error if a configuration tool or a node fails on it; all others are warnings.
"""

import re
from collections.abc import Iterator
from pathlib import Path

from fieldrig_devices.canopen.eds import check_lists as eds_check_lists
from fieldrig_devices.canopen.eds import check_objects as eds_check_objects
from fieldrig_devices.canopen.eds import check_pdo as eds_check_pdo
from fieldrig_devices.canopen.eds import reader as eds
from fieldrig_devices.canopen.eds.finding import Finding, Severity, error, warning
from fieldrig_devices.canopen.eds.source import EdsSource, Section

__all__ = ["Finding", "Severity", "check_eds"]

MAX_LINE = 255
FILE_INFO = [
    "FileName",
    "FileVersion",
    "FileRevision",
    "EDSVersion",
    "Description",
    *("CreationTime", "CreationDate", "CreatedBy"),
    *("ModificationTime", "ModificationDate", "ModifiedBy"),
]
BIT_RATES = [f"BaudRate_{rate}" for rate in (10, 20, 50, 125, 250, 500, 800, 1000)]
FLAGS = [
    *BIT_RATES,
    "SimpleBootUpMaster",
    "SimpleBootUpSlave",
    "DynamicChannelsSupported",
    "GroupMessaging",
    "LSS_Supported",
]
DEVICE_INFO = [
    *["VendorName", "VendorNumber", "ProductName", "ProductNumber", "RevisionNumber", "Granularity"],
    *FLAGS,
    *["NrOfRXPDO", "NrOfTXPDO"],
]
TIME, DATE = (
    re.compile(r"(0?[1-9]|1[0-2]):[0-5]\d ?[AP]M", re.IGNORECASE),
    re.compile(r"(0[1-9]|1[0-2])-(0[1-9]|[12]\d|3[01])-\d{4}"),
)
FORMS = {
    "CreationTime": (TIME, "10:30AM"),
    "ModificationTime": (TIME, "10:30AM"),
    "CreationDate": (DATE, "11-21-2026 (month, day, year)"),
    "ModificationDate": (DATE, "11-21-2026 (month, day, year)"),
    "EDSVersion": (re.compile(r"[34]\.0"), "4.0"),
}
DUMMIES = [f"Dummy{number:04d}" for number in range(1, 8)]


def check_eds(path: Path) -> list[Finding]:
    """Return all findings in order of lines.  Raises OSError if the file cannot be read."""
    source = EdsSource(path)
    found = [
        *_lines(source),
        *_file_info(source),
        *_device_info(source),
        *_dummies(source),
        *_comments(source),
        *eds_check_lists.check(source),
        *eds_check_objects.check(source),
        *eds_check_pdo.check(source),
        *eds.oddities(path),
    ]
    return sorted(found, key=lambda finding: finding.line)


def _lines(source: EdsSource) -> Iterator[Finding]:
    for number, text in enumerate(source.lines, start=1):
        if len(text) > MAX_LINE:
            yield warning(number, "", "", f"the line has {len(text)} characters", f"at most {MAX_LINE} are allowed")
    for number, text in source.strays:
        yield error(
            number, "", "", f"{text[:40]!r} is neither a section nor a key", "write [Section], key=value or ;comment"
        )
    for section in source.repeated:
        first = source.sections[section.name.lower()].line
        yield error(section.line, section.name, "", f"already exists in line {first}", "put all keys into one section")
    for section in source.sections.values():
        for entry in section.repeated:
            first = section.line_of(entry.key)
            yield error(entry.line, section.name, entry.key, f"already exists in line {first}", "keep only one of them")


def _missing(section: Section, keys: list[str]) -> Iterator[Finding]:
    for key in keys:
        if key.lower() not in section.entries:
            yield error(section.line, section.name, key, "is missing", f"write {key}=, which CiA 306 requires")


def _required(source: EdsSource, name: str, keys: list[str]) -> Iterator[Finding]:
    section = source.get(name)
    if section is None:
        yield error(1, name, "", "the section is missing", f"write [{name}] with {', '.join(keys[:3])} and so on")
    else:
        yield from _missing(section, keys)


def _flag(section: Section, key: str) -> Iterator[Finding]:
    if section.get(key) and section.number(key) not in (0, 1):
        yield error(section.line_of(key), section.name, key, f"{section.get(key)}", "expected 0 or 1")


def _file_info(source: EdsSource) -> Iterator[Finding]:
    yield from _required(source, "FileInfo", FILE_INFO)
    section = source.get("FileInfo")
    if section is None:
        return
    for key, (form, example) in FORMS.items():
        value = section.get(key)
        if value and not form.fullmatch(value):
            yield error(section.line_of(key), section.name, key, value, f"expected the form {example}")
    for key in ("FileVersion", "FileRevision"):
        number = section.number(key)
        if section.get(key) and (number is None or not 0 <= number <= 255):
            yield error(section.line_of(key), section.name, key, section.get(key), "expected a number from 0 to 255")
    name = section.get("FileName")
    if name and name != source.path.name:
        yield warning(section.line_of("FileName"), section.name, "FileName", name, f"the file is {source.path.name}")


def _device_info(source: EdsSource) -> Iterator[Finding]:
    yield from _required(source, "DeviceInfo", DEVICE_INFO)
    section = source.get("DeviceInfo")
    if section is None:
        return
    if "ordercode" not in section.entries:  # CiA's tool ignores this
        yield warning(section.line, section.name, "OrderCode", "is missing", "write OrderCode=, which CiA 306 requires")
    for key in FLAGS:
        yield from _flag(section, key)
    if not any(section.number(key) for key in BIT_RATES):
        yield error(
            section.line,
            section.name,
            "BaudRate_",
            "no bit rate is supported",
            "set at least one to 1, such as BaudRate_250=1",
        )
    granularity = section.number("Granularity")
    if section.get("Granularity") and (granularity is None or not 0 <= granularity <= 64):
        yield error(
            section.line_of("Granularity"),
            section.name,
            "Granularity",
            section.get("Granularity"),
            "expected 0 (no PDO mapping) to 64 bits",
        )
    yield from _identity(source, section)
    for key, first in (("NrOfRXPDO", 0x1400), ("NrOfTXPDO", 0x1800)):
        count = sum(1 for index, sub, _ in source.objects() if sub is None and first <= index < first + 512)
        if section.get(key) and section.number(key) != count and section.number("CompactPDO") in (None, 0):
            yield error(
                section.line_of(key),
                section.name,
                key,
                section.get(key),
                f"expected {count}, the number of described PDOs",
            )


def _identity(source: EdsSource, section: Section) -> Iterator[Finding]:
    """Check that the numbers are the same as in 1018h."""
    for key, sub in (("VendorNumber", 1), ("ProductNumber", 2), ("RevisionNumber", 3)):
        number, described = section.number(key), source.get(f"1018sub{sub}")
        if section.get(key) and number is None:
            yield error(
                section.line_of(key), section.name, key, section.get(key), "expected a number, such as 0x0000001F"
            )
        default = None if described is None else described.number("DefaultValue")
        if number is not None and default is not None and number != default:
            yield warning(
                section.line_of(key),
                section.name,
                key,
                section.get(key),
                f"[1018sub{sub}] has {default:#x}: write the same number in both",
            )


def _dummies(source: EdsSource) -> Iterator[Finding]:
    section = source.get("DummyUsage")
    if section is None:
        yield warning(
            1, "DummyUsage", "", "the section is missing", "write it with Dummy0001 to Dummy0007, each 0 or 1"
        )
        return
    yield from _missing(section, DUMMIES)
    for key in DUMMIES:
        yield from _flag(section, key)


def _comments(source: EdsSource) -> Iterator[Finding]:
    section = source.get("Comments")
    if section is None:
        yield warning(1, "Comments", "", "the section is missing", "write [Comments] with Lines=0")
        return
    count, there = section.number("Lines"), len([key for key in section.entries if re.fullmatch(r"line\d+", key)])
    if count is None:
        yield error(
            section.line_of("Lines"), section.name, "Lines", section.get("Lines") or "is missing", f"write {there}"
        )
    elif count != there:
        yield error(
            section.line_of("Lines"), section.name, "Lines", str(count), f"expected {there}, the number of lines"
        )
