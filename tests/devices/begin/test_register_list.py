"""`fieldrig new --registers`: lists of registers as makers publish them."""

import runpy
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner, Result

from fieldrig import RigMaker
from fieldrig.cli.app import app
from fieldrig_devices.begin.register_list import read_list
from fieldrig_devices.registers.table import load_table

METER = """Modbus Address;Parameter Name;Data Type;Unit;Scale;R/W;Function Code;Description;Words
30001;Voltage L1-N;uint16;V;0,1;R;04;Phase voltage;1
30002;Voltage L1-N;UINT16;V;0,1;R;04;Phase voltage 2;1
30003;Active power;int32 (CDAB);W;1;R;04;;2
30005;Energy import;float32;kWh;;R;04;;2
30007;Serial number;string;;;R;04;;8
40001;Mode;u16;;;R/W;03;;1
40002;CT ratio;uint16;;1/10;R/W;03;"primary; secondary";1
40003;What;quux;;;R/W;03;;1
40004-40005;Counter;;;;R;03;;2
x;Nothing;;;;;;;
"""
TABLE = """\
# Made from meter.csv. Addresses are as on the wire, from 0.
# Addresses such as 40001 were taken as numbers that count from 1.
# Line 9 is left out: 'quux' is no type that is known.
# Line 11 is left out: 'x' is no address.

holding_registers:
  - {address: 0, name: mode, type: u16}
  - {address: 1, name: ct_ratio, type: u16, scale: 0.1, about: "primary; secondary"}
  - {address: 3, name: counter, type: u32, access: ro}

input_registers:
  - {address: 0, name: voltage_l1_n, type: u16, unit: V, scale: 0.1, about: "Phase voltage"}
  - {address: 1, name: voltage_l1_n_1, type: u16, unit: V, scale: 0.1, about: "Phase voltage 2"}
  - {address: 2, name: active_power, type: s32, word_order: little, unit: W}
  - {address: 4, name: energy_import, type: f32, unit: kWh}
  - {address: 6, name: serial_number, type: "string[16]"}
"""


def new(*words: str | Path) -> Result:
    return CliRunner().invoke(app, ["new", *map(str, words)])


def table_of(folder: Path, text: str) -> str:
    (folder / "meter.csv").write_text(text, encoding="utf-8")
    return read_list(folder / "meter.csv").text("meter.csv")


def test_a_list_becomes_a_table_and_says_what_was_assumed_and_left_out(tmp_path: Path) -> None:
    assert table_of(tmp_path, METER) == TABLE


