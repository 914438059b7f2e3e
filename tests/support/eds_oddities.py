"""Excerpts of EDS files as other makers and tools write them, each with the expected finding."""

DEVICE_TYPE = "[1000]\nParameterName=Device type\nDataType=7\nAccessType=ro\n"
"""A valid object, for files that consist of one of the following excerpts."""

# Text of the file, the object that it describes, and the finding.
ODD: list[tuple[str, str, str]] = [
    ("[2000]\nDataType=5\nAccessType=rw\nLowLimit=x\n", "2000:00", "5: error: [2000] LowLimit: x; expected a number"),
    ("[2000]\nDataType=5\nAccessType=rw\nLowLimit=9\nHighLimit=3\n", "2000:00", "LowLimit: 9; expected at most"),
    ("[2000sub1]\nDataType=5\nAccessType=rw\n", "2000:01", "[2000sub1]: belongs to no object"),
    ("[2000]\nDataType=0xA1\nAccessType=rw\n", "2000:00",
     "0xA1; expected a data type of CiA 301, such as 0x0005 (UNSIGNED8);"),
    ("[1017]\nDataType=7\nAccessType=rw\n", "1017:00", "[1017] DataType: 7; expected 0x0006 (UNSIGNED16), as in CiA"),
    ("[1017]\nAccessType=rw\n", "1017:00", "[1017] DataType: is missing; expected 0x0006 (UNSIGNED16)"),
    ("[1021]\nDataType=7\nAccessType=ro\n", "1021:00", "warning: [1021] DataType: 7; expected 0x000F (DOMAIN)"),
    ("[2000]\nObjectType=seven\nDataType=5\nAccessType=rw\n", "2000:00", "ObjectType: seven; expected 0x7 (VAR)"),
    ("[2000]\nDataType=5\nAccessType=rw\n[2000sub1]\nDataType=5\nAccessType=rw\n", "2000:01", "is not an ARRAY"),
    ("[2000]\nObjectType=8\nCompactSubObj=many\nDataType=5\nAccessType=rw\n", "2000:00", "many; expected 0 to 254"),
    ("[2000]\nObjectType=8\nCompactSubObj=999\nDataType=5\nAccessType=rw\n", "2000:FE", "999; expected 0 to 254"),
    ("[2000]\nDataType=5\nAccessType=rw\nPDOMapping=yes\n", "2000:00", "PDOMapping: yes; expected 0 or 1"),
    ("  [2000]\n  DataType=5\n  AccessType=rw\nnonsense\n", "2000:00", "'nonsense' is neither a section nor a key"),
]  # fmt: skip

# Text that leaves an object without a data type, and the finding; such an object is left out.
WRONG: list[tuple[str, str]] = [
    (
        "[2000]\nAccessType=rw\n",
        r":5: error: \[2000\] DataType: is missing; expected a data type of CiA 301, such as 0x0005",
    ),
    ("[2000]\nDataType=five\nAccessType=rw\n", r":6: error: \[2000\] DataType: five; expected a data type of CiA 301"),
    ("[2000]\nDataType=0x17\nAccessType=rw\n", r":6: error: \[2000\] DataType: 0x17; expected a data type of CiA 301"),
]

