//! A frame's collisions, at one robot per 4 m², on one thread.
//!
//! Bars: 100,000 robots, touching only 6 ms, with prediction 40 ms; a million, 90 ms and 600 ms.

mod fleet;
mod rival;

use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use regatta_collision::{Detector, Scene, Settings};
use regatta_plugin::frame::Columns;

use fleet::Fleet;

const SIZES: [usize; 3] = [10_000, 100_000, 1_000_000];

fn frames(criterion: &mut Criterion) {
    let touching = Settings::new(0.0, 0.0).expect("sane");
    let predicting = Settings::new(0.2, 2.0).expect("sane");
    for (name, settings, types) in [
        ("touching only", touching, 1),
        ("touching only, four types", touching, 4),
        ("with prediction", predicting, 1),
        ("with prediction, four types", predicting, 4),
    ] {
        let mut group = criterion.benchmark_group(name);
        for robots in SIZES {
            let mut fleet = Fleet::new(robots, types);
            let mut detector = Detector::new(settings);
            detector.set_world(&fleet.edges, &fleet.types);
            group.throughput(Throughput::Elements(robots as u64));
            group.bench_function(BenchmarkId::from_parameter(robots), |bencher| {
                bencher.iter(|| detector.look(&fleet.scene()));
            });
            let (pairs, events) = (detector.contacts().len(), detector.events().len());
            eprintln!("{robots}: {pairs} pairs, {events} events, capped {}", detector.is_capped());
        }
    }
}

type Rival = fn(Columns) -> usize;

/// Spatial indexes on the touching level. They are only asked for the number of pairs: the detector above also follows
/// pairs from frame to frame, and marks the robots.
fn rivals(criterion: &mut Criterion) {
    let rivals: [(_, Rival); 3] = [("rstar", rival::rstar), ("parry2d", rival::parry), ("kiddo", rival::kiddo)];
    for (name, count) in rivals {
        let mut group = criterion.benchmark_group(name);
        for robots in SIZES {
            let mut fleet = Fleet::new(robots, 1);
            group.throughput(Throughput::Elements(robots as u64));
            group.bench_function(BenchmarkId::from_parameter(robots), |bencher| {
                bencher.iter(|| count(fleet.scene().columns));
            });
            let scene = fleet.scene();
            eprintln!("{robots}: {} pairs, the detector's {}", count(scene.columns), touching(&scene));
        }
    }
}

/// How many pairs the detector finds. Without a world, robots are of the first type.
fn touching(scene: &Scene) -> usize {
    let mut detector = Detector::new(Settings::new(0.0, 0.0).expect("sane"));
    detector.look(scene);
    detector.touching()
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(3));
    targets = frames, rivals
}
criterion_main!(benches);