@pytest.mark.parametrize(
    ("text", "entry"),
    [
        ("reg,tag\n0x10,Flow\n", "holding_registers:\n  - {address: 16, name: flow, type: u16}"),
        ("Addr,Name,Type\n1Fh,On,BOOL\n", 'coils:\n  - {address: 31, name: "on"}'),
        ("address,fc,description\n7,2,Door open\n", "discrete_inputs:\n  - {address: 7, name: door_open}"),
        ("address,space,name\n5,Input Register,3 phases\n", "input_registers:\n  - {address: 5, name: r_3_phases,"),
        ("Address\tType\tMin\tMax\tDefault\n1\tREAL\t-5\t5\t2,5\n", "type: f32, initial: 2.5, min: -5, max: 5"),
        ("address,type,divisor\n1,INT,1000\n", "type: s16, scale: 0.001"),
        ("address,type\n1,float DCBA\n", "type: f32, word_order: little, byte_order: little"),
        ("address,type,length\n1,,4\n", "type: u64"),
        ("address,type\n1,STRING[12]\n", 'type: "string[12]"'),
        ("address,type\n1,UINT8\n", "type: u16"),
        ("address,type\n1,char[8]\n", 'type: "string[8]"'),
        ("address,type\n1,INT16[3]\n", "type: s16, count: 3"),
        ("address,type\n1,bitfield32\n", "type: u32"),
        ("address,scale\n1,10^-2\n", "scale: 0.01"),
        ("address,scale\n1,x 0.5 V\n", "scale: 0.5"),
        ("address,scale\n1,0.1 kWh/bit\n", "scale: 0.1"),
        ("sep=;\naddress;scale\n1;0,1\n", "scale: 0.1"),
        ("Adresse;Typ;Wert\n40003;float32;1234,5\n", "type: f32, initial: 1234.5"),
        ("address,name,type,scale\n1,A,int16,A_SF\n2,A_SF,sunssf,\n", "type: s16, exponent_from: a_sf"),
        ("address,name,scale\n2,Gain,\n1,A,gain\n", "name: a, type: u16, factor_from: gain"),
        ("address,mode\n1,write only\n2,Read\n", "access: wo}\n  - {address: 2, name: holding_register_2, type: u16, "),
        ("address,type,gain\n1,I32,1000\n", "type: s32, scale: 0.001"),
        ("Physical address;Data Format\n000Ch;INT32\n", "{address: 12, name: holding_register_12, type: s32}"),
        ("Start Reg (Hex)\tSize\tData type\n1000\t2\tUnsigned\n", "4096, name: holding_register_4096, type: u32}"),
        ("Start Reg (Hex)\tSize\tRes.\tData type\n1000\t4\t0,01\tSigned\n", "type: s64, scale: 0.01"),
        ("Register;Address;Action;Type;Units\n3000;0BB7;R;Float32;A\n5250;1481;W;UInt16;-\n",
         "{address: 2999, name: holding_register_2999, type: f32, unit: A, access: ro}\n  - {address: 5249, "),
        ("Adresse;Bezeichnung;Typ\n1;Pumpe läuft;Coil\n40010;Zähler;DINT\n",
         "coils:\n  - {address: 0, name: pumpe_laeuft}\n\nholding_registers:\n  - {address: 9, name: zaehler, "),
        ("Registers,Parameter\n40001-40002,État\n", "{address: 0, name: etat, type: u16}"),
        ('Registers,Parameter\n"40,020",Mode\n', "{address: 19, name: mode, type: u16}"),
        ("Unit ID,Address Offset,Name\n7,16,A\n", "{address: 16, name: a, type: u16}"),
        ("address,type\n1,16-bit unsigned\n", "type: u16"),
        ("address,type\n1,INT32U\n", "type: u32"),
        ("address,type\n1,unsigned long\n", "type: u32"),
        ("address,type\n1,signed int 32\n", "type: s32"),
        ("address,type\n1,32-bit IEEE float\n", "type: f32"),
        ("address,type\n1,double precision\n", "type: f64"),
        ("address,type\n1,f32 word swap\n", "type: f32, word_order: little"),
        ("address,type\n1,double word\n", "type: u32"),
        ("address,type\n1,Float (Little-endian byte swap)\n", "type: f32, byte_order: little"),
        ("address,type\n1,\"INT16, byte swap\"\n", "type: s16, byte_order: little"),
        ("address,type\n1,INT32 low word first\n", "type: s32, word_order: little"),
        ("address,type\n1,réel\n", "type: f32"),
        ("address,type\n1,BCD 8 digits\n", "type: bcd32"),
        ("address,type\n1,INT (unsigned)\n", "type: u16"),
        ("address,type,length\n1,bitmap,2\n", "type: u32"),
        ("address,type\n1,16 Bit ohne Vorzeichen\n", "type: u16"),
        ("address,type\n1,entier non signé 32 bits\n", "type: u32"),
        ("Adresse;Funktionscode;Messgröße;Länge\n1;04;Strom;2\n",
         "input_registers:\n  - {address: 1, name: strom, type: u32"),
        ("Adresse;Désignation;Unité;Accès\n1;Débit;m³/h;Lecture seule\n", 'debit, type: u16, unit: "m³/h", access: ro'),
        ("Indirizzo;Descrizione;Fattore\n1;Tensione;0,1\n", "name: tensione, type: u16, scale: 0.1"),
        ("Dirección;Nombre;Escala\n1;Tensión;0,1\n", "name: tension, type: u16, scale: 0.1"),
        ("ACME 3000, edition 2\n\nAddress;Name;Type\n7;Flow;REAL\n", "{address: 7, name: flow, type: f32}"),
        ("address,table\n1,Read Holding Registers (03)\n2,R04\n", "input_registers:\n  - {address: 2,"),
        ("address,table\n1,4xxxx\n2,3xxxx\n", "input_registers:\n  - {address: 2,"),
        ("address,table\n1,0x10\n2,0x04\n", "input_registers:\n  - {address: 2,"),
        ("Address;Name;Type\n40006.0;Ready;BOOL\n40006.3;Fault;BOOL\n40007;Speed;INT\n",
         "{address: 5, name: holding_register_5, type: u16, bits: [{bit: 0, name: ready}, {bit: 3, name: fault}]}"),
        ("address,name,type,bit,fc\n5,status,u16,,4\n5,ready,,0,4\n5,fault,bool,15,4\n",
         "input_registers:\n  - {address: 5, name: status, type: u16, bits: [{bit: 0, name: ready}, {bit: 15, "),
        ("address,name,bit\n5,x,0\n5,x,1\n", "bits: [{bit: 0, name: x}, {bit: 1, name: x_1}]"),
        ("address,name,bit\n9,holding register 5,\n5,x,0\n", "{address: 5, name: holding_register_5_bits, type: u16, "),
        ("address,name,type,bit,fc\n5,run,bool,,1\n", "coils:\n  - {address: 5, name: run}"),
        ("address,unit\n1,N/A\n", "{address: 1, name: holding_register_1, type: u16}"),
    ],
)  # fmt: skip
def test_what_people_write_is_understood(tmp_path: Path, text: str, entry: str) -> None:
    assert entry in table_of(tmp_path, text)


