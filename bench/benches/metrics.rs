//! Measures the cost of reading a frame in the metrics plugin and in `regatta top`, and of a page
//! in the exporter.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use regatta_metrics::aggregator::Aggregator;
use regatta_metrics::exposition::Format;
use regatta_metrics::page::{ExporterState, page};
use regatta_plugin::frame::{ColumnsMut, FrameHeader, Line, frame_lines, stride_lines};
use regatta_plugin::{FleetName, Frame};

/// Returns a frame of robots in all states.
fn lines(robots: usize) -> Vec<Line> {
    let mut lines = vec![Line::default(); frame_lines(robots)];
    let columns = ColumnsMut::split(&mut lines, robots);
    columns.state.iter_mut().enumerate().for_each(|(robot, state)| *state = (robot % 5) as u8);
    columns
        .speed
        .iter_mut()
        .enumerate()
        .for_each(|(robot, speed)| *speed = (robot % 7) as f32 * 0.3);
    lines
}

fn aggregate(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("fold");
    for robots in [1_000, 10_000, 100_000, 1_000_000] {
        let lines = lines(robots);
        group.throughput(Throughput::Elements(robots as u64));
        group.bench_function(BenchmarkId::from_parameter(robots), |bencher| {
            let (mut aggregator, mut header) = (Aggregator::default(), FrameHeader::default());
            (header.robots, header.stride_lines) = (robots as u32, stride_lines(robots) as u32);
            bencher.iter(|| {
                header.tick += 1;
                aggregator.add_frame(&Frame::new(&header, black_box(&lines)).expect("a frame"), 0);
            });
        });
    }
    group.finish();
}

fn write_page(criterion: &mut Criterion) {
    let snapshot = Aggregator::default().snapshot(&FleetName::default(), 0);
    criterion.bench_function("page", |bencher| {
        bencher.iter(|| page(black_box(&snapshot), &ExporterState::default(), Format::Prometheus))
    });
}

criterion_group!(benches, aggregate, write_page);
criterion_main!(benches);
