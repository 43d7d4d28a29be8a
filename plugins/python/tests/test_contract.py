"""The structures agree with Rust's, which wrote ``layout.json``."""

import ctypes
import enum
from typing import Any

import numpy as np
import pytest

from regatta import _contract, _enums
from regatta._contract import LAYOUT, Line, Record, dtype

RECORDS: dict[str, type[Record]] = {
    name: value
    for name, value in vars(_contract).items()
    if isinstance(value, type) and issubclass(value, Record) and value not in (Record, Line)
}
ENUMS: dict[str, type[enum.IntEnum]] = {
    name: value
    for name, value in vars(_enums).items()
    if isinstance(value, type) and issubclass(value, enum.IntEnum) and value is not enum.IntEnum
}

RUST = {ctypes.c_uint32: "u32", ctypes.c_uint64: "u64", ctypes.c_float: "f32", ctypes.c_char: "u8"}


def rust(kind: Any) -> str:
    """A ctypes type as Rust writes it."""
    if issubclass(kind, ctypes.Array):
        return f"[{rust(kind._type_)}; {kind._length_}]"
    return RUST[kind]


def test_every_record_and_enum_is_here() -> None:
    assert RECORDS.keys() == LAYOUT["records"].keys()
    assert ENUMS.keys() == LAYOUT["enums"].keys()


@pytest.mark.parametrize("name", LAYOUT["records"])
def test_record(name: str) -> None:
    record, layout = RECORDS[name], LAYOUT["records"][name]
    fields = [[field, rust(kind), getattr(record, field).offset] for field, kind in record._fields_]
    assert fields == layout["fields"]
    assert ctypes.sizeof(record) == layout["size"]
    assert ctypes.alignment(record) == layout["alignment"]
    kind = dtype(record)
    assert kind.itemsize == layout["size"]
    assert kind.fields is not None and kind.names is not None
    assert [[field, kind.fields[field][1]] for field in kind.names] == [[field, at] for field, _, at in layout["fields"]]


@pytest.mark.parametrize("name", LAYOUT["enums"])
def test_enum(name: str) -> None:
    camel = {member.name.title().replace("_", ""): member.value for member in ENUMS[name]}
    assert camel == LAYOUT["enums"][name]


def test_services_have_the_types_that_they_name() -> None:
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
