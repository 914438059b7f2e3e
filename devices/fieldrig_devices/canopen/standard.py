"""Data types that CiA 301 gives the communication parameters; the services rely on them.

Source: CiA 301 chapter 7.5.2.
"""

from fieldrig_devices.canopen.datatypes import DATA_TYPES, DOMAIN, DataType

U8, U16, U32, U64 = DATA_TYPES[0x05], DATA_TYPES[0x06], DATA_TYPES[0x07], DATA_TYPES[0x1B]

STRUCTURE = 0xFF
"""The sub-index that describes data and object type."""

STORED_EDS = 0x1021

PDO_PARAMETER: dict[int | None, DataType] = {0: U8, 1: U32, 2: U8, 3: U16, 5: U16, 6: U8}
# None stands for all sub-indices that are not listed.
TYPES: list[tuple[range, dict[int | None, DataType]]] = [
    (range(0x1000, 0x1001), {0: U32}),
    (range(0x1001, 0x1002), {0: U8}),
    (range(0x1003, 0x1004), {0: U8, None: U32}),
    (range(0x1005, 0x1008), {0: U32}),
    (range(0x100C, 0x100D), {0: U16}),
    (range(0x100D, 0x100E), {0: U8}),
    (range(0x1010, 0x1012), {0: U8, None: U32}),
    (range(0x1012, 0x1013), {0: U32}),
    (range(0x1014, 0x1015), {0: U32}),
    (range(0x1015, 0x1016), {0: U16}),
    (range(0x1016, 0x1017), {0: U8, None: U32}),
    (range(0x1017, 0x1018), {0: U16}),
    (range(0x1018, 0x1019), {0: U8, None: U32}),
    (range(0x1019, 0x101A), {0: U8}),
    (range(0x1020, 0x1021), {0: U8, None: U32}),
    (range(0x1021, 0x1022), {0: DOMAIN}),
    (range(0x1022, 0x1023), {0: U8}),
    (range(0x1028, 0x1029), {0: U8, None: U32}),
    (range(0x1029, 0x102A), {0: U8, None: U8}),
    (range(0x1200, 0x1280), {0: U8, 1: U32, 2: U32, 3: U8}),
    (range(0x1400, 0x1600), PDO_PARAMETER),
    (range(0x1600, 0x1800), {0: U8, None: U32}),
    (range(0x1800, 0x1A00), PDO_PARAMETER),
    (range(0x1A00, 0x1C00), {0: U8, None: U32}),
    (range(0x1F80, 0x1F81), {0: U32}),
    (range(0x1FA0, 0x1FD0), {0: U8, None: U32}),
    (range(0x1FD0, 0x2000), {0: U8, None: U64}),
]


def wanted(index: int, subindex: int) -> DataType | None:
    for indices, types in TYPES:
        if index in indices:
            return types.get(subindex, types.get(None)) if subindex != STRUCTURE else U32
    return None
