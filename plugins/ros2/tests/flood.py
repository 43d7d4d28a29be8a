"""Floods robot_0 with goals, and sends messages whose bytes aren't those of their type.

    flood.py DOMAIN SECONDS
"""

import sys
import time
from dataclasses import dataclass

import idl
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import sequence, uint8
from peer import Peer

WRONG = [[], [255] * 3, [255] * 64, [0] * 7, list(range(200)), [1, 0, 0, 128] * 40]


@dataclass
class Wrong(IdlStruct, typename="geometry_msgs::msg::dds_::PoseStamped_"):
    data: sequence[uint8]


@dataclass
class WrongRequest(
    IdlStruct, typename="simulation_interfaces::srv::dds_::GetEntities_Request_"
):
    data: sequence[uint8]


def main():
    domain, seconds = int(sys.argv[1]), float(sys.argv[2])
    goals = Peer(domain).writer("rt/regatta/robot_0/goal_pose", idl.PoseStamped)
    wrong = [
        (Peer(domain).writer("rt/regatta/robot_0/goal_pose", Wrong), Wrong),
        (Peer(domain).writer("rq/regatta/get_entitiesRequest", WrongRequest), WrongRequest),
    ]
    end, number = time.monotonic() + seconds, 0
    while time.monotonic() < end:
        x, y = [(10.0, 8.0), (2.0, 10.0), (float("nan"), 0.0), (1e30, 5.0)][number % 4]
        pose = idl.Pose(idl.Point(x, y))
        goals.write(idl.PoseStamped(idl.Header(frame_id="map"), pose))
        if number % 50 == 0:
            for writer, kind in wrong:
                writer.write(kind(WRONG[number // 50 % len(WRONG)]))
        number += 1
    print(number)


main()
