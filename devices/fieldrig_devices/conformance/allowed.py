"""The abort codes that CiA's test tool accepts in each case.

Source: the public log of a run under CTT 3.0.3.10, which prints them for each case that expects a refusal.  Where the
log has two sets for one case (PDO 25 and 26: one for sub-index 0, one for the entries), both are accepted.  A case that
is not listed was skipped in that run, or prints none; then the codes that the case takes from CiA 301 apply.
"""

ALLOWED: dict[str, tuple[int, ...]] = {
    "SDO 03": (0x0601_0000, 0x0601_0002, 0x0800_0000),
    "SDO 05": (0x0609_0011, 0x0800_0000),
    "SDO 06": (0x0602_0000, 0x0800_0000),
    "SDO 07": (0x0504_0001, 0x0800_0000),
    "SDO 08": (0x0607_0010, 0x0607_0012, 0x0800_0000),
    "SDO 09": (0x0607_0010, 0x0607_0013, 0x0800_0000),
    "SDO 10": (0x0609_0030, 0x0609_0031, 0x0800_0000),
    "SDO 26": (0x0504_0001, 0x0504_0002, 0x0800_0000),
    "SDO 27": (0x0504_0001, 0x0504_0003, 0x0800_0000),
    "SDO 28": (0x0602_0000, 0x0800_0000),
    "PDO 23": (0x0601_0000, 0x0604_0041, 0x0800_0000),
    "PDO 25": (0x0601_0000, 0x0602_0000, 0x0604_0041, 0x0604_0042),
    "PDO 26": (0x0601_0000, 0x0602_0000, 0x0604_0041, 0x0604_0042),
    "PDO 28": (0x0602_0000, 0x0604_0041),
    "PDO 29": (0x0602_0000, 0x0604_0041),
    "PDO 32": (0x0602_0000, 0x0604_0041),
    "OD 03": (0x0601_0000, 0x0601_0002, 0x0800_0000),
}
