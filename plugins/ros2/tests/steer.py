"""Steers a fleet of Regatta as any node of ROS 2 does: a goal, a wrong goal, pause and speed.

    steer.py X Y

Sends robot_0 to the node nearest to (X, Y), and prints what has happened as JSON.
"""

import json
import sys
import time

import rclpy
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from rcl_interfaces.msg import Log
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64
from std_srvs.srv import SetBool

TIMEOUT = 45.0


class Steering:
    def __init__(self):
        self.node = rclpy.create_node("steering")
        self.clock, self.place, self.logs = 0.0, None, []
        node = self.node
        node.create_subscription(Clock, "/clock", self.take_clock, 10)
        node.create_subscription(Odometry, "/regatta/robot_0/odom", self.take_odometry, 10)
        latched = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        node.create_subscription(Log, "/rosout", self.take_log, latched)
        self.goals = node.create_publisher(PoseStamped, "/regatta/robot_0/goal_pose", 10)
        self.speeds = node.create_publisher(Float64, "/regatta/speed", 10)
        self.pauses = node.create_client(SetBool, "/regatta/pause")

    def take_clock(self, message):
        self.clock = message.clock.sec + message.clock.nanosec * 1e-9

    def take_odometry(self, message):
        position = message.pose.pose.position
        self.place = (position.x, position.y)

    def take_log(self, message):
        if message.name == "regatta":
            self.logs.append(message.msg)

    def spin(self, seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            rclpy.spin_once(self.node, timeout_sec=0.02)

    def wait(self, what, is_there):
        end = time.monotonic() + TIMEOUT
        while not is_there():
            assert time.monotonic() < end, f"{what}: not within {TIMEOUT} s; {vars(self)}"
            self.spin(0.05)

    def send(self, x, y, frame="map"):
        goal = PoseStamped()
        goal.header.frame_id = frame
        goal.pose.position.x, goal.pose.position.y = x, y
        goal.pose.orientation.w = 1.0
        self.goals.publish(goal)

    def pause(self, is_wanted):
        call = self.pauses.call_async(SetBool.Request(data=is_wanted))
        self.wait("an answer to pause", call.done)
        return call.result().success

    def advance(self, seconds):
        """Returns by how much the clock has advanced."""
        before = self.clock
        self.spin(seconds)
        return self.clock - before


def main():
    x, y = float(sys.argv[1]), float(sys.argv[2])
    rclpy.init()
    steering = Steering()
    steering.wait("odometry", lambda: steering.place is not None and steering.clock > 0.0)
    steering.wait("a reader of goals", lambda: steering.goals.get_subscription_count() > 0)
    start = steering.place
    steering.send(x, y)
    there = lambda: abs(steering.place[0] - x) + abs(steering.place[1] - y) < 0.1
    steering.wait("the robot at its goal", there)
    steering.send(x, y, frame="moon")
    steering.wait("a refusal in the log", lambda: any("moon" in text for text in steering.logs))
    assert steering.pauses.wait_for_service(TIMEOUT)
    paused = steering.pause(True)
    steering.spin(0.3)
    while_paused = steering.advance(0.5)
    resumed = steering.pause(False)
    steering.wait("a reader of speeds", lambda: steering.speeds.get_subscription_count() > 0)
    steering.speeds.publish(Float64(data=8.0))
    steering.spin(1.0)
    print(
        json.dumps(
            {
                "start": start,
                "place": steering.place,
                "paused": paused,
                "advance_while_paused": while_paused,
                "resumed": resumed,
                "advance_at_speed_8": steering.advance(1.0),
                "logs": steering.logs,
            }
        )
    )


main()
