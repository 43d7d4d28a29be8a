//! Edges.

use glam::DVec2;
use regatta_base::graph::{Ends, Rotation};
use serde_json::Value;

use super::ids::Target;
use super::node::{checked_angle, take_actions};
use super::object::{Context, Object, Raw, number};
use super::vehicle::{Choice, OF_EDGES};
use super::{Reader, Sheet};
use crate::model::nurbs::{Cubics, Nurbs};
use crate::model::tags::{Orientation, Role, Tags};
use crate::model::value::shorten;
use crate::read::layout::{LayoutEdge, Shape};

impl<'text> Reader<'_, '_, 'text> {
    /// Reads an edge and its actions. The numbers are the index of the layout, and the number of
    /// the edge from 1.
    pub fn edge(
        &mut self,
        raw: Raw<'text>,
        sheet: &Sheet<'text>,
        numbers: [usize; 2],
    ) -> Option<(LayoutEdge, Role)> {
        let object = Object::parse(raw, "an edge", &mut self.context)?;
        self.context.edge = object.name("edgeId").map(|id| format!("edge `{}`", shorten(&id)));
        let edge = self.edge_of(object, sheet, numbers);
        self.context.edge = None;
        edge
    }

    fn edge_of(
        &mut self,
        mut object: Object<'text>,
        sheet: &Sheet<'text>,
        [layout, number]: [usize; 2],
    ) -> Option<(LayoutEdge, Role)> {
        let context = &mut self.context;
        let at = object.at;
        let [id, start, end] =
            ["edgeId", "startNodeId", "endNodeId"].map(|key| object.take_text(key, context));
        let (Some(start), Some(end)) = (start, end) else {
            context.error(at, "an edge has no `startNodeId` or no `endNodeId`: give it both");
            return None;
        };
        let id = id.unwrap_or_else(|| {
            context.note(at, "an edge has no `edgeId`: it is named after its nodes");
            format!("{start}-{end}#{number}")
        });
        let ends = [start, end].map(|node| self.node_ids.resolve(node, layout));
        let [Target::Known(origin), Target::Known(destination)] = ends else {
            context.assume(at, "an edge leads to a layout that isn't read: left out");
            return None;
        };
        let (choice, types) = self.vehicles.choose(&mut object, &OF_EDGES, context);
        let name = object.take_text("edgeName", context).map(Into::into);
        let tags = Tags { name, level: sheet.level.clone(), ..Tags::default() };
        let id = self.edge_ids.unique(id, layout);
        let mut edge = LayoutEdge { at, id, origin, destination, tags, ..LayoutEdge::default() };
        types.set(&mut edge.tags);
        object.keep_rest(&mut edge.tags.properties, context);
        match choice {
            Choice::Some(properties) => Some(read_properties(edge, properties, context)),
            Choice::Empty => Some((edge, Role::None)),
            Choice::Others => {
                context.assume(at, "an edge isn't for the chosen vehicle type: left out");
                None
            }
        }
    }
}

/// Completes an edge by its properties for the vehicle type.
fn read_properties<'text>(
    mut edge: LayoutEdge,
    mut object: Object<'text>,
    context: &mut Context<'_, 'text>,
) -> (LayoutEdge, Role) {
    let speed = object
        .take_number("maxSpeed", context)
        .or_else(|| object.take_number("maximumSpeed", context));
    if speed.is_some_and(|speed| speed <= 0.0) {
        context.assume(edge.at, "`maxSpeed` of an edge isn't above 0: read as no limit");
    }
    edge.speed = speed.filter(|speed| *speed > 0.0);
    edge.orientation = orientation(&mut object, &mut edge.tags, edge.at, context);
    if let Some(trajectory) = object.take_object("trajectory", "a trajectory", context) {
        edge.shape = read_trajectory(trajectory, &edge.id, context);
    }
    let kept = ["loadRestriction", "corridor", "physicalLineGuidedProperty"];
    object.keep_json(&kept, &mut edge.tags);
    let role = take_actions(&mut object, &mut edge.tags, context);
    object.keep_rest(&mut edge.tags.properties, context);
    edge.rotation = Ends {
        origin: rotation(&edge.tags, "rotationAtStartNodeAllowed"),
        destination: rotation(&edge.tags, "rotationAtEndNodeAllowed"),
    };
    (edge, role)
}

