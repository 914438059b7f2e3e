"""EDS and DCF files as text: read as their makers write them, given on as canopen's reader wants them.

Source: CiA 306-1.  Tolerated: any case of sections and keys, any order, numbers with leading zeros (octal),
other encodings than ASCII, a section given twice (the later keys win).  Compact sub-objects are written out.
Left out: modules, dynamic channels, `CompactPDO`.
"""

import io
import re
from configparser import Error, RawConfigParser
from pathlib import Path

DOMAIN, DEFTYPE, DEFSTRUCT, VAR, ARRAY, RECORD = 2, 5, 6, 7, 8, 9
"""Object types."""

DOMAIN_TYPE = 0x000F
SECTION = re.compile(r"(?P<index>[0-9A-F]{4})(?:SUB(?P<sub>[0-9A-F]{1,2}))?", re.IGNORECASE)
COMPACT_SECTION = re.compile(r"(?P<index>[0-9A-F]{4})(?P<what>NAME|VALUE)", re.IGNORECASE)
NUMBER = re.compile(r"0x[0-9a-f]+|[+-]?\d+", re.IGNORECASE)
KEYS = {
    key.lower(): key
    for key in [
        "ParameterName",
        "ObjectType",
        "DataType",
        "AccessType",
        "DefaultValue",
        "ParameterValue",
        "PDOMapping",
        "LowLimit",
        "HighLimit",
        "CompactSubObj",
        "StorageLocation",
        "SubNumber",
        "ObjFlags",
        "Factor",
        "Unit",
        "Description",
    ]
}
NUMERIC_KEYS = ("ObjectType", "DataType", "PDOMapping", "CompactSubObj")

Section = dict[str, str]


class EdsError(ValueError):
    """An EDS or DCF file that no node can be made from, with all that is wrong in it."""

    def __init__(self, path: Path, problems: list[str]) -> None:
        super().__init__("\n".join(f"{path.name} {problem}" for problem in problems))


def parse_number(text: str) -> int:
    """Decimal, hex with 0x, octal with a leading 0 (CiA 306-1 4.2).  ValueError for anything else."""
    text = text.strip()
    if not NUMBER.fullmatch(text):
        raise ValueError(f"{text!r} is no number")
    digits = text.lstrip("+-")
    if digits.startswith("0") and digits.isdigit() and digits.strip("0"):
        return int(digits, 8) * (-1 if text.startswith("-") else 1)
    return int(text, 16 if digits[:2].lower() == "0x" else 10)


