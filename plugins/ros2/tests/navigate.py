"""Sends goals of NavigateToPose to robot_0, as a client of Nav2 does.

    navigate.py DOMAIN X Y

One goal is driven to its end, one is cancelled, one is refused. Prints what has happened as JSON.
"""

import json
import sys
import uuid
from dataclasses import asdict

import idl
from peer import Peer, wait

NAME = "regatta/robot_0/navigate_to_pose/_action"


def goal_id():
    return idl.UUID(list(uuid.uuid4().bytes))


def main():
    peer, (x, y) = Peer(int(sys.argv[1])), map(float, sys.argv[2:4])

    def service(name, request, response):
        return peer.service(f"{NAME}/{name}", request, response)

    action = "NavigateToPose"
    send = service(
        "send_goal", getattr(idl, f"{action}_SendGoal_Request"), getattr(idl, f"{action}_SendGoal_Response")
    )
    result = service(
        "get_result", getattr(idl, f"{action}_GetResult_Request"), getattr(idl, f"{action}_GetResult_Response")
    )
    cancel = service("cancel_goal", idl.CancelGoal_Request, idl.CancelGoal_Response)
    feedback = peer.reader(f"rt/{NAME}/feedback", idl.NavigateToPose_FeedbackMessage)

    def goal(x, y, frame="map"):
        pose = idl.PoseStamped(idl.Header(frame_id=frame), idl.Pose(idl.Point(x, y)))
        return idl.NavigateToPose_SendGoal_Request(goal_id(), idl.NavigateToPose_Goal(pose))

    found = {}
    first = goal(x, y)
    found["accepted"] = send.call(first).accepted
    result.send(idl.NavigateToPose_GetResult_Request(first.goal_id))
    told = wait("feedback", lambda: next(iter(feedback.take(1)), None))
    found["feedback"] = asdict(told.feedback)
    found["feedback_of_goal"] = list(told.goal_id.uuid) == list(first.goal_id.uuid)
    found["status"] = result.receive().status
    again = result.call(idl.NavigateToPose_GetResult_Request(first.goal_id))
    found["status_again"] = again.status
    found["unknown_status"] = result.call(idl.NavigateToPose_GetResult_Request(goal_id())).status

    found["refused"] = send.call(goal(x, y, frame="moon")).accepted

    second = goal(2.0, 0.0)
    found["second_accepted"] = send.call(second).accepted
    result.send(idl.NavigateToPose_GetResult_Request(second.goal_id))
    answer = cancel.call(idl.CancelGoal_Request(idl.GoalInfo(second.goal_id)))
    found["cancel"] = {"code": answer.return_code, "goals": len(answer.goals_canceling)}
    found["cancelled_status"] = result.receive().status
    answer = cancel.call(idl.CancelGoal_Request(idl.GoalInfo(goal_id())))
    found["cancel_unknown"] = answer.return_code
    print(json.dumps(found))


main()