/// Returns the rotation at an end of an edge, from a property, which is kept.
fn rotation(tags: &Tags, key: &str) -> Rotation {
    match tags.properties.get(key).map(|value| value.to_ascii_uppercase()).as_deref() {
        Some("NONE") => Rotation::None,
        Some("CCW") => Rotation::CounterClockwise,
        Some("CW") => Rotation::Clockwise,
        _ => Rotation::Shorter,
    }
}

/// Returns the first of the angles of LIF 2 that robots may have along an edge.
fn first_orientation<'text>(
    object: &mut Object<'text>,
    tags: &mut Tags,
    at: u32,
    context: &mut Context<'_, 'text>,
) -> Option<f64> {
    let angles: Vec<f64> = object
        .take_list("mobileRobotOrientations", context)
        .into_iter()
        .filter_map(|raw| number(raw, context))
        .collect();
    if angles.len() > 1 {
        let message = "an edge allows several `mobileRobotOrientations`: the first is used, all \
                       are kept as a property";
        context.note(at, message);
        tags.set("mobileRobotOrientations", &Value::from(angles.clone()).to_string());
    }
    angles.first().copied()
}

fn orientation<'text>(
    object: &mut Object<'text>,
    tags: &mut Tags,
    at: u32,
    context: &mut Context<'_, 'text>,
) -> Orientation {
    let kind = object.take_text("orientationType", context);
    let angle = object
        .take_number("vehicleOrientation", context)
        .or_else(|| first_orientation(object, tags, at, context));
    let Some(angle) = angle.map(|angle| checked_angle(at, angle, context)) else {
        return Orientation::Tangential;
    };
    match kind.map(|kind| kind.to_ascii_uppercase()).as_deref() {
        Some("GLOBAL") => Orientation::Fixed(angle),
        kind => {
            if !matches!(kind, None | Some("TANGENTIAL")) {
                context.note(
                    at,
                    "`orientationType` is neither GLOBAL nor TANGENTIAL: read as TANGENTIAL",
                );
            }
            if angle == 0.0 { Orientation::Tangential } else { Orientation::Offset(angle) }
        }
    }
}

/// A larger distance in metres between a curve and its cubics is reported.
const MAX_ERROR: f64 = 0.001;

/// Reads the shape of an edge, a NURBS curve. An invalid curve is read as straight, with a warning.
fn read_trajectory<'text>(
    mut object: Object<'text>,
    edge: &str,
    context: &mut Context<'_, 'text>,
) -> Shape {
    let at = object.at;
    let curve = curve(&mut object, context);
    object.ignore_rest(context);
    match curve {
        Ok(Cubics { cubics, error }) => {
            if error > MAX_ERROR {
                let message = format!(
                    "edge `{}`: its trajectory is followed within {error:.3} m only",
                    shorten(edge)
                );
                context.warning(at, message);
            }
            Shape::Cubics(cubics)
        }
        Err(reason) => {
            let message = format!(
                "edge `{}`: its trajectory isn't a NURBS curve: {reason}: read as straight",
                shorten(edge)
            );
            context.warning(at, message);
            Shape::Straight
        }
    }
}

fn curve<'text>(
    object: &mut Object<'text>,
    context: &mut Context<'_, 'text>,
) -> Result<Cubics, String> {
    let degree = object.take_number("degree", context).unwrap_or(1.0);
    if degree.fract() != 0.0 || !(0.0..=1e6).contains(&degree) {
        return Err(format!("the degree is {degree}"));
    }
    let knots = object.take_list("knotVector", context);
    let knots: Option<Vec<f64>> = knots.into_iter().map(|raw| number(raw, context)).collect();
    let knots = knots.ok_or("a knot isn't a number")?;
    let (mut points, mut weights) = (Vec::new(), Vec::new());
    for raw in object.take_list("controlPoints", context) {
        let mut point = Object::parse(raw, "a control point", context)
            .ok_or("a control point isn't an object")?;
        let [x, y, weight] = ["x", "y", "weight"].map(|key| point.take_number(key, context));
        point.ignore_rest(context);
        let (Some(x), Some(y)) = (x, y) else {
            return Err("a control point has no x or no y".to_owned());
        };
        points.push(DVec2::new(x, y));
        weights.push(weight.unwrap_or(1.0));
    }
    let curve =
        Nurbs::new(degree as usize, knots, &points, &weights).map_err(|error| error.to_string())?;
    Ok(curve.to_cubics())
}
