//! A frame's collisions, at one robot per 4 m², on one thread.
//!
//! Bars: 100,000 robots, touching only 6 ms, with prediction 40 ms; a million, 90 ms and 600 ms.

mod fleet;
mod rival;

use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use regatta_collision::{Detector, Settings};

use fleet::Fleet;

const SIZES: [usize; 3] = [10_000, 100_000, 1_000_000];

fn frames(criterion: &mut Criterion) {
    for (name, margin, horizon) in [("touching only", 0.0, 0.0), ("with prediction", 0.2, 2.0)] {
        let mut group = criterion.benchmark_group(name);
        for robots in SIZES {
            let mut fleet = Fleet::new(robots);
            let mut detector = Detector::new(Settings::new(margin, horizon).expect("sane"));
            detector.set_world(&fleet.edges, &fleet.types);
            group.throughput(Throughput::Elements(robots as u64));
            group.bench_function(BenchmarkId::from_parameter(robots), |bencher| {
                bencher.iter(|| detector.look(&fleet.scene()));
            });
            let contacts = detector.contacts();
            eprintln!(
                "{robots}: {} pairs, {} events, capped {}",
                contacts.len(),
                detector.events().len(),
                detector.is_capped()
            );
        }
    }
}

/// A spatial index, filled and asked anew in each frame. It only finds which boxes overlap; the detector above also checks
/// the rectangles, follows pairs from frame to frame, and marks the robots.
fn rivals(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("rstar, boxes alone");
    for robots in SIZES {
        let mut fleet = Fleet::new(robots);
        group.throughput(Throughput::Elements(robots as u64));
        group.bench_function(BenchmarkId::from_parameter(robots), |bencher| {
            bencher.iter(|| {
                let columns = fleet.scene().columns;
                rival::near_pairs(columns.x, columns.y)
            });
        });
    }
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