@pytest.mark.parametrize(
    ("text", "note"),
    [
        ("address,fc\n1,99\n", "Line 2: '99' is no table; holding registers was taken."),
        ("address,name,scale\n1,a,see below\n", "Line 2: its factor is no number; 1 was taken."),
        ("address,name,scale\n1,a,b\n2,b,a\n", "Line 3: its factor is no number; 1 was taken."),
        ("address,Pos,Nr.,empty\n1,0,1,\n", "Not read: the columns Pos, Nr."),
        ("address,name,bit\n1,a,0\n1,b,0\n", "Line 3 is left out: its address is in use by holding_register_1."),
        ("address,name,bit\n1,a,0\n1,b,16\n", "Line 3 is left out: '16' is no bit from 0 to 15."),
        ("address,type,bit,name\n1,f32,,x\n1,bool,0,b\n", "Line 3 is left out: bits: "),
        ("a meter\naddress,type\n1,int 24\n2,u16\n", "Line 3 is left out: 'int 24' is no type that is known."),
        ("address,type,words\n1,u16,4\n", "Line 2: its length is 4, but u16 needs 1."),
        ("address,type\n1,u16[3]\n3,u16\n", "Line 3 is left out: its address is in use by holding_register_1."),
    ],
)
def test_what_is_assumed_is_said_with_its_line(tmp_path: Path, text: str, note: str) -> None:
    made = table_of(tmp_path, text)
    assert f"# {note}" in made
    (tmp_path / "made.yaml").write_text(made)
    load_table(tmp_path / "made.yaml")


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_a_list_may_have_any_encoding_of_a_spreadsheet(tmp_path: Path, encoding: str) -> None:
    (tmp_path / "list.csv").write_bytes("address;unit\r\n1;°C\r\n".encode(encoding))
    assert 'unit: "°C"' in read_list(tmp_path / "list.csv").text("list.csv")


def test_an_address_that_is_in_use_is_left_out_with_its_line(tmp_path: Path) -> None:
    made = table_of(tmp_path, "address,name,type\n1,a,u32\n2,b,u16\n3,c,u16\n")
    assert "# Line 3 is left out: its address is in use by a." in made
    assert made.count("- {") == 2


def test_the_rig_of_a_list_passes_its_own_test(tmp_path: Path, fieldrig_rig: RigMaker) -> None:
    (tmp_path / "my meter.csv").write_text(METER)
    folder = tmp_path / "bench"
    made = new("--registers", tmp_path / "my meter.csv", folder)
    assert made.exit_code == 0
    assert "note: Line 9 is left out" in made.stdout
    (test,) = folder.glob("test_*.py")
    runpy.run_path(str(test))["test_a_master_reads_mode"](fieldrig_rig)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("name,type\na,u16\n", "expected a column such as `address`, got name, type"),
        ("address,name\nnone,a\n", "no row is a register"),
        ("", "rows of values"),
        ("address,access\n1,wo\n", "no client can read"),
    ],
)
def test_a_file_that_is_no_list_is_refused(tmp_path: Path, text: str, told: str) -> None:
    (tmp_path / "list.csv").write_text(text)
    refused = new("--registers", tmp_path / "list.csv", tmp_path / "bench")
    assert refused.exit_code != 0
    assert told in str(refused.exception)
    assert not (tmp_path / "bench").exists()


def test_one_file_at_a_time(tmp_path: Path) -> None:
    (tmp_path / "list.csv").write_text(METER)
    assert "either --eds or --registers" in new("--registers", tmp_path / "list.csv", "--eds", "a.eds").output


