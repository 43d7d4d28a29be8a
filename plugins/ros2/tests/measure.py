"""Measures what a node gets of a fleet: messages a second, their age, and what the plugin costs.

    measure.py REGATTA ROBOTS SECONDS [PLUGIN ARGUMENT …]

Starts an engine in real time, the plugin and a listener to poses. The age of a message is the wall time
between its publication (the plugin wakes with the engine's tick) and the call of the node's code,
before it is decoded.
"""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import rclpy
from geometry_msgs.msg import PoseArray
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock

ROOT = Path(__file__).resolve().parents[3]


def status(regatta, fleet):
    answer = subprocess.run([regatta, "status", "--json", "--fleet", fleet], capture_output=True)
    return json.loads(answer.stdout or "{}")


def cpu_seconds(pid):
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def percentile(values, part):
    return sorted(values)[min(int(len(values) * part), len(values) - 1)] if values else float("nan")


class Listener:
    def __init__(self, topics):
        self.node = rclpy.create_node("measure")
        self.arrivals = {}
        for topic, kind in topics.items():
            arrivals = self.arrivals[topic] = []

            def take(_, information, arrivals=arrivals):
                arrivals.append(time.time() * 1e3 - information["source_timestamp"] * 1e-6)

            self.node.create_subscription(kind, topic, take, 10, raw=True)

    def listen(self, seconds):
        for arrivals in self.arrivals.values():
            arrivals.clear()
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            rclpy.spin_once(self.node, timeout_sec=0.01)


def main():
    regatta, robots, seconds = sys.argv[1], int(sys.argv[2]), float(sys.argv[3])
    fleet = f"measure-{os.getpid()}"
    scenario = ROOT / "graphs/warehouse-1000.yaml"
    engine = subprocess.Popen(
        [regatta, "engine", scenario, "--fleet", fleet, "--robots", str(robots)],
        stderr=subprocess.DEVNULL,
    )
    while not status(regatta, fleet):
        time.sleep(0.2)
    plugin = subprocess.Popen(
        [regatta, "plugin", "ros2", "--fleet", fleet, "--domain", os.environ["ROS_DOMAIN_ID"]]
        + sys.argv[4:],
    )
    last = (min(robots, 20_000) - 1) // 2_000
    poses = "/regatta/poses" + (f"_{last}" if last else "")
    topics = {"/clock": Clock, "/regatta/poses": PoseArray, poses: PoseArray}
    topics |= {"/regatta/robot_0/odom": Odometry}
    rclpy.init()
    listener = Listener(topics)
    listener.listen(6.0)
    late = status(regatta, fleet)["late_ticks"]
    before = cpu_seconds(plugin.pid)
    listener.listen(seconds)
    share = (cpu_seconds(plugin.pid) - before) / seconds
    late = status(regatta, fleet)["late_ticks"] - late
    print(f"{robots} robots: {share:.0%} of a core, {late} late ticks in {seconds:.0f} s")
    for topic, ages in listener.arrivals.items():
        p50, p99 = percentile(ages, 0.5), percentile(ages, 0.99)
        rate = len(ages) / seconds
        print(f"  {topic}: {rate:.1f}/s, age p50 {p50:.1f} ms, p99 {p99:.1f} ms")
    for process in (plugin, engine):
        process.terminate()
        process.wait()


main()
