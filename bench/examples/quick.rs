//! Quick look.
use regatta_bench::*;
use regatta_engine::motion::Isa;
use std::time::Instant;
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let isas: Vec<Isa> = args
        .get(1)
        .map_or(Isa::ALL.to_vec(), |s| s.split(',').filter(|s| *s != "all").map(|s| s.parse().unwrap()).collect());
    let isas = if isas.is_empty() { Isa::ALL.to_vec() } else { isas };
    let sizes: Vec<usize> = args
        .get(2)
        .map_or(vec![1000, 10_000, 100_000, 1_000_000], |s| s.split(',').map(|s| s.parse().unwrap()).collect());
    let threads: Vec<usize> = args.get(3).map_or(vec![1], |s| s.split(',').map(|s| s.parse().unwrap()).collect());
    let accel: Vec<f32> =
        args.get(4).map_or(vec![f32::INFINITY], |s| s.split(',').map(|s| s.parse().unwrap()).collect());
    let world = World::new();
    eprintln!("{} edges {} pieces", world.graph.edges().len(), world.tracks.pieces().len());
    for &a in &accel {
        for &isa in &isas {
            for &t in &threads {
                for &n in &sizes {
                    let mut fleet = world.fleet(n, isa, t, a);
                    let mut ring = Ring::new(n);
                    let mut events = silence();
                    let ticks = (300_000_000 / n).clamp(20, 60000);
                    for _ in 0..20 {
                        fleet.step(Some(ring.next_frame()), &mut events);
                    }
                    let mut best = f64::INFINITY;
                    let mut times = vec![];
                    for _ in 0..ticks {
                        let t0 = Instant::now();
                        fleet.step(Some(ring.next_frame()), &mut events);
                        let e = t0.elapsed().as_secs_f64();
                        best = best.min(e);
                        times.push(e);
                    }
                    times.sort_by(f64::total_cmp);
                    let median = times[times.len() / 2];
                    println!(
                        "a={a} {isa:8} t={t} n={n:8}: median {:7.1} M/s best {:7.1} M/s",
                        n as f64 / median / 1e6,
                        n as f64 / best / 1e6
                    );
                }
            }
        }
    }
}
