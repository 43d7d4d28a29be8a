"""Talks to a fleet as Open-RMF's fleet adapter does: states, a path, a mode, a door and a lift.

    rmf.py DOMAIN FLEET

The fleet is that of graphs/lift.yaml without a manager. Prints what has happened as JSON.
"""

import json
import sys
from dataclasses import asdict

import idl
from peer import Peer, wait


def main():
    peer, fleet_name = Peer(int(sys.argv[1])), sys.argv[2]
    fleets = peer.reader("rt/fleet_states", idl.FleetState)
    doors = peer.reader("rt/door_states", idl.DoorState)
    lifts = peer.reader("rt/lift_states", idl.LiftState)
    paths = peer.writer("rt/robot_path_requests", idl.PathRequest)
    modes = peer.writer("rt/robot_mode_requests", idl.ModeRequest)
    door_requests = peer.writer("rt/door_requests", idl.DoorRequest)
    lift_requests = peer.writer("rt/lift_requests", idl.LiftRequest)

    def robot(is_wanted=lambda robot: True):
        def attempt():
            for fleet in fleets.take(20):
                first = next(it for it in fleet.robots if it.name == "robot_0")
                if fleet.name == fleet_name and is_wanted(first):
                    return first

        return wait("a state of robot_0", attempt)

    def facility(reader, is_wanted):
        return wait("a state", lambda: next(filter(is_wanted, reader.take(50)), None))

    found = {"robot": asdict(robot())}
    door_requests.write(idl.DoorRequest(idl.Time(), "rmf", "hall", idl.DoorMode(2)))
    facility(doors, lambda door: door.door_name == "hall" and door.current_mode.value == 1)
    facility(doors, lambda door: door.door_name == "hall" and door.current_mode.value == 2)
    lift_requests.write(idl.LiftRequest("lift", idl.Time(), "rmf", 1, "upper", 2))
    moving = facility(lifts, lambda lift: lift.motion_state == 1)
    found["destination"] = moving.destination_floor
    there = facility(lifts, lambda lift: lift.current_floor == "upper" and lift.door_state == 2)
    found["lift"] = asdict(there)
    lift_requests.write(idl.LiftRequest("lift", idl.Time(), "rmf", 0, "", 0))

    places = [float(number) for number in sys.argv[3:5]]
    end = idl.Location(x=places[0], y=places[1], level_name=sys.argv[5])
    paths.write(idl.PathRequest(fleet_name, "robot_0", [end], "task-7"))
    found["moving"] = robot(lambda it: it.task_id == "task-7" and it.mode.mode == 2).mode.mode
    mode = idl.RobotMode(3, 11)
    modes.write(idl.ModeRequest(fleet_name, "robot_0", mode, "task-8", []))
    paused = robot(lambda it: it.mode.mode == 3)
    found["paused"] = [paused.task_id, paused.mode.mode_request_id]
    modes.write(idl.ModeRequest(fleet_name, "robot_0", idl.RobotMode(2, 12), "task-8", []))

    def is_there(it):
        return abs(it.location.x - end.x) + abs(it.location.y - end.y) < 0.1 and it.mode.mode == 0

    found["there"] = asdict(robot(is_there).location)
    print(json.dumps(found))


main()
