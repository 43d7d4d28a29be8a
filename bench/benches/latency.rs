//! The latency of a frame to a reader in another process: from just before the frame is sent to the
//! first access of the woken reader to its poses. Goals for 10,000 robots on a quiet machine:
//! median 15 µs, 99th percentile 80 µs.
//!
//!     cargo bench -p regatta-bench --features benches --bench latency -- \
//!         [--robots N] [--hz N] [--frames N]

use std::hint::black_box;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use regatta_plugin::ProducerPorts;
use regatta_plugin::{FleetName, Result, Subscriber};

/// The number of frames before the measured ones.
const WARM_UP: usize = 200;
/// The longest wait for the reader, and of the reader for a frame.
const TIMEOUT: Duration = Duration::from_secs(10);

fn main() -> Result {
    let number = |option: &str, default: usize| {
        let mut args = std::env::args().skip_while(|arg| arg != option).skip(1);
        args.next().and_then(|value| value.parse().ok()).unwrap_or(default)
    };
    let frames = number("--frames", 5_000);
    match std::env::var("REGATTA_BENCH_FLEET") {
        Ok(fleet) => read(&fleet.parse()?, frames),
        Err(_) => publish(number("--robots", 10_000), number("--hz", 500), frames),
    }
}

/// Publishes frames to a reader process and measures the cost of sending and of waking.
fn publish(robots: usize, hz: usize, frames: usize) -> Result {
    let fleet: FleetName = format!("bench-latency-{}", std::process::id()).parse()?;
    let producer = ProducerPorts::create(&fleet, robots)?;
    let mut reader = Command::new(std::env::current_exe()?)
        .args(["--frames", &frames.to_string()])
        .env("REGATTA_BENCH_FLEET", fleet.as_str())
        .stdin(Stdio::null())
        .spawn()?;
    let started = Instant::now();
    while producer.frame_readers() == 0 && started.elapsed() < TIMEOUT {
        std::thread::sleep(Duration::from_millis(1));
    }
    println!("{robots} robots at {hz} Hz, {frames} frames, in µs:");
    let (mut sends, mut wakes) = (Vec::new(), Vec::new());
    let mut deadline = Instant::now();
    for tick in 0..(WARM_UP + frames) as u64 {
        let mut frame = producer.loan(robots)?;
        frame.header_mut().tick = tick;
        frame.columns_mut().x.fill(tick as f32);
        let start = Instant::now();
        frame.send()?;
        let sent = Instant::now();
        producer.notify();
        let woken = Instant::now();
        if tick >= WARM_UP as u64 {
            sends.push((sent - start).as_nanos() as u64);
            wakes.push((woken - sent).as_nanos() as u64);
        }
        deadline += Duration::from_secs(1) / hz as u32;
        std::thread::sleep(deadline.saturating_duration_since(Instant::now()));
    }
    print_percentiles("send", &mut sends);
    print_percentiles("notify", &mut wakes);
    // The reader may have missed the last frame. It ends when the producer is gone and no frame
    // arrives in time.
    drop(producer);
    reader.wait()?;
    Ok(())
}

/// Reads frames and measures their latency.
fn read(fleet: &FleetName, frames: usize) -> Result {
    let mut subscriber = Subscriber::open(fleet)?;
    let mut latencies = Vec::with_capacity(frames);
    let last = (WARM_UP + frames) as u64 - 1;
    while let Some(frame) = subscriber.wait(TIMEOUT)? {
        black_box(frame.x()[0]);
        let now = SystemTime::now().duration_since(UNIX_EPOCH)?.as_nanos() as u64;
        if frame.tick() >= WARM_UP as u64 {
            latencies.push(now.saturating_sub(frame.header().wall_time_nanos));
        }
        if frame.tick() == last {
            break;
        }
    }
    println!("  reader received {} of {frames} frames", latencies.len());
    print_percentiles("frame to reader", &mut latencies);
    Ok(())
}

fn print_percentiles(name: &str, nanos: &mut [u64]) {
    nanos.sort_unstable();
    let percentile =
        |p: f64| nanos.get(((nanos.len() as f64 * p) as usize).min(nanos.len().saturating_sub(1)));
    let micros = |p| percentile(p).map_or(f64::NAN, |&nanos| nanos as f64 * 1e-3);
    println!(
        "  {name}: median {:.1}, p99 {:.1}, worst {:.1}",
        micros(0.5),
        micros(0.99),
        micros(1.0)
    );
}
