//! Trajectories: NURBS curves.

use glam::DVec2;

use super::object::{Context, Object, number};
use crate::model::nurbs::{Cubics, Nurbs};
use crate::model::value::shorten;
use crate::read::layout::Shape;

/// A larger distance in metres between a curve and its cubics is reported.
const MAX_ERROR: f64 = 0.001;

/// Reads the shape of an edge. An invalid curve is read as straight, with a warning.
pub(super) fn read<'text>(
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
