"""Layouts of other systems are driven where their files say: one robot on each edge, checked against curves that are
computed from the files without Regatta."""

import json
import math
import re
import subprocess
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from conftest import ROOT, Engine, binary, eventually
from imported import dxf, lif, moving_ai, nav2, open_rmf, open_tcs, tables
from imported.curves import Array, Edge

import regatta

FILES = ROOT / "graphs/imported"

TOLERANCE = 1e-3
"""The largest distance of a pose from the curve, and error of ``s``, in metres."""
ANGLE = math.radians(0.1)
"""The largest error of a heading."""
CORNER = 1e-4
"""Segments this much farther away than the nearest one count as well, in metres: at a corner, both directions do."""
MOST_INSIDE = 3
"""The number of poses inside that an edge has at least, if it takes so many ticks."""
TICKS = 200
"""About the number of ticks of the longest edge."""
MOST_TICKS = 2000
"""The largest number of ticks."""


@dataclass(frozen=True, eq=False)
class Layout:
    """A layout, and what its format says about it."""

    file: str
    edges: Callable[[Path], list[Edge]]
    options: dict[str, str] = field(default_factory=dict)
    """The options of the command line that read it."""

    @property
    def path(self) -> Path:
        return FILES / self.file

    @property
    def expected(self) -> list[Edge]:
        return self.edges(self.path)


def building(name: str) -> Layout:
    """Returns a map of a building, with the lanes that Open-RMF's own generator finds in it."""

    def lanes(path: Path) -> list[Edge]:
        graphs = sorted((FILES / "open-rmf" / name).glob("*.yaml"))
        found = [edge for graph in graphs for edge in open_rmf.edges(graph)]
        # The ids of the generated lanes aren't those of the map. Graphs share the edges of a lift.
        lifts = {tuple(np.ravel([edge.curve.starts, edge.curve.ends])): edge for edge in found if not edge.name}
        return [*(Edge(edge.curve, offset=edge.offset) for edge in found if edge.name), *lifts.values()]

    return Layout(f"open-rmf/{name}.building.yaml", lanes)


LAYOUTS = [
    *(Layout(f"lif/{path.name}", lif.edges) for path in sorted((FILES / "lif").glob("*.lif.json"))),
    Layout("lif/ex_10_10.lif.json", lambda path: lif.edges(path, "Vehicle_Type_2"), {"vehicle-type": "Vehicle_Type_2"}),
    *(Layout(str(path.relative_to(FILES)), open_rmf.edges) for path in sorted((FILES / "open-rmf").glob("*/*.yaml"))),
    *(building(path.name) for path in sorted((FILES / "open-rmf").iterdir()) if path.is_dir()),
    *(Layout(f"nav2/{path.name}", nav2.edges) for path in sorted((FILES / "nav2").glob("*.geojson"))),
    *(Layout(f"opentcs/{path.name}", open_tcs.edges) for path in sorted((FILES / "opentcs").glob("*.xml"))),
    Layout("movingai/empty-8-8.map", moving_ai.edges),
    Layout("movingai/empty-8-8.map", lambda path: moving_ai.edges(path, 0.5), {"cell-size": "0.5"}),
    Layout("movingai/random-32-32-10.map", moving_ai.edges),
    Layout("dxf/depot.dxf", lambda path: dxf.edges(path, {"routes"}), {"layer": "routes"}),
    Layout("dxf/depot.dxf", dxf.edges),
    Layout("dxf/cc_dxflib.dxf", dxf.edges),
    Layout("dxf/multi_insert_with_attribs.dxf", dxf.edges),
    Layout("csv/depot-nodes.csv", lambda path: tables.edges(path, path.with_name("depot-edges.csv"))),
]


def title(layout: Layout) -> str:
    """Returns the name of a case."""
    return " ".join([layout.file, *layout.options.values()])


