//! Measures collision detection of whole frames, at one robot per 4 m², on one thread.
//!
//! Targets: for 100,000 robots, touching only 6 ms and with prediction 40 ms; for a million, 90 ms
//! and 600 ms.

mod baseline;
mod fleet;

use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use regatta_collision::{Detector, FrameInput, Settings};
use regatta_plugin::frame::Columns;

use fleet::Fleet;

const SIZES: [usize; 3] = [10_000, 100_000, 1_000_000];

fn frames(criterion: &mut Criterion) {
    let touching = Settings::new(0.0, 0.0).expect("valid settings");
    let predicting = Settings::new(0.2, 2.0).expect("valid settings");
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
            detector.set_world(&fleet.world.view(1, 1));
            group.throughput(Throughput::Elements(robots as u64));
            group.bench_function(BenchmarkId::from_parameter(robots), |bencher| {
                bencher.iter(|| detector.update(&fleet.input()));
            });
            let (pairs, events) = (detector.contacts().len(), detector.events().len());
            println!("{robots}: {pairs} pairs, {events} events, capped {}", detector.is_capped());
        }
    }
}

type Baseline = fn(Columns) -> usize;

/// Measures spatial indexes on the touching level. They only count the pairs, whereas the detector
/// above also follows pairs from frame to frame and marks the robots.
fn baselines(criterion: &mut Criterion) {
    let baselines: [(_, Baseline); 3] =
        [("rstar", baseline::rstar), ("parry2d", baseline::parry), ("kiddo", baseline::kiddo)];
    for (name, count) in baselines {
        let mut group = criterion.benchmark_group(name);
        for robots in SIZES {
            let mut fleet = Fleet::new(robots, 1);
            group.throughput(Throughput::Elements(robots as u64));
            group.bench_function(BenchmarkId::from_parameter(robots), |bencher| {
                bencher.iter(|| count(fleet.input().columns));
            });
            let input = fleet.input();
            println!("{robots}: {} pairs, detector {}", count(input.columns), touching(&input));
        }
    }
}

/// Returns the number of pairs that the detector finds. Without a world, robots are of the first
/// type.
fn touching(input: &FrameInput) -> usize {
    let mut detector = Detector::new(Settings::new(0.0, 0.0).expect("valid settings"));
    detector.update(input);
    detector.touching()
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(3));
    targets = frames, baselines
}
criterion_main!(benches);
