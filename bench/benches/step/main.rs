//! Measures a tick of the whole fleet, which steps all robots and writes their poses into a loaned
//! frame, in robot updates per second.
//!
//! The robots are on random walks in a generated warehouse at 60 Hz, and frames are written in turn
//! as by a publisher. The same run measures the machine's memory, and an entity-component-system
//! simulation for comparison.

mod ecs;
mod memory;

use std::time::Duration;

use criterion::measurement::WallTime;
use criterion::{
    BenchmarkGroup, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main,
};
use regatta_bench::{FrameRing, World, unread_events};
use regatta_motion::Isa;

const MILLION: usize = 1_000_000;

fn isas() -> impl Iterator<Item = Isa> {
    Isa::ALL.into_iter().filter(|isa| isa.is_supported())
}

/// A fleet to measure.
#[derive(Clone, Copy)]
struct Case {
    robots: usize,
    isa: Isa,
    threads: usize,
    max_acceleration: f32,
}

impl Case {
    fn without_limits(robots: usize, isa: Isa, threads: usize) -> Self {
        Self { robots, isa, threads, max_acceleration: f32::INFINITY }
    }

    fn bench(self, group: &mut BenchmarkGroup<WallTime>, world: &World, id: BenchmarkId) {
        let mut fleet = world.fleet(self.robots, self.isa, self.threads, self.max_acceleration);
        let (mut ring, mut events) = (FrameRing::new(self.robots), unread_events());
        group.throughput(Throughput::Elements(self.robots as u64));
        group.bench_function(id, |bencher| {
            bencher.iter(|| fleet.step(Some(ring.loan()), &mut events))
        });
    }
}

fn instruction_sets(criterion: &mut Criterion) {
    let (world, mut group) =
        (World::new(), criterion.benchmark_group("one thread, a million robots"));
    for isa in isas() {
        Case::without_limits(MILLION, isa, 1).bench(
            &mut group,
            &world,
            BenchmarkId::from_parameter(isa),
        );
    }
}

fn sizes(criterion: &mut Criterion) {
    let (world, mut group) = (World::new(), criterion.benchmark_group("one thread, by robots"));
    for robots in [1000, 10_000, 100_000, MILLION] {
        Case::without_limits(robots, Isa::detect(), 1).bench(
            &mut group,
            &world,
            BenchmarkId::from_parameter(robots),
        );
    }
}

fn threads(criterion: &mut Criterion) {
    let (world, mut group) =
        (World::new(), criterion.benchmark_group("a million robots, by threads"));
    for isa in [Isa::Baseline, Isa::detect()] {
        for threads in [1, 2] {
            Case::without_limits(MILLION, isa, threads).bench(
                &mut group,
                &world,
                BenchmarkId::new(isa.name(), threads),
            );
        }
    }
}

fn acceleration_limits(criterion: &mut Criterion) {
    let (world, mut group) =
        (World::new(), criterion.benchmark_group("with acceleration limits, a million robots"));
    for isa in isas() {
        let case = Case { max_acceleration: 1.0, ..Case::without_limits(MILLION, isa, 1) };
        case.bench(&mut group, &world, BenchmarkId::from_parameter(isa));
    }
}

fn entity_component_system(criterion: &mut Criterion) {
    let (world, mut group) =
        (World::new(), criterion.benchmark_group("entity per robot, bevy_ecs and libm"));
    for robots in [1000, MILLION] {
        let mut simulation = ecs::EcsSimulation::new(&world, robots);
        group.throughput(Throughput::Elements(robots as u64));
        group.bench_function(BenchmarkId::from_parameter(robots), |bencher| {
            bencher.iter(|| simulation.step())
        });
    }
}

/// Prints the rates of the machine's memory and the share of their limit that is reached.
fn memory_limit(_: &mut Criterion) {
    let world = World::new();
    for robots in [100_000, MILLION] {
        for isa in [Isa::Avx2, Isa::Avx512].into_iter().filter(|isa| isa.is_supported()) {
            memory::print_share(&world, robots, isa);
        }
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(2));
    targets = memory_limit, instruction_sets, sizes, threads, acceleration_limits, entity_component_system
}
criterion_main!(benches);
