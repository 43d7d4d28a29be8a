"""Prints a sample of each message: its type, its bytes on DDS, and its fields as JSON.

The bytes are those of ROS 2 itself for the packages that have wheels, and of Cyclone DDS for the others.
"""

import importlib
import json
from dataclasses import fields, is_dataclass

import idl
from rclpy.serialization import serialize_message

WHEELS = {
    "builtin_interfaces": ["Time", "Duration"],
    "rcl_interfaces": ["Log"],
    "rosgraph_msgs": ["Clock"],
    "std_msgs": ["Header", "Float64", "ColorRGBA"],
    "geometry_msgs": ["PoseStamped", "PoseArray", "Twist", "Accel", "TransformStamped"],
    "nav_msgs": ["Odometry", "OccupancyGrid"],
    "visualization_msgs": ["MarkerArray"],
    "diagnostic_msgs": ["DiagnosticArray"],
}

number = 0


def count():
    """Returns a number that fits a signed byte, and that differs from its neighbours."""
    global number
    number = number % 100 + 1
    return number


def scalar(kind):
    if kind.startswith(("string", "wstring")):
        return f"text {count()}"
    if kind == "boolean":
        return count() % 2 == 1
    if kind in ("float", "double"):
        return count() + 0.5
    return bytes([count()]) if kind in ("byte", "octet") else count()


def of_ros(kind):
    """Returns a value of a type, by the name that ROS gives it."""
    if kind.startswith("sequence<"):
        return [of_ros(kind[9:-1].split(",")[0]) for _ in range(2)]
    if kind.endswith("]"):
        element, length = kind[:-1].split("[")
        return [of_ros(element) for _ in range(int(length))]
    if "/" not in kind:
        return scalar(kind)
    package, name = kind.split("/")
    message = getattr(importlib.import_module(f"{package}.msg"), name)()
    for entry, entry_kind in message.get_fields_and_field_types().items():
        setattr(message, entry, of_ros(entry_kind))
    return message


def of_idl(kind):
    """Returns a value of a type of Cyclone DDS."""
    if is_dataclass(kind):
        return kind(**{entry.name: of_idl(entry.type) for entry in fields(kind)})
    if kind is str or kind is bool:
        return scalar("string" if kind is str else "boolean")
    inner = kind.__metadata__[0]
    if hasattr(inner, "subtype"):
        return [of_idl(inner.subtype) for _ in range(getattr(inner, "length", None) or 2)]
    return scalar("double" if "float" in str(inner) else "int")


def plain(value):
    if hasattr(value, "get_fields_and_field_types"):
        names = value.get_fields_and_field_types()
    elif is_dataclass(value):
        names = [entry.name for entry in fields(value)]
    elif isinstance(value, bytes):
        return value[0]
    elif isinstance(value, (str, bool, int, float)):
        return value
    else:
        return [plain(element) for element in (value.tolist() if hasattr(value, "tolist") else value)]
    return {name: plain(getattr(value, name)) for name in names}


def main():
    for package, names in WHEELS.items():
        for name in names:
            message = of_ros(f"{package}/{name}")
            print(f"{package}/{name} {serialize_message(message).hex()} {json.dumps(plain(message))}")
    for kind in vars(idl).values():
        if is_dataclass(kind) and kind.__idl_typename__:
            package = kind.__idl__.idl_transformed_typename.split("::")[0]
            message = of_idl(kind)
            data = message.serialize(use_version_2=False).hex()
            print(f"{package}/{kind.__name__} {data} {json.dumps(plain(message))}")


main()
