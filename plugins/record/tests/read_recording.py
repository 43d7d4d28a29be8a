"""Reads a recording with only the public packages in requirements.txt, validates it, and prints a summary as JSON: the
number of messages per topic, the recording's metadata, and the digest of its frames, which the engine computes too."""

import array
import json
import math
import struct
import sys

import xxhash
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

ABSENT = 255


def digest(frames):
    """Returns the XXH3 hash (128 bits) of each tick's number and columns, little-endian."""
    hasher, last = xxhash.xxh3_128(), None
    for frame in frames:
        if frame.tick == last:
            continue
        last = frame.tick
        hasher.update(frame.tick.to_bytes(8, "little"))
        for column in (frame.x, frame.y, frame.theta, frame.speed, frame.s):
            hasher.update(array.array("f", column).tobytes())
        hasher.update(array.array("I", frame.edge).tobytes())
        hasher.update(frame.state)
    return hasher.hexdigest()


def check_poses(poses, frame):
    """Checks that poses for general tools are those of the frame of the same time."""
    assert poses.frame_id == "map"
    present = [robot for robot in range(frame.robots) if frame.state[robot] != ABSENT]
    assert len(poses.poses) == len(present), (len(poses.poses), len(present))
    for robot, pose in zip(present, poses.poses):
        assert (pose.position.x, pose.position.y) == (frame.x[robot], frame.y[robot])
        heading = 2 * math.atan2(pose.orientation.z, pose.orientation.w)
        difference = math.remainder(heading - frame.theta[robot], math.tau)
        assert abs(difference) < 1e-9, (heading, frame.theta[robot])


def check_points(cloud, frame):
    """Checks that points for general tools are the robots' positions."""
    assert [field.name for field in cloud.fields] == ["x", "y", "z", "red", "green", "blue", "alpha"]
    positions = [(x, y) for x, y, *_ in struct.iter_unpack("<fff4B", cloud.data)]
    present = [robot for robot in range(frame.robots) if frame.state[robot] != ABSENT]
    assert cloud.point_stride == 16 and positions == [(frame.x[robot], frame.y[robot]) for robot in present]


def check_graph(graph, world):
    """Checks that the lines of the scene include the walls and the ends of each curve of the world's edges."""
    (entity,) = graph.entities
    walls, roads = entity.lines
    for line in entity.lines:
        assert line.type == line.LINE_LIST and len(line.points) % 2 == 0
    assert bool(walls.points) == bool(world.background), (len(walls.points), len(world.background))
    points = {(point.x, point.y) for point in roads.points}
    for edge in world.edges:
        assert len(edge.control_points) % 8 == 0 and edge.control_points, edge.id
        for first in range(0, len(edge.control_points), 8):
            curve = edge.control_points[first : first + 8]
            assert (curve[0], curve[1]) in points and (curve[6], curve[7]) in points, edge.id


def main(path):
    topics = {}
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()], validate_crcs=True)
        summary = reader.get_summary()
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            assert schema.encoding == channel.message_encoding == "protobuf"
            topics.setdefault(channel.topic, []).append((message.log_time, decoded))
        counts = {
            summary.channels[channel].topic: count
            for channel, count in summary.statistics.channel_message_counts.items()
        }
        about = {metadata.name: metadata.metadata for metadata in reader.iter_metadata()}
    assert counts == {topic: len(messages) for topic, messages in topics.items()}
    frames = dict(topics["/frames"])
    for log_time, frame in topics["/frames"]:
        assert len(frame.x) == len(frame.edge) == len(frame.state) == frame.robots
        assert frame.sim_time_nanos == log_time
    for log_time, poses in topics.get("/poses", []):
        check_poses(poses, frames[log_time])
    for log_time, cloud in topics.get("/robots", []):
        check_points(cloud, frames[log_time])
    for (_, graph), (_, world) in zip(topics["/graph"], topics["/world"], strict=True):
        check_graph(graph, world)
    json.dump({"topics": counts, "digest": digest(frame for _, frame in topics["/frames"]), "about": about}, sys.stdout)


main(sys.argv[1])
