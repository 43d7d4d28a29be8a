"""Calls the services of simulation_interfaces, as tools for simulators do.

    simulate.py DOMAIN

Prints the answers as JSON. The fleet has two robots.
"""

import json
import sys
from dataclasses import asdict

import idl
from peer import Peer


def main():
    peer = Peer(int(sys.argv[1]))
    answers = {}

    def service(name, kind):
        request, response = getattr(idl, f"{kind}_Request"), getattr(idl, f"{kind}_Response")
        return peer.service(f"regatta/{name}", request, response)

    def call(key, to, request):
        answers[key] = asdict(to.call(request))
        return answers[key]

    features = service("get_simulator_features", "GetSimulatorFeatures")
    entities = service("get_entities", "GetEntities")
    state_of = service("get_entity_state", "GetEntityState")
    get_state = service("get_simulation_state", "GetSimulationState")
    set_state = service("set_simulation_state", "SetSimulationState")
    step = service("step_simulation", "StepSimulation")
    spawn = service("spawn_entity", "SpawnEntity")
    delete = service("delete_entity", "DeleteEntity")

    call("features", features, idl.GetSimulatorFeatures_Request())
    call("entities", entities, idl.GetEntities_Request())
    pattern = idl.EntityFilters(filter="_1$")
    call("entities_by_pattern", entities, idl.GetEntities_Request(filters=pattern))
    call("entity", state_of, idl.GetEntityState_Request(entity="robot_1"))
    call("unknown_entity", state_of, idl.GetEntityState_Request(entity="robot_99"))
    call("step_while_playing", step, idl.StepSimulation_Request(steps=5))

    def set_to(key, state):
        call(key, set_state, idl.SetSimulationState_Request(idl.SimulationState(state)))

    set_to("pause", 2)
    set_to("pause_again", 2)
    set_to("stop", 0)
    call("paused", get_state, idl.GetSimulationState_Request())
    before = state_of.call(idl.GetEntityState_Request(entity="robot_0")).state.header.stamp
    call("step", step, idl.StepSimulation_Request(steps=25))
    after = state_of.call(idl.GetEntityState_Request(entity="robot_0")).state.header.stamp
    answers["stepped"] = after.sec - before.sec + (after.nanosec - before.nanosec) * 1e-9
    set_to("play", 1)
    call("playing", get_state, idl.GetSimulationState_Request())

    at = idl.PoseStamped(pose=idl.Pose(position=idl.Point(x=10.0, y=8.0)))
    amr = idl.Resource(uri="amr")
    call("spawn", spawn, idl.SpawnEntity_Request("", True, amr, "", at))
    far = idl.PoseStamped(pose=idl.Pose(position=idl.Point(x=500.0, y=8.0)))
    call("spawn_far", spawn, idl.SpawnEntity_Request("", True, amr, "", far))
    call("spawn_by_name", spawn, idl.SpawnEntity_Request("mine", False, amr, "", at))
    call("entities_then", entities, idl.GetEntities_Request())
    call("delete", delete, idl.DeleteEntity_Request(entity="robot_2"))
    call("entities_at_last", entities, idl.GetEntities_Request())
    print(json.dumps(answers))


main()
