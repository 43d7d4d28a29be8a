//! Measures what the traffic plugin does for each frame: counting robots on edges, adding the
//! counts up, hot spots.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use regatta_base::random::mix;
use regatta_kit::Spots;
use regatta_plugin::Frame;
use regatta_plugin::frame::{ColumnsMut, FrameHeader, Line, RobotState, frame_lines, stride_lines};
use regatta_plugin::history::FleetSample;
use regatta_traffic::periods::Periods;
use regatta_traffic::tally::Tally;

const ROBOTS: usize = 1_000_000;
const EDGES: usize = 100_000;
/// The simulated time between two frames, in nanoseconds: the plugin takes ten per second.
const FRAME_NANOS: u64 = 100_000_000;

/// Returns a frame of robots anywhere on the edges, every `nth` of which stands and waits.
fn lines(nth: usize) -> Vec<Line> {
    let mut lines = vec![Line::default(); frame_lines(ROBOTS)];
    let columns = ColumnsMut::split(&mut lines, ROBOTS);
    for robot in 0..ROBOTS {
        let edge = (mix(robot as u64) >> 33) as usize % EDGES;
        columns.edge[robot] = edge as u32;
        (columns.x[robot], columns.y[robot]) =
            ((edge % 316) as f32 * 6.0, (edge / 316) as f32 * 6.0);
        let waits = robot % nth == 0;
        columns.speed[robot] = if waits { 0.0 } else { 1.5 };
        columns.state[robot] = if waits { RobotState::Waiting } else { RobotState::Driving } as u8;
    }
    lines
}

fn traffic(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("traffic");
    group.throughput(Throughput::Elements(ROBOTS as u64));
    for (name, nth) in [("few wait", 1_000), ("a tenth waits", 10)] {
        let lines = lines(nth);
        let mut header = FrameHeader { run_id: 1, robots: ROBOTS as u32, ..FrameHeader::default() };
        header.stride_lines = stride_lines(ROBOTS) as u32;
        let first = header;
        let frame = Frame::new(&first, &lines).expect("a frame");
        group.bench_function(BenchmarkId::new("edges", name), |bencher| {
            let (mut tally, mut periods) = (Tally::default(), Periods::new(EDGES));
            tally.begin(EDGES);
            bencher.iter(|| periods.add(tally.count(black_box(&frame.columns()), &[]), 0.1));
        });
        // Once a second.
        group.bench_function(BenchmarkId::new("figures", name), |bencher| {
            let (mut tally, mut periods, mut figures) =
                (Tally::default(), Periods::new(EDGES), Vec::new());
            tally.begin(EDGES);
            (0..900).for_each(|_| periods.add(tally.count(&frame.columns(), &[]), 1.0));
            bencher.iter(|| periods.figures(black_box(&[2.0; EDGES]), &mut figures));
        });
        // Twice a second.
        group.bench_function(BenchmarkId::new("sample", name), |bencher| {
            bencher.iter(|| FleetSample::of(black_box(&frame), &[]));
        });
        let mut spots = Spots::default();
        group.bench_function(BenchmarkId::new("spots", name), |bencher| {
            bencher.iter(|| {
                header.sim_time_nanos += FRAME_NANOS;
                spots.add(&Frame::new(&header, black_box(&lines)).expect("a frame"), &[]);
            });
        });
        // Twice a second.
        group.bench_function(BenchmarkId::new("list of spots", name), |bencher| {
            bencher.iter(|| spots.list())
        });
    }
    group.finish();
}

criterion_group!(benches, traffic);
criterion_main!(benches);