class EdsText:
    """The objects of one file: sections by index and sub-index (None: the object itself)."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.problems: list[str] = []
        self.objects: dict[tuple[int, int | None], Section] = {}
        self.dummies: Section = {}
        self.device_info: Section = {}
        self._others: dict[str, Section] = {}
        self._compact: dict[tuple[int, str], Section] = {}
        self._read()
        self._complete()

    def canonical(self) -> io.StringIO:
        """What canopen's reader takes."""
        lines = ["[DeviceInfo]", "[DummyUsage]"]
        lines += [f"Dummy{number:04d}={self.dummies.get(f'dummy{number:04d}', '0')}" for number in range(1, 8)]
        sections = {name_section(*where): self.objects[where] for where in sorted(self.objects, key=_order)}
        for name, section in (self._others | sections).items():
            lines.append(f"[{name}]")
            lines += [f"{key}={value}" for key, value in section.items()]
        return io.StringIO("\n".join(lines) + "\n")

    def _read(self) -> None:
        parser = RawConfigParser(inline_comment_prefixes=(";",), strict=False, allow_no_value=True, interpolation=None)
        try:
            parser.read_string(decode(self.path.read_bytes()))
        except Error as cause:
            raise EdsError(self.path, [f"is no EDS file: {cause.message}"]) from cause
        for name in parser.sections():
            self._take(name, {key: (value or "").strip() for key, value in parser.items(name)})
        if not any(sub is None for _, sub in self.objects):
            raise EdsError(self.path, ["has no object; a section such as [1000] would be one"])

    def _take(self, name: str, section: Section) -> None:
        if match := SECTION.fullmatch(name.strip()):
            sub = None if match["sub"] is None else int(match["sub"], 16)
            known = {KEYS.get(key, key): value for key, value in section.items() if value}
            self.objects.setdefault((int(match["index"], 16), sub), {}).update(known)
        elif match := COMPACT_SECTION.fullmatch(name.strip()):
            self._compact[int(match["index"], 16), match["what"].lower()] = section
        elif name.lower() == "dummyusage":
            self.dummies = section
        elif name.lower() == "deviceinfo":
            self.device_info = section
        elif re.fullmatch(
            r"[0-9A-F]{1,3}(SUB[0-9A-F]+)?", name, re.IGNORECASE
        ):  # data types as CANFestival writes them
            self._others[name.upper().replace("SUB", "sub")] = {KEYS.get(key, key): one for key, one in section.items()}

    # What the standard leaves implicit, said; what can't be understood, found.

    def _complete(self) -> None:
        for where in list(self.objects):
            self._check_numbers(where)
        if self.problems:
            raise EdsError(self.path, self.problems)
        self._drop_types()
        for index, section in [(index, one) for (index, sub), one in self.objects.items() if sub is None]:
            section.setdefault("ParameterName", f"Object {index:04X}h")
            if "CompactSubObj" in section and int(section["CompactSubObj"]) > 0:
                self._expand(index, section)
        for where, section in self.objects.items():
            self._check(where, section)

    def _check_numbers(self, where: tuple[int, int | None]) -> None:
        section = self.objects[where]
        for key in NUMERIC_KEYS:
            if key in section:
                try:
                    section[key] = str(parse_number(section[key]))
                except ValueError:
                    self._problem(where, f"{key} = {section[key]}: a number would be right, such as 7 or 0x0007")
        for key in ("DefaultValue", "ParameterValue", "LowLimit", "HighLimit"):
            if key in section:
                section[key] = _plain_number(section[key])

    def _drop_types(self) -> None:
        """Descriptions of data types are no objects of the node."""
        types = (str(DEFTYPE), str(DEFSTRUCT), "0")
        dropped = {
            index for (index, sub), one in self.objects.items() if sub is None and one.get("ObjectType") in types
        }
        self.objects = {where: one for where, one in self.objects.items() if where[0] not in dropped}

    def _expand(self, index: int, section: Section) -> None:
        """4.6.3.3: one description for all sub-indices, with exceptions in [<index>Name] and [<index>Value]."""
        count = int(section.pop("CompactSubObj"))
        names, values = self._compact.get((index, "name"), {}), self._compact.get((index, "value"), {})
        name = section["ParameterName"]
        template = {key: value for key, value in section.items() if key not in ("ParameterName", "ObjectType")}
        number_of = {
            "ParameterName": "Number of entries",
            "DataType": "5",
            "AccessType": "ro",
            "DefaultValue": str(count),
        }
        self.objects.setdefault((index, 0), number_of)
        for sub in range(1, count + 1):
            own = {"ParameterName": names.get(str(sub)) or f"{name} {sub}"} | template
            if values.get(str(sub)):
                own["ParameterValue"] = _plain_number(values[str(sub)])
            self.objects.setdefault((index, sub), own)
        section["ObjectType"] = str(ARRAY)

    def _check(self, where: tuple[int, int | None], section: Section) -> None:
        index, sub = where
        owner = self.objects.get((index, None))
        if owner is None:
            self._problem(where, f"belongs to no object: a section [{index:04X}] is missing")
            return
        section.setdefault("ParameterName", f"{owner['ParameterName']} {sub}")
        object_type = int(section.get("ObjectType", VAR))
        if sub is None and object_type in (ARRAY, RECORD):
            return
        if object_type == DOMAIN:
            section.setdefault("DataType", str(DOMAIN_TYPE))
            section.setdefault("AccessType", "rw")
        for key, example in (("DataType", "0x0005 (UNSIGNED8)"), ("AccessType", "ro, wo, rw, rwr, rww or const")):
            if key not in section:
                self._problem(where, f"{key} is missing; right would be, for example, {example}")

    def _problem(self, where: tuple[int, int | None], what: str) -> None:
        self.problems.append(f"[{name_section(*where)}] {what}")


def name_section(index: int, sub: int | None) -> str:
    return f"{index:04X}" if sub is None else f"{index:04X}sub{sub:X}"


def _order(where: tuple[int, int | None]) -> tuple[int, int]:
    index, sub = where
    return index, -1 if sub is None else sub


def decode(data: bytes) -> str:
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252", "replace")


def _plain_number(text: str) -> str:
    """An octal number as a decimal one, `$NODEID` alone as a sum; everything else as it is."""
    if text.upper().replace(" ", "") == "$NODEID":
        return "$NODEID+0"
    if re.fullmatch(r"[+-]?0\d+", text):
        try:
            return str(parse_number(text))
        except ValueError:  # a text of digits, or decimal with leading zeros
            return text
    return text
