//! A layout for Foxglove and Lichtblick: a view from above, plots, the log, parameters and buttons.

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use regatta_kit::WholeFile;
use regatta_plugin::{FleetName, Result, World, WorldReader, tell};
use serde_json::{Map, Value, json};

/// The error of writing a layout.
#[derive(Debug, thiserror::Error)]
enum LayoutError {
    #[error("{0} exists already; give another file")]
    Exists(PathBuf),
    #[error("can't write {path} ({reason})")]
    Write { path: PathBuf, reason: io::Error },
}

/// The part of the floor that the view shows, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
struct View {
    centre: [f64; 2],
    size: f64,
}

/// The view where no fleet runs.
const ANYWHERE: View = View { centre: [0.0; 2], size: 100.0 };
/// The longest time to wait for a fleet.
const LONGEST_WAIT: Duration = Duration::from_secs(1);
/// The free space around the floor, as a factor.
const MARGIN: f64 = 1.1;

/// Writes a layout, whose view is on the fleet if one runs.
pub(crate) fn write(path: &Path, fleet: &FleetName) -> Result {
    if path.exists() {
        return Err(LayoutError::Exists(path.to_owned()).into());
    }
    let view = current_view(fleet)?;
    save(path, &format!("{:#}\n", layout(&view.unwrap_or(ANYWHERE))))
        .map_err(|reason| LayoutError::Write { path: path.to_owned(), reason })?;
    let of = match view {
        Some(_) => format!("the view is on fleet '{fleet}'"),
        None => format!("fleet '{fleet}' doesn't run, so the view is on the origin"),
    };
    tell!("foxglove: {}: {of}", path.display());
    Ok(())
}

/// Returns the view of a fleet that runs.
fn current_view(fleet: &FleetName) -> Result<Option<View>> {
    let mut worlds = WorldReader::open(fleet)?;
    let asked = Instant::now();
    // The producer gives it to new readers with its next tick.
    while asked.elapsed() < LONGEST_WAIT {
        if let Some(world) = worlds.latest()? {
            return Ok(view_of(&world));
        }
        std::thread::sleep(LONGEST_WAIT / 100);
    }
    Ok(None)
}

fn save(path: &Path, text: &str) -> io::Result<()> {
    let (whole, mut file) = WholeFile::create(path)?;
    file.write_all(text.as_bytes())?;
    whole.commit()
}

fn view_of(world: &World<'_>) -> Option<View> {
    if world.nodes().is_empty() {
        return None;
    }
    let (mut low, mut high) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
    for node in world.nodes() {
        for (axis, value) in [node.x, node.y].into_iter().enumerate() {
            (low[axis], high[axis]) = (low[axis].min(value), high[axis].max(value));
        }
    }
    let [[x0, y0], [x1, y1]] = [low, high].map(|corner| corner.map(f64::from));
    let size = (x1 - x0).max(y1 - y0).max(1.0) * MARGIN;
    size.is_finite().then_some(View { centre: [(x0 + x1) / 2.0, (y0 + y1) / 2.0], size })
}

/// The panels, by their ids.
const VIEW: &str = "3D!regatta";
const ORDERS: &str = "Plot!orders";
const ROBOTS: &str = "Plot!robots";
const CLOCK: &str = "Plot!clock";
const LOG: &str = "RosOut!log";
const PARAMETERS: &str = "Parameters!clock";
const PAUSE: &str = "CallService!pause";
const RESUME: &str = "CallService!resume";
const STEP: &str = "CallService!step";

fn layout(view: &View) -> Value {
    let mut panels = Map::new();
    panels.insert(VIEW.to_owned(), view_panel(view));
    let orders = ["work.orders_per_hour", "work.open", "work.finished"];
    panels.insert(ORDERS.to_owned(), plot("Orders", &orders));
    let robots = ["robots.moving", "robots.waiting", "robots.idle", "contacts.touching"];
    panels.insert(ROBOTS.to_owned(), plot("Robots", &robots));
    let clock = ["real_time_factor", "work.waiting", "mean_speed", "late_ticks"];
    panels.insert(CLOCK.to_owned(), plot("Clock, waiting, speed", &clock));
    panels.insert(LOG.to_owned(), json!({"topicToRender": "/log", "minLogLevel": 1}));
    panels.insert(PARAMETERS.to_owned(), json!({"title": "Clock"}));
    for (id, service, text, payload) in [
        (PAUSE, "/pause", "Pause", "{}"),
        (RESUME, "/resume", "Resume", "{}"),
        (STEP, "/step", "Step", r#"{"ticks": 1}"#),
    ] {
        panels.insert(id.to_owned(), button(service, text, payload));
    }
    json!({
        "configById": panels,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": side_by_side(
            62,
            &above(72, &json!(VIEW), &buttons()),
            &above(70, &plots(), &above(45, &json!(PARAMETERS), &json!(LOG))),
        ),
    })
}

