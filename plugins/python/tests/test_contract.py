"""The structures agree with those of Rust, from which ``layout.json`` is generated."""

import ctypes
import enum
from typing import Any

import numpy as np
import pytest

from regatta import _contract, _enums
from regatta._contract import LAYOUT, ColumnHeader, Line, Record, Sequenced, dtype
from regatta._sequence import LostSamples, SequenceCounter

RECORDS: dict[str, type[Record]] = {
    name: value
    for name, value in vars(_contract).items()
    if isinstance(value, type) and issubclass(value, Record) and value not in (Record, Sequenced, Line)
}
ENUMS: dict[str, type[enum.IntEnum]] = {
    name: value
    for name, value in vars(_enums).items()
    if isinstance(value, type) and issubclass(value, enum.IntEnum) and value is not enum.IntEnum
}

RUST = {ctypes.c_uint32: "u32", ctypes.c_uint64: "u64", ctypes.c_float: "f32", ctypes.c_double: "f64", ctypes.c_char: "u8"}


def rust(ctype: Any) -> str:
    """Returns the name of a ctypes type in Rust."""
    if issubclass(ctype, ctypes.Array):
        return f"[{rust(ctype._type_)}; {ctype._length_}]"
    return RUST[ctype]


def test_every_record_and_enum_exists() -> None:
    assert RECORDS.keys() == LAYOUT["records"].keys()
    assert ENUMS.keys() == LAYOUT["enums"].keys()


@pytest.mark.parametrize("name", LAYOUT["records"])
def test_a_record_has_the_layout_of_rust(name: str) -> None:
    record, layout = RECORDS[name], LAYOUT["records"][name]
    fields = [[field, rust(ctype), getattr(record, field).offset] for field, ctype in record._fields_]
    assert fields == layout["fields"]
    assert ctypes.sizeof(record) == layout["size"]
    assert ctypes.alignment(record) == layout["alignment"]
    numpy_type = dtype(record)
    assert numpy_type.itemsize == layout["size"]
    assert numpy_type.fields is not None and numpy_type.names is not None
    offsets = [[field, numpy_type.fields[field][1]] for field in numpy_type.names]
    assert offsets == [[field, at] for field, _, at in layout["fields"]]


@pytest.mark.parametrize("name", LAYOUT["enums"])
def test_an_enum_has_the_numbers_of_rust(name: str) -> None:
    camel = {member.name.title().replace("_", ""): member.value for member in ENUMS[name]}
    assert camel == LAYOUT["enums"][name]


def test_the_types_of_services_match_their_records() -> None:
    lines = 0
    for service in LAYOUT["services"]["PublishSubscribe"].values():
        for part in ("payload", "user_header"):
            details = service["message_type_details"][part]
            name = details["type_name"].removeprefix("regatta_")
            if name == "Line":
                lines += 1
                assert ctypes.sizeof(Line) == details["size"]
            elif name != "()":
                assert ctypes.sizeof(RECORDS[name]) == details["size"]
                assert ctypes.alignment(RECORDS[name]) == details["alignment"]
                assert RECORDS[name].type_name() == details["type_name"]
    assert lines == 3, "frames, world and columns"


def test_text_is_one_value() -> None:
    types = np.zeros(1, dtype(_contract.RobotTypeRecord))
    types["name"] = "größe".encode()
    assert types["name"][0].decode() == "größe"


def test_lost_samples_are_counted_by_their_sequence() -> None:
    lost = LostSamples()

    def before(run_id: int, sequence: int) -> int:
        return lost.before(ColumnHeader(run_id=run_id, sequence=sequence))

    assert before(1, 70) == 0, "the reader joined here"
    assert before(1, 71) == 0
    assert before(1, 74) == 2
    assert before(2, 1) == 0, "another run counts from 1"
    assert before(3, 5) == 4, "the first four of the run are lost"
    assert before(3, 2) == 0, "the publisher was replaced"
    assert lost.total == 6


def test_a_publisher_counts_the_samples_of_each_run_from_1() -> None:
    counter = SequenceCounter()
    assert [counter.next(run_id) for run_id in (7, 7, 7, 8, 8, 7)] == [1, 2, 3, 1, 2, 1]
