//! `regatta report accuracy`: the end poses of the dissertation's tables 5.1 and 5.3.

use std::fmt::Write as _;
use std::process::ExitCode;
use std::time::Duration;

use super::folder_with_porto;
use super::published::{AVERAGE_RATES, END_POSES, EndPose, Pose, success_rate};
use crate::experiment::plot::{self, Chart, Scale, Series};
use crate::experiment::report::{Output, Report, environment};
use crate::experiment::{Experiment, all_idle, write};
use crate::failure::Failure;
use crate::program::Program;
use crate::progress::Progress;

/// The number of rows of [`END_POSES`] that are single edges; the others are routes.
const SINGLE_EDGES: usize = 10;
/// The route whose driven path is plotted, as in the dissertation.
const PLOTTED_ROUTE: &[u32] = &[34];

/// The result of driving all routes.
struct Drive {
    /// The end pose of each route, in the order of [`END_POSES`].
    end_poses: Vec<Pose>,
    /// The poses along the plotted route.
    path: Vec<Pose>,
}

pub fn run(output: &Output) -> Result<ExitCode, Failure> {
    output.check("accuracy")?;
    let progress = Progress::start("driving the dissertation's routes", 0);
    let program = Program::this()?;
    let drive = drive(&program)?;
    let (line, machine) = environment(&program);
    let plot = plot(PLOTTED_ROUTE, &drive.path)?;
    drop(progress);
    let (markdown, json) = (markdown(&drive, &line), json(&drive, machine));
    output.write(&Report { name: "accuracy", markdown, json, plot: Some(plot) })?;
    Ok(ExitCode::SUCCESS)
}

fn drive(program: &Program) -> Result<Drive, Failure> {
    let folder = folder_with_porto()?;
    let scenario = folder.path().join("accuracy.yaml");
    let routes = END_POSES.iter().fold(String::new(), |mut text, row| {
        // Writing to a string can't fail.
        let _ = writeln!(text, "  - route: {:?}", row.route);
        text
    });
    write(&scenario, &format!("graph: porto.yaml\nrate: 100\nrobots:\n{routes}"))?;

    let mut experiment =
        Experiment::start(program, "accuracy", &scenario, &["--speed".into(), "20".into()])?;
    let plotted = END_POSES.iter().position(|row| row.route == PLOTTED_ROUTE).unwrap_or(0);
    let mut drive = Drive { end_poses: Vec::new(), path: Vec::new() };
    experiment.watch(Duration::from_secs(120), |frame| {
        drive.path.push(pose(frame, plotted));
        let done = all_idle(frame);
        if done {
            drive.end_poses = (0..frame.len()).map(|robot| pose(frame, robot)).collect();
        }
        done
    })?;
    experiment.finish()?;
    Ok(drive)
}

/// Returns the pose of a robot in metres and degrees.
fn pose(frame: &regatta_plugin::Frame<'_>, robot: usize) -> Pose {
    [
        f64::from(frame.x()[robot]),
        f64::from(frame.y()[robot]),
        f64::from(frame.theta()[robot]).to_degrees(),
    ]
}

