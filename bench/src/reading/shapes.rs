//! The contents of files: plain plants of every format, and contents that take parsers long.

/// The content of a file, for any size.
pub struct Shape {
    /// The format.
    pub format: &'static str,
    /// The content in words.
    pub content: &'static str,
    /// The ending of the file's name.
    pub ending: &'static str,
    before: &'static str,
    /// Repeated up to the size of the file, with its number in place of each `#`.
    repeated: &'static str,
    after: &'static str,
}

impl Shape {
    /// Returns the text of a file of about a size.
    pub fn text(&self, bytes: usize) -> String {
        let mut text = self.before.to_owned();
        let mut number = 0;
        while text.len() + self.after.len() < bytes {
            let mut parts = self.repeated.split('#');
            text += parts.next().unwrap_or_default();
            for part in parts {
                text += &number.to_string();
                text += part;
            }
            number += 1;
        }
        text + self.after
    }
}

const YAML_NODES: &str = "Vertices:\n- {Id: 1, X: 0.0, Y: 0.0, Theta: 0.0}\n- {Id: 2, X: 4.0, \
    Y: 0.0, Theta: 0.0}\nEdges:\n- {Id: 1, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, \
    VelocityForward: 1.5}\n";
const RMF: &str = "building_name: b\nlevels:\n  L1:\n    lanes: []\n    vertices:\n";
const BUILDING: &str = "coordinate_system: reference_image\nlevels:\n  L1:\n    vertices:\n    - \
    [0, 0, 0, a]\n    - [9, 0, 0, b]\n    measurements:\n    - [0, 1, {distance: [3, 9]}]\n    \
    lanes:\n";
const GEOJSON: &str = "{\"type\": \"FeatureCollection\", \"features\": ";
const POINT: &str = "{\"type\": \"Feature\", \"properties\": {\"id\": #}, \"geometry\": \
    {\"type\": \"Point\", \"coordinates\": [#, 0]}},\n";
const LIF: &str = "{\"metaInformation\": {\"projectIdentification\": \"p\", \"creator\": \"c\", \
    \"exportTimestamp\": \"2026-01-01T00:00:00Z\", \"lifVersion\": \"1.0.0\"}, \"layouts\": \
    [{\"layoutId\": \"l\", \"edges\": [], \"stations\": [], \"nodes\": [";
const LIF_NODE: &str = "{\"nodeId\": \"n#\", \"nodePosition\": {\"x\": #, \"y\": 0}, \
    \"vehicleTypeNodeProperties\": [{\"vehicleTypeId\": \"v\"}]},\n";
const LIF_END: &str = "{\"nodeId\": \"last\", \"nodePosition\": {\"x\": 0, \"y\": 9}, \
    \"vehicleTypeNodeProperties\": [{\"vehicleTypeId\": \"v\"}]}]}]}";
const XML: &str = "<?xml version=\"1.0\"?>\n<model version=\"6.0.0\" name=\"m\">\n";
const XML_POINT: &str = "<point name=\"p#\" positionX=\"#\" positionY=\"0\" positionZ=\"0\" \
    vehicleOrientationAngle=\"NaN\" type=\"HALT_POSITION\"/>\n";
const DXF: &str = "0\nSECTION\n2\nENTITIES\n";
const DXF_LINE: &str = "0\nLINE\n8\n0\n10\n#\n20\n0\n30\n0\n11\n#.5\n21\n1\n31\n0\n";
const DXF_LAYER: &str = "0\nLINE\n8\nL#\n10\n#\n20\n0\n30\n0\n11\n#.5\n21\n1\n31\n0\n";
const DXF_END: &str = "0\nENDSEC\n0\nEOF\n";
const SCENARIO: &str = "graph: plant.yaml\nrobots:\n";