@pytest.mark.parametrize("layout", LAYOUTS, ids=title)
def test_each_edge_is_driven_where_its_file_says(engine: Engine, tmp_path: Path, layout: Layout) -> None:
    drive(engine, tmp_path, layout.path, layout.expected, layout.options)


def test_paths_of_a_plant_are_driven_in_reverse_gear(engine: Engine, tmp_path: Path) -> None:
    """None of the files has a reverse velocity on a path that isn't locked."""
    plant = tmp_path / "plant.xml"
    text = (FILES / "opentcs/Demo-01.xml").read_text()
    plant.write_text(text.replace('maxReverseVelocity="0"', 'maxReverseVelocity="800"'))
    expected = open_tcs.edges(plant)
    assert all(edge.reverse for edge in expected)
    drive(engine, tmp_path, plant, expected)


def test_paths_of_a_plant_without_a_forward_velocity_are_driven_tail_first(engine: Engine, tmp_path: Path) -> None:
    plant = tmp_path / "plant.xml"
    text = (FILES / "opentcs/Demo-01.xml").read_text()
    text = re.sub(r'maxVelocity="(\d+)" maxReverseVelocity="0"', r'maxVelocity="0" maxReverseVelocity="\1"', text)
    plant.write_text(text)
    expected = open_tcs.edges(plant)
    assert all(edge.offset == math.pi for edge in expected)
    drive(engine, tmp_path, plant, expected)


Nurbs = tuple[int, list[float], list[tuple[float, float]], list[float]]

CURVES: dict[str, Nurbs] = {
    "a quarter of a circle": (2, [0, 0, 0, 1, 1, 1], [(0, 0), (5, 0), (5, 5)], [1, math.sqrt(0.5), 1]),
    "three quarters": (
        2,
        [0, 0, 0, 1, 1, 2, 2, 3, 3, 3],
        [(0, 0), (5, 0), (5, 5), (5, 10), (0, 10), (-5, 10), (-5, 5)],
        [1, math.sqrt(0.5), 1, math.sqrt(0.5), 1, math.sqrt(0.5), 1],
    ),
    "degree 3 with inner knots": (
        3,
        [0, 0, 0, 0, 0.3, 0.7, 1, 1, 1, 1],
        [(0, 0), (2, 3), (4, 3), (6, -2), (8, 1), (9, 4)],
        [1] * 6,
    ),
    "degree 4": (4, [0, 0, 0, 0, 0, 1, 1, 1, 1, 1], [(0, 0), (2, 4), (5, 4), (7, -2), (9, 2)], [1] * 5),
    "degree 3 with weights": (3, [0, 0, 0, 0, 1, 1, 1, 1], [(0, 0), (3, 0), (6, 5), (6, 9)], [1, 2, 0.5, 1]),
    "a polyline": (1, [0, 0, 1, 2, 3, 3], [(0, 0), (3, 0), (3, 3), (6, 3)], [1] * 4),
    "unclamped": (2, [0, 1, 2, 3, 4, 5, 6], [(0, 0), (2, 0), (4, 3), (7, 3)], [1] * 4),
    "illegal: too few knots": (3, [0, 0, 0, 1, 1, 1], [(0, 0), (3, 0), (6, 5), (6, 9)], [1] * 4),
}
"""Curves that the examples of LIF don't have: degree, knots, control points and weights."""