fn buttons() -> Value {
    let clock = side_by_side(50, &json!(PAUSE), &json!(RESUME));
    side_by_side(66, &clock, &json!(STEP))
}

fn plots() -> Value {
    above(33, &json!(ORDERS), &above(50, &json!(ROBOTS), &json!(CLOCK)))
}

fn side_by_side(percent: u32, left: &Value, right: &Value) -> Value {
    json!({"direction": "row", "first": left, "second": right, "splitPercentage": percent})
}

fn above(percent: u32, upper: &Value, lower: &Value) -> Value {
    json!({"direction": "column", "first": upper, "second": lower, "splitPercentage": percent})
}

fn view_panel(view: &View) -> Value {
    let [x, y] = view.centre;
    let robots = json!({
        "visible": true,
        "colorMode": "rgba-fields",
        "pointShape": "circle",
        "pointSize": 6,
    });
    json!({
        "cameraState": {
            "perspective": false,
            "distance": view.size,
            "phi": 0,
            "thetaOffset": 0,
            "target": [x, y, 0],
            "targetOffset": [0, 0, 0],
            "targetOrientation": [0, 0, 0, 1],
            "fovy": 45,
            "near": 0.1,
            "far": 10.0 * view.size.max(500.0),
        },
        "followMode": "follow-none",
        "followTf": "map",
        "scene": {"backgroundColor": "#16181c"},
        "transforms": {},
        "topics": {
            "/robots": robots,
            "/graph": {"visible": true},
            "/contact_markers": {"visible": true},
            "/poses": {"visible": false, "type": "arrow", "arrowScale": [0.8, 0.3, 0.3]},
            "/graph_points": {"visible": false},
        },
        "layers": {},
        "publish": {},
        "imageMode": {},
    })
}

/// A plot of figures over time.
fn plot(title: &str, figures: &[&str]) -> Value {
    let paths: Vec<_> = figures
        .iter()
        .map(|figure| {
            json!({
                "value": format!("/figures.{figure}"),
                "enabled": true,
                "timestampMethod": "receiveTime",
            })
        })
        .collect();
    json!({
        "foxglovePanelTitle": title,
        "paths": paths,
        "xAxisVal": "timestamp",
        "isSynced": true,
        "showXAxisLabels": true,
        "showYAxisLabels": true,
        "showLegend": true,
        "legendDisplay": "floating",
        "showPlotValuesInLegend": true,
        "followingViewWidth": 300,
    })
}

fn button(service: &str, text: &str, payload: &str) -> Value {
    json!({
        "serviceName": service,
        "requestPayload": payload,
        "layout": "horizontal",
        "editingMode": false,
        "buttonText": text,
        "foxglovePanelTitle": text,
    })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use regatta_plugin::world::{NodeRecord, WorldData};

    use super::*;
    use crate::channel::Channel;
    use crate::service::Service;

    /// Collects the panels that a part of the layout places.
    fn placed(part: &Value, panels: &mut BTreeSet<String>) {
        match part {
            Value::String(id) => drop(panels.insert(id.clone())),
            part => ["first", "second"].iter().for_each(|end| placed(&part[end], panels)),
        }
    }

    #[test]
    fn each_panel_has_its_place() {
        let layout = layout(&ANYWHERE);
        let mut panels = BTreeSet::new();
        placed(&layout["layout"], &mut panels);
        let configured = layout["configById"].as_object().expect("panels");
        assert_eq!(panels, configured.keys().cloned().collect());
    }

    #[test]
    fn topics_and_services_of_the_layout_exist() {
        let text = layout(&ANYWHERE).to_string();
        let topics: BTreeSet<_> = Channel::ALL.iter().map(|channel| channel.topic()).collect();
        let services: BTreeSet<_> = Service::ALL.iter().map(|service| service.name()).collect();
        let names = text.split('"').filter_map(|word| word.strip_prefix('/'));
        for name in names.map(|name| format!("/{}", name.split('.').next().unwrap_or(name))) {
            assert!(topics.contains(&name) || services.contains(&*name), "{name}");
        }
    }

    #[test]
    fn the_view_is_on_the_floor() {
        let mut data = WorldData::default();
        for (x, y) in [(10.0, -5.0), (30.0, 5.0)] {
            data.nodes.push(NodeRecord { x, y, ..NodeRecord::default() });
        }
        let view = view_of(&data.view(1, 1)).expect("nodes");
        assert_eq!(view, View { centre: [20.0, 0.0], size: 22.0 });
        assert_eq!(view_of(&WorldData::default().view(1, 1)), None);
    }
}