CELL = st.text(st.sampled_from('0134x9hAbcFC -/.[]"é,;\n'), max_size=8)


@given(st.lists(st.lists(CELL, min_size=6, max_size=6), min_size=1, max_size=6))
def test_any_rows_make_a_table_that_loads_or_are_refused(
    tmp_path_factory: pytest.TempPathFactory, rows: list[list[str]]
) -> None:
    folder = tmp_path_factory.getbasetemp()
    text = "\n".join(",".join(row) for row in [["address", "name", "type", "scale", "fc", "bit"], *rows])
    try:
        table = table_of(folder, text)
    except ValueError:
        return
    (folder / "made.yaml").write_text(table, encoding="utf-8")
    load_table(folder / "made.yaml")


WORD_ORDER, BYTE_ORDER = "word_order: little", "byte_order: little"


@pytest.mark.parametrize(
    ("type", "orders", "is_assumed"),
    [
        ("s32 swapped", {WORD_ORDER}, False),
        ("float word swap", {WORD_ORDER}, False),
        ("UINT32 LSW first", {WORD_ORDER}, False),
        ("int32 (low word first)", {WORD_ORDER}, False),
        ("U32 byte-swapped", {BYTE_ORDER}, False),
        ("FLOAT32-DCBA", {WORD_ORDER, BYTE_ORDER}, False),
        ("UINT32 LE", {WORD_ORDER, BYTE_ORDER}, True),
        ("Float inverse", {WORD_ORDER, BYTE_ORDER}, True),
        ("u32 big endian", set(), False),
        ("single precision float", set(), False),
    ],
)
def test_the_order_of_a_value_in_words(tmp_path: Path, type: str, orders: set[str], is_assumed: bool) -> None:
    table = table_of(tmp_path, f"address,name,type\n7,flow,{type}\n")
    assert {order for order in (WORD_ORDER, BYTE_ORDER) if order in table} == orders
    assert ("# Line 2:" in table) == is_assumed


@pytest.mark.parametrize(
    ("heading", "cell", "order"),
    [
        ("order", "CDAB", "word_order: little"),
        ("Byte order", "3-4-1-2", "word_order: little"),
        ("Byte Order", "2143", "byte_order: little"),
        ("Endianness", "big-endian", ""),
        ("Endian", "Little-endian byte swap", "byte_order: little"),
        ("Word order", "little", "word_order: little"),
        ("Word order", "high word first", ""),
        ("Word Swap", "yes", "word_order: little"),
        ("Word Swap", "no", ""),
        ("Byte order", "D C B A", "word_order: little, byte_order: little"),
    ],
)
def test_an_order_in_a_column_of_its_own(tmp_path: Path, heading: str, cell: str, order: str) -> None:
    text = table_of(tmp_path, f"address,name,type,{heading}\n0,a,float32,{cell}\n")
    assert f"type: f32{', ' if order else ''}{order}}}" in text
    assert "Not read" not in text


@pytest.mark.parametrize(
    ("cell", "names"),
    [
        ("0=Off;1=On;2=Auto", '{0: "Off", 1: "On", 2: Auto}'),
        ("0: stop, 1: run, forward", '{0: stop, 1: "run, forward"}'),
        ("0x01 = ready | 0x02 -> running", "{1: ready, 2: running}"),
        ("0 - idle\n1 - heating", "{0: idle, 1: heating}"),
        ("0=a/b / 1=c", '{0: "a/b", 1: c}'),
    ],
)
def test_names_of_values_in_a_column(tmp_path: Path, cell: str, names: str) -> None:
    text = table_of(tmp_path, f'address,name,type,values\n0,mode,uint16,"{cell}"\n')
    assert f"values: {names}" in text
    (tmp_path / "table.yaml").write_text(text, encoding="utf-8")
    load_table(tmp_path / "table.yaml")


@pytest.mark.parametrize("cell", ["0-100", "0..100", "any", "-1=left;1=right", "0=a;1=a", "00=x"])
def test_other_texts_in_the_column_of_values_are_said_and_cost_no_register(tmp_path: Path, cell: str) -> None:
    text = table_of(tmp_path, f'address,name,type,values\n0,mode,uint16,"{cell}"\n')
    assert "{address: 0, name: mode, type: u16}" in text
    assert "# Not read as names of values: " in text