@pytest.mark.parametrize("orientation", ["TANGENTIAL", "GLOBAL"])
@pytest.mark.parametrize("name", CURVES)
def test_curves_of_lif_have_weights_and_knots(engine: Engine, tmp_path: Path, name: str, orientation: str) -> None:
    degree, knots, control, weights = CURVES[name]
    points = [{"x": x, "y": y, "weight": weight} for (x, y), weight in zip(control, weights, strict=True)]
    nodes = [
        {
            "nodeId": node,
            "nodePosition": {"x": x, "y": y},
            "vehicleTypeNodeProperties": [{"vehicleTypeId": "v", "theta": 0.0}],
        }
        for node, (x, y) in (("start", control[0]), ("end", control[-1]))
    ]
    properties = {
        "vehicleTypeId": "v",
        "orientationType": orientation,
        "vehicleOrientation": 0.7,
        "maxSpeed": 1.5,
        "rotationAllowed": False,
        "trajectory": {"degree": degree, "knotVector": knots, "controlPoints": points},
    }
    ends = {"startNodeId": "start", "endNodeId": "end"}
    edge = {"edgeId": name, **ends, "vehicleTypeEdgeProperties": [properties]}
    information = {"projectIdentification": "", "creator": "", "exportTimestamp": "", "lifVersion": "1.0.0"}
    layout = {"layoutId": "1", "layoutVersion": "1", "nodes": nodes, "edges": [edge], "stations": []}
    file = tmp_path / "curve.lif.json"
    file.write_text(json.dumps({"metaInformation": information, "layouts": [layout]}))
    drive(engine, tmp_path, file, lif.edges(file))


def test_roads_of_a_map_keep_their_distance_from_walls(engine: Engine, tmp_path: Path) -> None:
    """A map has no edges: instead of curves, its picture says where robots may be."""
    path, width = FILES / "ros-map/turtlebot3_world.yaml", 0.3
    forwards, backwards = ids_of(in_our_format(path, {"skeleton": str(width)}))
    assert len(forwards) > 40 and not backwards
    robots = "".join(f"\n- {{route: [{route}], repeat: once}}" for route in forwards)
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text(f'graph: "{path}"\nlayout:\n  skeleton: {width}\nrate: 10\nrobots:{robots}\n')
    run = Run(engine, scenario, len(forwards))
    starts, ends = (np.unique(run.world.edges[name]) for name in ("origin", "destination"))
    assert len(starts) == len(ends) == len(run.world.nodes), "each node is left and reached"
    walls = np.array(list(walls_of(path)))
    for robot in range(len(forwards)):
        poses = run.poses(robot, robot)
        assert len(poses) > 1, "not driven"
        for x, y in poses[:, :2]:
            nearest = np.clip((x, y), walls[:, :2], walls[:, 2:])
            assert np.hypot(*(nearest - (x, y)).T).min() >= width / 2, (x, y)


def walls_of(path: Path) -> Iterator[tuple[float, float, float, float]]:
    """Yields the squares of a map's cells that aren't free: x and y of two corners in metres."""
    settings = dict(re.findall(r"^(\w+): *(.+)$", path.read_text(), re.MULTILINE))
    cell, free = float(settings["resolution"]), float(settings["free_thresh"])
    left, bottom = (float(number) for number in settings["origin"].strip("[]").split(",")[:2])
    assert int(settings["negate"]) == 0
    picture = path.with_name(settings["image"]).read_bytes()
    header = re.match(rb"P5\s(?:#.*\n)?(\d+)\s+(\d+)\s+255\s", picture)
    assert header is not None
    columns, rows = (int(number) for number in header.groups())
    pixels = np.frombuffer(picture, np.uint8, offset=header.end()).reshape(rows, columns)
    for row, column in np.argwhere((255.0 - pixels) / 255 >= free):
        x, y = left + column * cell, bottom + (rows - 1 - row) * cell
        yield x, y, x + cell, y + cell


