"""Listens to topics of Regatta as any node of ROS 2 does, and prints what has come as JSON.

    listen.py SECONDS TOPIC:PACKAGE/TYPE[:latched] …

Of each topic: how many messages came, and the last one, with long arrays cut to three elements and
their length.
"""

import importlib
import json
import sys
import time

import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message


def plain(value):
    """Returns a message as dictionaries, lists and numbers."""
    if hasattr(value, "get_fields_and_field_types"):
        return {name: plain(getattr(value, name)) for name in value.get_fields_and_field_types()}
    if isinstance(value, bytes):
        return list(value)
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, (list, tuple)) or type(value).__name__ == "array":
        values = [plain(element) for element in list(value)[:3]]
        return values + [{"length": len(value)}] if len(value) > 3 else values
    if isinstance(value, float) and value != value:
        return None
    return value


def main():
    seconds = float(sys.argv[1])
    rclpy.init()
    node = rclpy.create_node("listener")
    found = {}
    for argument in sys.argv[2:]:
        topic, kind, *options = argument.split(":")
        package, name = kind.split("/")
        message_type = getattr(importlib.import_module(f"{package}.msg"), name)
        latched = "latched" in options
        qos = QoSProfile(
            depth=10,
            reliability=ReliabilityPolicy.RELIABLE,
            durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
        )
        entry = found[topic] = {"count": 0, "bytes": 0, "last": None}

        def take(raw, entry=entry, message_type=message_type):
            entry["count"] += 1
            entry["bytes"] = len(raw)
            entry["last"] = (message_type, raw)

        node.create_subscription(message_type, topic, take, qos, raw=True)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        rclpy.spin_once(node, timeout_sec=0.05)
    for entry in found.values():
        if entry["last"]:
            message_type, raw = entry["last"]
            entry["last"] = plain(deserialize_message(raw, message_type))
    print(json.dumps({"topics": found, "nodes": node.get_node_names_and_namespaces()}))


main()