/// Makes a shape.
const fn shape(
    format: &'static str,
    content: &'static str,
    ending: &'static str,
    [before, repeated, after]: [&'static str; 3],
) -> Shape {
    Shape { format, content, ending, before, repeated, after }
}

/// The contents that are measured.
pub const SHAPES: [Shape; 34] = [
    shape(
        "regatta",
        "nodes",
        "yaml",
        ["Edges: []\nVertices:\n", "- {Id: #, X: #.5, Y: 0.0, Theta: 0.0}\n", ""],
    ),
    shape("regatta", "unknown keys", "yaml", [YAML_NODES, "k#: 1\n", ""]),
    shape(
        "regatta",
        "unknown keys of a node",
        "yaml",
        ["Edges: []\nVertices:\n- {Id: 1, ", "k#: 1, ", "X: 0.0, Y: 0.0, Theta: 0.0}\n"],
    ),
    shape(
        "regatta",
        "the same node",
        "yaml",
        ["Edges: []\nVertices:\n", "- {Id: 1, X: 0.0, Y: 0.0, Theta: 0.0}\n", ""],
    ),
    shape("regatta", "nested lists", "yaml", ["", "[", ""]),
    shape("regatta", "nested maps", "yaml", ["x: ", "{a: ", ""]),
    shape("regatta", "dashes", "yaml", ["x:\n  ", "- ", "a\n"]),
    shape("regatta", "question marks", "yaml", ["x:\n  ", "? ", "a\n"]),
    shape("regatta", "anchors and aliases", "yaml", [YAML_NODES, "k#: &a# 1\nj#: *a#\n", ""]),
    shape("regatta", "directives", "yaml", ["", "%TAG !a#! b\n", "---\na: 1\n"]),
    shape("regatta", "comments", "yaml", [YAML_NODES, "# comment\n", ""]),
    shape("regatta", "one long line", "yaml", ["x: ", "word ", "\n"]),
    shape("regatta", "JSON of lists", "json", ["{\"Edges\": ", "[", ""]),
    shape("scenario", "robots", "yaml", [SCENARIO, "- {count: 1, routes: random}\n", ""]),
    shape("scenario", "unknown keys", "yaml", ["graph: plant.yaml\n", "k#: 1\n", ""]),
    shape("scenario", "nested lists", "yaml", [SCENARIO, "- [", ""]),
    shape("open-rmf", "vertices", "yaml", [RMF, "    - [#, 0, {name: \"\"}]\n", ""]),
    shape("open-rmf", "nested lists", "yaml", [RMF, "[", ""]),
    shape("open-rmf-building", "lanes", "yaml", [BUILDING, "    - [0, 1, {}]\n", ""]),
    shape(
        "ros-map",
        "unknown keys",
        "yaml",
        ["image: a.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n", "k#: 1\n", ""],
    ),
    shape(
        "nav2",
        "points",
        "geojson",
        [
            "{\"type\": \"FeatureCollection\", \"features\": [",
            POINT,
            "{\"type\": \"Feature\", \"properties\": {}, \"geometry\": null}]}",
        ],
    ),
    shape("nav2", "nested lists", "geojson", [GEOJSON, "[", ""]),
    shape(
        "nav2",
        "properties",
        "geojson",
        [
            "{\"type\": \"FeatureCollection\", \"features\": [{\"type\": \"Feature\", \
         \"properties\": {\"id\": 0",
            ", \"k#\": 1",
            "}, \"geometry\": {\"type\": \"Point\", \"coordinates\": [0, 0]}}]}",
        ],
    ),
    shape("lif", "nodes", "json", [LIF, LIF_NODE, LIF_END]),
    shape("lif", "nested lists", "json", [LIF, "[", ""]),
    shape("open-tcs", "points", "xml", [XML, XML_POINT, "</model>\n"]),
    shape("open-tcs", "nested elements", "xml", [XML, "<a>", ""]),
    shape("open-tcs", "attributes", "xml", ["<model><path", " k#=\"1\"", "/></model>\n"]),
    shape("csv", "nodes", "csv", ["id,x,y\n", "#,#,0\n", ""]),
    shape("csv", "columns", "csv", ["id,x,y", ",k#", "\n1,0,0\n"]),
    shape("dxf", "lines", "dxf", [DXF, DXF_LINE, DXF_END]),
    shape("dxf", "lines, each on a layer of its own", "dxf", [DXF, DXF_LAYER, DXF_END]),
    shape("dxf", "unknown entities", "dxf", [DXF, "0\nK#\n8\n0\n", DXF_END]),
    shape("moving-ai", "rows", "map", ["type octile\nheight 9\nwidth 9\nmap\n", ".........\n", ""]),
];