/// Draws a driven path and the heading along it, as the dissertation's figures of edge 34 do.
fn plot(route: &[u32], poses: &[Pose]) -> Result<String, Failure> {
    let start = (0.0, poses.first().map_or(0.0, |pose| pose[2]));
    let along = poses.windows(2).scan(start, |(distance, heading), pair| {
        *distance += (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
        // The difference is wrapped to half a turn, so that the line has no jump where the angle
        // wraps.
        *heading += (pair[1][2] - *heading + 180.0).rem_euclid(360.0) - 180.0;
        Some((*distance, *heading))
    });
    let name = format!("route {route:?}");
    let path = poses.iter().map(|pose| (pose[0], pose[1])).collect();
    let heading = Series { name: name.clone(), points: along.collect() };
    plot::side_by_side(
        &Chart {
            caption: "Driven path",
            x: "x [m]",
            y: "y [m]",
            scale: Scale::Equal,
            series: vec![Series { name, points: path }],
        },
        &Chart {
            caption: "Heading along it",
            x: "distance [m]",
            y: "θ [°]",
            scale: Scale::Linear,
            series: vec![heading],
        },
    )
}

/// Returns the success rates of x, y and θ of a row.
fn rates(row: &EndPose, pose: &Pose) -> [Option<f64>; 3] {
    std::array::from_fn(|column| success_rate(pose[column], row.wanted[column], column == 2))
}

/// Returns the mean success rate of each column over the rows where the formula has a value.
fn averages(rows: &[EndPose], poses: &[Pose]) -> Pose {
    std::array::from_fn(|column| {
        let values: Vec<_> =
            rows.iter().zip(poses).filter_map(|(row, pose)| rates(row, pose)[column]).collect();
        values.iter().sum::<f64>() / values.len() as f64
    })
}

fn route_text(route: &[u32]) -> String {
    route.iter().map(u32::to_string).collect::<Vec<_>>().join(", ")
}

fn pose_text(pose: &Pose) -> String {
    format!("{:.4}, {:.4}, {:.4}", pose[0], pose[1], pose[2])
}

fn rates_text(rates: [Option<f64>; 3]) -> String {
    rates.map(|rate| rate.map_or("–".into(), |rate| format!("{rate:.3}"))).join(" / ")
}

fn markdown(drive: &Drive, environment: &str) -> String {
    let mut text = format!(
        "# Accuracy: end poses of the dissertation's routes\n\n{environment}\n\n\
         Poses are x m, y m, θ °; success rates follow equation 5.1, in % for x / y / θ, and have \
         no value where\n\
         the wanted value is 0. 'Dissertation' is the result of its own system on its own \
         graph.\n\n\
         | route | simulated | wanted | success rate | dissertation simulated | its success rate \
         |\n|---|---|---|---|---|---|\n"
    );
    for (row, pose) in END_POSES.iter().zip(&drive.end_poses) {
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} |",
            route_text(row.route),
            pose_text(pose),
            pose_text(&row.wanted),
            rates_text(rates(row, pose)),
            pose_text(&row.simulated),
            rates_text(rates(row, &row.simulated)),
        );
    }
    let _ = writeln!(text, "\n| average success rate | Regatta | dissertation |\n|---|---|---|");
    for (name, mean, published) in mean_rates(drive) {
        let _ = writeln!(
            text,
            "| {name} | {} | {} |",
            rates_text(mean.map(Some)),
            rates_text(published.map(Some))
        );
    }
    text.push_str("\n![Drive of edge 34](accuracy.svg)\n");
    text
}

/// Returns the name, Regatta's average and the dissertation's average of the single edges and of
/// the routes.
fn mean_rates(drive: &Drive) -> [(&'static str, Pose, Pose); 2] {
    let (edges, routes) = END_POSES.split_at(SINGLE_EDGES);
    let (edge_poses, route_poses) = drive.end_poses.split_at(SINGLE_EDGES);
    [
        ("single edges", averages(edges, edge_poses), AVERAGE_RATES[0]),
        ("routes", averages(routes, route_poses), AVERAGE_RATES[1]),
    ]
}

fn json(drive: &Drive, machine: serde_json::Value) -> serde_json::Value {
    let rows: Vec<_> = END_POSES
        .iter()
        .zip(&drive.end_poses)
        .map(|(row, pose)| {
            serde_json::json!({
                "route": row.route,
                "simulated": pose,
                "wanted": row.wanted,
                "success_rate_percent": rates(row, pose),
                "dissertation_simulated": row.simulated,
            })
        })
        .collect();
    let averages: serde_json::Map<_, _> = mean_rates(drive)
        .into_iter()
        .map(|(name, mean, published)| {
            (name.into(), serde_json::json!({"regatta": mean, "dissertation": published}))
        })
        .collect();
    serde_json::json!({
        "machine": machine, "rows": rows, "average_success_rate_percent": averages,
    })
}
