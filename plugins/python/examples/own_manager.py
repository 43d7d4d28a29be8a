"""A fleet manager of your own: sends robots to random nodes so that they never touch.

A robot drives an edge only while it alone holds that edge and all edges that come too near to it.

    regatta engine graphs/warehouse-managed.yaml --robots 30 &
    python plugins/python/examples/own_manager.py
"""

import random
import sys
from collections import deque

import numpy as np

import regatta

options = regatta.parser(__doc__).parse_args()
fleet = regatta.join(options.fleet, options.name)
try:
    fleet.own()
except regatta.OwnedError as error:  # another manager moves the robots
    sys.exit(f"own_manager: {error}")


def near_edges(world: regatta.World, apart: float) -> list[list[int]]:
    """Returns for each edge the edges that come nearer to it than ``apart`` metres, itself included."""
    t = np.linspace(0, 1, 9)[:, None]
    weights = np.hstack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3])
    points = [np.concatenate([weights @ curve for curve in world.curves_of(edge)]) for edge in range(len(world.edges))]
    low, high = np.array([p.min(0) for p in points]) - apart, np.array([p.max(0) for p in points])
    near = []
    for edge, own in enumerate(points):
        others = np.flatnonzero(np.all((low <= own.max(0)) & (high >= own.min(0) - apart), axis=1))
        gap = [np.linalg.norm(own[:, None] - points[other], axis=2).min() for other in others]
        near.append(others[np.array(gap) < apart].tolist())
    return near


def way(world: regatta.World, exits: list[list[int]], start: int, goal: int) -> list[int]:
    """Returns the edges of a way with the fewest edges; an empty list if there is none."""
    came_by, queue, edges = dict[int, int](), deque([start]), list[int]()
    while queue and goal not in came_by:
        for edge in exits[queue.popleft()]:
            end = int(world.edges["destination"][edge])
            if end != start and end not in came_by:
                came_by[end] = edge
                queue.append(end)
    while goal in came_by:
        edges.insert(0, came_by[goal])
        goal = int(world.edges["origin"][edges[0]])
    return edges


commands, run_id = fleet.commands(), None
held, routes, waiting = dict[int, list[int]](), dict[int, list[int]](), dict[int, int]()
for frame in fleet.frames(options.rate or 10, options.after):
    world = frame.world
    if frame.run_id != run_id:  # another run: nothing is held any more
        run_id, held, routes, waiting = frame.run_id, {}, {}, {}
        size = max(np.hypot(kind["length"], kind["width"]) for kind in world.robot_types)
        near = near_edges(world, size + 0.3)  # 0.3 m: the points of a curve are not all of it
        exits = [np.flatnonzero(world.edges["origin"] == node).tolist() for node in range(len(world.nodes))]
    held |= {robot: [int(edge)] for robot, edge in enumerate(frame.edge) if robot not in held and edge != regatta.NO_EDGE}
    for robot, edges in held.items():  # what lies behind a robot is free again
        if frame.edge[robot] in edges:
            del edges[: edges.index(frame.edge[robot])]
    holders: dict[int, set[int]] = {}
    for robot, edges in held.items():
        for edge in edges:
            holders.setdefault(edge, set()).add(robot)
    for robot, edges in sorted(held.items(), key=lambda item: -waiting.get(item[0], 0)):
        if len(edges) > 1:
            continue
        if not routes.get(robot) or waiting.get(robot, 0) > 100:  # a new goal, too, after ten seconds
            end = world.edges["destination"][edges[-1]]
            routes[robot], waiting[robot] = way(world, exits, end, random.randrange(len(world.nodes))), 0
        elif all(holders.get(edge, {robot}) == {robot} for edge in near[routes[robot][0]]):
            edge = routes[robot].pop(0)
            commands.extend(robot, [int(world.edges["id"][edge])])
            edges.append(edge)
            holders.setdefault(edge, set()).add(robot)
            waiting[robot] = 0
        else:
            waiting[robot] = waiting.get(robot, 0) + 1
    commands.send()
