//! What reading a frame costs the metrics plugin and `top`, and what a page costs the exporter.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use regatta_metrics::fold::Fold;
use regatta_metrics::page::page;
use regatta_metrics::snapshot::Collisions;
use regatta_plugin::frame::{ColumnsMut, FrameHeader, Line, frame_lines, stride_lines};
use regatta_plugin::{FleetName, Frame};

/// A frame of robots in all states.
fn lines(robots: usize) -> Vec<Line> {
    let mut lines = vec![Line::default(); frame_lines(robots)];
    let columns = ColumnsMut::split(&mut lines, robots);
    columns.state.iter_mut().enumerate().for_each(|(robot, state)| *state = (robot % 5) as u8);
    columns.speed.iter_mut().enumerate().for_each(|(robot, speed)| *speed = (robot % 7) as f32 * 0.3);
    lines
}

fn fold(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("fold");
    for robots in [1_000, 10_000, 100_000, 1_000_000] {
        let lines = lines(robots);
        group.throughput(Throughput::Elements(robots as u64));
        group.bench_function(BenchmarkId::from_parameter(robots), |bencher| {
            let (mut fold, mut header) = (Fold::default(), FrameHeader::default());
            (header.robots, header.stride_lines) = (robots as u32, stride_lines(robots) as u32);
            bencher.iter(|| {
                header.tick += 1;
                fold.frame(&Frame::new(&header, black_box(&lines)).expect("a frame"), 0);
            });
        });
    }
    group.finish();
}

fn write_page(criterion: &mut Criterion) {
    let snapshot = Fold::default().snapshot(FleetName::default(), Collisions::default(), Vec::new(), 0);
    criterion.bench_function("page", |bencher| bencher.iter(|| page(black_box(&snapshot), None)));
}

criterion_group!(benches, fold, write_page);
criterion_main!(benches);