def drive(
    engine: Engine, folder: Path, path: Path, expected: list[Edge], options: dict[str, str] | None = None
) -> None:
    """Drives each edge once, in each gear, and checks every pose of every tick."""
    options = options or {}
    converted = in_our_format(path, options)
    forwards, backwards = ids_of(converted)
    if "\nDoors:" in converted or "\nLifts:" in converted:
        # Robots would wait for doors, and one lift has one cabin.
        path, options = folder / "without-facilities.yaml", {}
        path.write_text(re.split(r"\n(?:Doors|Lifts):", converted)[0])
    assert len(forwards) == len(expected), "the number of edges"
    assert len(backwards) == sum(edge.reverse for edge in expected), "the number of edges with reverse gear"
    routes = [*forwards, *(-number for number in backwards)]

    # At least some poses inside the short edges, but not too many on the long ones.
    lengths = [edge.curve.length for edge in expected]
    rate = math.ceil(min(max(TICKS / max(lengths), 12 / min(lengths)), MOST_TICKS / max(lengths), 500))
    settings = {name.replace("-", "_"): value for name, value in options.items()}
    if "layer" in settings:
        settings["layers"] = f"[{settings.pop('layer')}]"
    layout = "".join(f"\n  {name}: {value}" for name, value in settings.items())
    robots = "".join(f"\n- {{route: [{route}], repeat: once}}" for route in routes)
    scenario = folder / "scenario.yaml"
    scenario.write_text(
        f'graph: "{path}"\n' + (f"layout:{layout}\n" if layout else "") + f"rate: {rate}\nrobots:{robots}\n"
    )

    run = Run(engine, scenario, len(routes))
    described = matched(run.world, expected)
    index_of = {int(number): index for index, number in enumerate(run.world.edges["id"])}
    problems = []
    for robot, route in enumerate(routes):
        index = index_of[abs(route)]
        record = run.world.edges[index]
        speed = record["speed"] if route > 0 else record["reverse_speed"]
        ticks = described[index].curve.length / float(speed) * rate
        for problem in check(run.poses(robot, index), described[index], route < 0, ticks):
            problems.append(f"edge {record['id']} {record['name']}: {problem}")
    assert not problems, "\n".join([path.name, *problems])


def in_our_format(path: Path, options: dict[str, str]) -> str:
    """Returns a layout, converted to our own format."""
    arguments = [word for name, value in options.items() for word in (f"--{name}", value)]
    command: list[str | Path] = [binary(), "graph", "convert", path, *arguments, "--to", "regatta", "-o", "-"]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def ids_of(converted: str) -> tuple[list[int], list[int]]:
    """Returns the ids of all edges, which routes consist of, and of those that have a reverse gear."""
    rows = [row for row in converted.splitlines() if "Origin_ID" in row]
    ids = [int(row.split(",")[0].split(":")[1]) for row in rows]
    return ids, [number for number, row in zip(ids, rows, strict=True) if "VelocityBackwards: " in row]


class Run:
    """All poses of a run, which is over when no robot has anything left to drive."""

    def __init__(self, engine: Engine, scenario: Path, robots: int) -> None:
        arguments = ("--fleet", engine.name, "--speed", "max", "--lockstep", "reader")
        process = engine.run(binary(), "engine", scenario, *arguments)
        poses: list[Array] = []
        edges: list[npt.NDArray[np.uint32]] = []
        with regatta.join(engine.name, "reader") as fleet:

            def world() -> regatta.World | None:
                # An engine that can't run the scenario ends, and publishes nothing.
                assert process.child.poll() is None, process.errors
                try:
                    return fleet.world(0.01)
                except regatta.NoEngineError:
                    return None

            self.world = eventually("a world", world)
            for frame in fleet.frames():
                assert (frame.tick, frame.missed, len(frame)) == (len(poses), 0, robots)
                poses.append(np.stack([frame.x, frame.y, frame.theta, frame.s, frame.speed]).astype(np.float64))
                edges.append(frame.edge.copy())
                if (frame.state == regatta.RobotState.IDLE).all():
                    break
                assert len(poses) < 10 * MOST_TICKS, "robots that don't arrive"
        process.end()
        self._poses, self._edges = np.stack(poses), np.stack(edges)
        self._poses[:, :2] += np.array(self.world.origin)[:, np.newaxis]

    def poses(self, robot: int, edge: int) -> Array:
        """Returns the poses of a robot while it was on an edge: rows of x, y, theta, s and speed."""
        return self._poses[self._edges[:, robot] == edge, :, robot]