# Text of our I/O module's file, what a maker might write instead, and the finding.
MISTAKES: list[tuple[str, str, str]] = [
    # lines and sections
    ("[Comments]", "nonsense\n[Comments]", "'nonsense' is neither a section nor a key; write [Section], key=value"),
    ("[Comments]", "[FileInfo]\nFileName=x\n[Comments]", "[FileInfo]: already exists in line 1; put all keys"),
    ("OrderCode=IO32", "OrderCode=IO32\nOrderCode=IO33", "OrderCode: already exists in line 20; keep only one"),
    ("OrderCode=IO32", "OrderCode=" + "x" * 250, "the line has 260 characters; at most 255 are allowed"),
    # file info
    ("FileName=io32.eds", "FileName=other.eds", "FileName: other.eds; the file is io32.eds"),
    ("FileVersion=1\n", "", "[FileInfo] FileVersion: is missing; write FileVersion="),
    ("FileRevision=0", "FileRevision=300", "FileRevision: 300; expected a number from 0 to 255"),
    ("EDSVersion=4.0", "EDSVersion=4", "EDSVersion: 4; expected the form 4.0"),
    ("CreationTime=10:00AM", "CreationTime=10:00", "CreationTime: 10:00; expected the form 10:30AM"),
    ("CreationDate=11-21-2026", "CreationDate=21-11-2026", "expected the form 11-21-2026 (month, day, year)"),
    # device info
    ("VendorName=fieldrig\n", "", "[DeviceInfo] VendorName: is missing"),
    ("BaudRate_50=1", "BaudRate_50=yes", "BaudRate_50: yes; expected 0 or 1"),
    ("Granularity=1", "Granularity=65", "Granularity: 65; expected 0 (no PDO mapping) to 64 bits"),
    ("NrOfRXPDO=2", "NrOfRXPDO=4", "NrOfRXPDO: 4; expected 2, the number of described PDOs"),
    ("NrOfTXPDO=2", "NrOfTXPDO=0x3", "NrOfTXPDO: 0x3; expected 2, the number of described PDOs"),
    ("ProductNumber=0x00000020", "ProductNumber=0x21", "ProductNumber: 0x21; [1018sub2] has 0x20: write the same"),
    ("ProductNumber=0x00000020", "ProductNumber=IO32", "ProductNumber: IO32; expected a number, such as 0x0000001F"),
    # dummies and comments
    ("Dummy0003=1\n", "", "[DummyUsage] Dummy0003: is missing"),
    ("Dummy0003=1", "Dummy0003=2", "Dummy0003: 2; expected 0 or 1"),
    ("Lines=2", "Lines=3", "[Comments] Lines: 3; expected 2, the number of lines"),
    # lists
    ("SupportedObjects=3", "SupportedObjects=4",
     "[MandatoryObjects] SupportedObjects: 4; expected 3, the number of listed"),
    ("3=0x1018", "4=0x1018", "the numbers have gaps; number them from 1 to 3"),
    ("3=0x1018", "3=1018h", "[MandatoryObjects] 3: 1018h; expected an index, such as 0x1018"),
    ("3=0x1018", "3=0x1017", "0x1017 is already listed in [MandatoryObjects]; list it only once"),
    ("3=0x1018", "3=0x2222", "0x2222 has no section; describe it in [2222], or remove it from the list"),
    ("3=0x1018", "3=0x2222", "[1018]: is not in any list; add it to [MandatoryObjects]"),
    ("3=0x1018", "3=0x2000", "0x2000 belongs in another list; move it to [ManufacturerObjects]"),
    ("[1001]", "[5001]", "[1001]: the object is missing; describe it: CiA 301 requires 1000h, 1001h and 1018h"),
    ("[OptionalObjects]", "[OptObjects]", "[OptionalObjects]: the section is missing"),
    # objects
    ("[1018sub4]", "[1019sub4]", "[1019] is not an ARRAY or RECORD; set its ObjectType to 0x8 or 0x9"),
    ("[1018sub4]", "[3018sub4]", "[3018sub4]: belongs to no object; add a section [3018]"),
    ("[1018sub4]", "[1018sub04]", "the sub-index has a leading zero; expected the form [1018sub1]"),
    ("SubNumber=5", "SubNumber=4", "SubNumber: 4; expected 5, the number of described sub-indices"),
    ("[1016sub0]", "[1016sub7]", "[1016]: has no sub-index 0; describe it in [1016sub0]"),
    ("AccessType=const\nDefaultValue=4\n", "AccessType=const\nDefaultValue=5\n",
     "DefaultValue: 5; expected 4, the highest sub-index"),
    ("ParameterName=Device type\n", "", "[1000] ParameterName: is missing"),
    ("ParameterName=Device type\nObjectType=0x7", "ParameterName=Device type\nObjectType=0x3",
     "0x7 (VAR), 0x8 (ARRAY)"),
    ("DataType=0x0009\nAccessType=rw", "DataType=0x0099\nAccessType=rw",
     "[2000] DataType: 0x0099; expected a data type"),
    ("DataType=0x0009\nAccessType=rw", "DataType=0x0009\nAccessType=r/w",
     "AccessType: r/w; expected one of ro, wo, rw, rwr"),
    ("Producer heartbeat time\nObjectType=0x7\nDataType=0x0006", "T\nObjectType=0x7\nDataType=0x0007",
     "[1017] DataType: 0x0007; expected 0x0006 (UNSIGNED16), as in CiA 301"),
    ("DefaultValue=control cabinet 1\nPDOMapping=0", "PDOMapping=yes", "[2000] PDOMapping: yes; expected 0 or 1"),
    ("AccessType=const\nDefaultValue=IO32\n", "AccessType=const\n",
     "[1008] DefaultValue: is missing; write the value"),
    # values
    ("LowLimit=-100", "LowLimit=101", "[2002] LowLimit: 101; expected at most HighLimit"),
    ("DefaultValue=0\nLowLimit=-100", "DefaultValue=-101\nLowLimit=-100",
     "-101; expected a value within the limits, -100 to 100"),
    ("HighLimit=100", "HighLimit=40000", "HighLimit: 40000; expected -32768 to 32767, the range of INTEGER16"),
    ("DefaultValue=0x000F0191", "DefaultValue=000F0191h", "0x000F0191: hexadecimal numbers start with 0x"),
    ("DefaultValue=0x000F0191", "DefaultValue=F0191", "a number, such as 10 or 0x0A, or one with $NODEID"),
    ("DefaultValue=control cabinet 1", "DefaultValue=x\nHighLimit=5", "remove it: VISIBLE_STRING has no limits"),
    # PDOs and COB-IDs
    ("DefaultValue=0x62000108", "DefaultValue=0x62000508", "an existing object: 6200h sub-index 5"),
    ("DefaultValue=0x62000108", "DefaultValue=0x62020108",
     "an object with PDOMapping=1, which [6202sub1] doesn't have"),
    ("DefaultValue=0x62000108", "DefaultValue=0x60000108", "an RPDO cannot carry [6000sub1], AccessType=ro"),
    ("DefaultValue=0x60000108", "DefaultValue=0x62000108", "a TPDO cannot carry [6200sub1], AccessType=rww"),
    ("DefaultValue=0x62000108", "DefaultValue=0x62000110", "0x62000108: [6200sub1] has 8 bits"),
    ("DefaultValue=0x60000108", "DefaultValue=0x00050008", "an object: dummies are for RPDOs only"),
    ("DefaultValue=0x62000108", "DefaultValue=0x00010001", "a dummy that [DummyUsage] allows: write Dummy0001=1"),
    ("DefaultValue=0x62000108", "DefaultValue=0x00050010", "the length of the dummy's data type"),
    ("[1A00]", "[1A05]", "[1800]: has no mapping; describe [1A00]"),
    ("[1400]", "[1405]", "[1600]: has no communication parameter; describe [1400]"),
    ("DefaultValue=$NODEID+0x200", "DefaultValue=0x205",
     "is the same for all nodes made from this file; expected $NODEID+0x200"),
    ("DefaultValue=$NODEID+0x200", "DefaultValue=$NODEID+0x201", "expected $NODEID+0x200, as in CiA 301"),
    ("DefaultValue=0x80\n", "DefaultValue=0x601\n", "[1005] DefaultValue: 0x601; expected a CAN-ID that CiA 301"),
]  # fmt: skip
