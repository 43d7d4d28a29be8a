//! Measures the time to write, read and send lines. One frame has 10,000 robots.
//!
//!     cargo bench -p regatta-bench --features benches --bench udp
//!
//! `send/…` is the time that the sender's thread takes for one frame of datagrams of 1,400 bytes
//! over the loopback interface, in three ways: one call per datagram, `sendmmsg`, and generic
//! segmentation offload. Another thread receives.

use std::hint::black_box;
use std::io::{IoSlice, Write as _};
use std::net::{SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use regatta_udp::line::{AngleUnit, LineFormat, PoseLine, Separator, lines};
use regatta_udp::packer::Packer;
use regatta_udp::socket::{Buffers, Listen, Socket};
use regatta_udp::source::intake::Intake;

const ROBOTS: u32 = 10_000;
const DATAGRAM_BYTES: usize = 1_400;

fn format() -> LineFormat {
    LineFormat::new(Separator::Comma, 3, AngleUnit::Degrees)
}

fn fleet() -> Vec<PoseLine> {
    let pose = |id: u32| {
        let part = (f64::from(id) * 0.618_033_988_75).fract() as f32;
        PoseLine { id, x: part * 250.0 - 20.0, y: 90.0 - part * 170.0, theta: part * 360.0 - 180.0 }
    };
    (0..ROBOTS).map(pose).collect()
}

/// Returns all batches of a frame.
fn packed(fleet: &[PoseLine]) -> Vec<Vec<u8>> {
    let mut packer = Packer::new(format(), DATAGRAM_BYTES);
    let mut batches = Vec::new();
    fleet.iter().for_each(|line| packer.push(line, |batch| batches.push(batch.bytes.to_vec())));
    packer.flush(|batch| batches.push(batch.bytes.to_vec()));
    batches
}

fn text(criterion: &mut Criterion) {
    let fleet = fleet();
    let mut group = criterion.benchmark_group("text");
    group.throughput(Throughput::Elements(ROBOTS.into()));
    group.bench_function("write with std::fmt", |bencher| {
        let mut out = Vec::new();
        bencher.iter(|| {
            out.clear();
            for PoseLine { id, x, y, theta } in &fleet {
                writeln!(out, "{id},{x:.3},{y:.3},{theta:.3}").expect("a vector");
            }
            black_box(out.len())
        });
    });
    group.bench_function("write", |bencher| {
        let mut out = Vec::new();
        bencher.iter(|| {
            out.clear();
            fleet.iter().for_each(|line| line.write(&mut out, format()));
            black_box(out.len())
        });
    });
    group.bench_function("write into datagrams", |bencher| {
        let mut packer = Packer::new(format(), DATAGRAM_BYTES);
        bencher.iter(|| {
            fleet
                .iter()
                .for_each(|line| packer.push(line, |batch| _ = black_box(batch.bytes.len())));
            packer.flush(|batch| _ = black_box(batch.bytes.len()));
        });
    });
    let batches = packed(&fleet);
    group.bench_function("read", |bencher| {
        bencher.iter(|| {
            let all = batches.iter().flat_map(|batch| batch.chunks(DATAGRAM_BYTES)).flat_map(lines);
            all.for_each(|line| _ = black_box(PoseLine::parse(line, Separator::Comma)));
        });
    });
    group.bench_function("read into a fleet", |bencher| {
        let mut intake = Intake::new(AngleUnit::Degrees, [0.0; 2], DATAGRAM_BYTES, ROBOTS);
        let mut now = Duration::ZERO;
        bencher.iter(|| {
            now += Duration::from_millis(20);
            let datagrams = batches.iter().flat_map(|batch| batch.chunks(DATAGRAM_BYTES));
            datagrams.for_each(|datagram| intake.take(datagram, now, |line| _ = black_box(line)));
        });
    });
    group.finish();
}

/// Calls `work` with the address of a socket, and receives at that address on another thread
/// meanwhile.
fn received<T>(work: impl FnOnce(SocketAddr) -> T) -> T {
    let receiver = Socket::listen(&Listen::loopback(0)).expect("a socket");
    let to = receiver.local_address().expect("an address");
    let done = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let mut buffers = Buffers::default();
            while !done.load(Ordering::Relaxed) {
                receiver.wait_to_receive(Duration::from_millis(10));
                receiver
                    .receive(&mut buffers, |datagram| _ = black_box(datagram.len()))
                    .expect("received");
            }
        });
        let result = work(to);
        done.store(true, Ordering::Relaxed);
        result
    })
}

fn send(criterion: &mut Criterion) {
    let batches = packed(&fleet());
    let mut group = criterion.benchmark_group("send");
    group.throughput(Throughput::Elements(ROBOTS.into()));
    received(|to| {
        let socket = UdpSocket::bind("127.0.0.1:0").expect("a socket");
        socket.connect(to).expect("connected");
        group.bench_function("a call a datagram", |bencher| {
            bencher.iter(|| {
                for datagram in batches.iter().flat_map(|batch| batch.chunks(DATAGRAM_BYTES)) {
                    socket.send(datagram).expect("sent");
                }
            });
        });
    });
    received(|to| {
        let socket = UdpSocket::bind("127.0.0.1:0").expect("a socket");
        socket.connect(to).expect("connected");
        group.bench_function("sendmmsg", |bencher| {
            bencher.iter(|| batches.iter().for_each(|batch| sendmmsg(&socket, batch)))
        });
    });
    received(|to| {
        let socket = Socket::towards(to).expect("a socket");
        group.bench_function("segmentation offload", |bencher| {
            bencher.iter(|| {
                batches
                    .iter()
                    .for_each(|batch| _ = socket.send(to, batch, DATAGRAM_BYTES).expect("sent"))
            });
        });
    });
    group.finish();
}

/// Sends all datagrams of a batch in as few calls as possible.
fn sendmmsg(socket: &UdpSocket, batch: &[u8]) {
    use rustix::net::{MMsgHdr, SendAncillaryBuffer, SendFlags};
    let slices: Vec<_> =
        batch.chunks(DATAGRAM_BYTES).map(|datagram| [IoSlice::new(datagram)]).collect();
    let mut controls: Vec<_> = slices.iter().map(|_| SendAncillaryBuffer::default()).collect();
    let mut headers: Vec<_> = slices
        .iter()
        .zip(&mut controls)
        .map(|(slice, control)| MMsgHdr::new(slice, control))
        .collect();
    let mut sent = 0;
    while sent < headers.len() {
        sent +=
            rustix::net::sendmmsg(socket, &mut headers[sent..], SendFlags::empty()).expect("sent");
    }
}

criterion_group!(benches, text, send);
criterion_main!(benches);