def matched(world: regatta.World, expected: list[Edge]) -> dict[int, Edge]:
    """Returns what the file says of each edge of the world: by names, ids, or places of the ends."""
    by_name = {edge.name: edge for edge in expected if edge.name}
    by_id = {edge.id: edge for edge in expected if edge.id is not None}
    others = [edge for edge in expected if not edge.name and edge.id is None]
    ends = np.array([[edge.curve.point(0), edge.curve.point(-1)] for edge in others]).reshape(-1, 2, 2)
    taken = np.zeros(len(others), bool)
    places = np.stack([world.nodes["x"], world.nodes["y"]], axis=1).astype(np.float64) + world.origin
    found: dict[int, Edge] = {}
    for index, record in enumerate(world.edges):
        known = by_name.pop(str(record["name"]), None) or by_id.pop(int(record["id"]), None)
        if known is None:
            own = places[[record["origin"], record["destination"]]]
            near = np.flatnonzero((np.hypot(*np.moveaxis(ends - own, 2, 0)) < TOLERANCE).all(axis=1) & ~taken)
            assert len(near), f"edge {record['id']} {record['name']} isn't in the file: {own.tolist()}"
            # Of edges with the same ends, the one of the most similar length.
            best = min(near, key=lambda number: abs(others[number].curve.length - float(record["length"])))
            taken[best], known = True, others[best]
        found[index] = known
    left = [*by_name.values(), *by_id.values(), *(others[number] for number in np.flatnonzero(~taken))]
    assert not left, [(edge.name, edge.id, edge.curve.point(0), edge.curve.point(-1)) for edge in left]
    return found


def check(poses: Array, edge: Edge, backwards: bool, ticks: float) -> Iterator[str]:
    """Yields what is wrong with the poses of a robot that drove an edge, which takes so many ticks."""
    if not len(poses):
        yield "not driven"
        return
    x, y, theta, s, speed = poses.T
    length = edge.curve.length
    inside = (s > 0) & (s < length - TOLERANCE)
    if inside.sum() < min(MOST_INSIDE, ticks - 2):
        yield f"only {inside.sum()} poses inside, of {ticks:.0f} ticks"
    steps = np.diff(s)
    if not ((steps <= 0).all() if backwards else (steps >= 0).all()):
        yield "s goes back and forth"
    if not ((speed[inside] < 0).all() if backwards else (speed[inside] > 0).all()):
        yield "the sign of the speed"
    if abs(s[0] - (length if backwards else 0)) > TOLERANCE or abs(s[-1] - (0 if backwards else length)) > TOLERANCE:
        yield f"s from {s[0]:.4f} to {s[-1]:.4f} of {length:.4f} m"

    distance, along, direction = edge.curve.nearest(np.stack([x, y], axis=1), s)
    nearest = distance.min(axis=1)
    worst = int(nearest.argmax())
    if nearest[worst] > TOLERANCE:
        yield f"{nearest[worst] * 1000:.2f} mm from the curve at s = {s[worst]:.3f}: ({x[worst]:.4f}, {y[worst]:.4f})"
    if edge.any_heading:
        heading = theta[:, np.newaxis]
    elif edge.heading is None:
        heading = direction + edge.offset
    else:
        heading = np.full_like(direction, edge.heading)
    wrong = np.abs((theta[:, np.newaxis] - heading + math.pi) % (2 * math.pi) - math.pi)
    near = distance <= nearest[:, np.newaxis] + CORNER
    for name, errors, limit in (("heading", wrong, ANGLE), ("s", np.abs(along - s[:, np.newaxis]), TOLERANCE)):
        least = np.where(near, errors, np.inf).min(axis=1)
        worst = int(least.argmax())
        if least[worst] > limit:
            yield f"{name} off by {least[worst]:.5f} at s = {s[worst]:.3f}: ({x[worst]:.4f}, {y[worst]:.4f})"
