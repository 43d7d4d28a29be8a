//! The thread that receives a visualiser's answers.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::echo::{EchoCheck, EchoRules};
use crate::line::{PoseLine, Separator, lines};
use crate::socket::{Buffers, Socket};
use crate::tally::{EverySecond, Faults};

/// Longest sleep between looks at the clock.
const SLICE: Duration = Duration::from_millis(50);
/// After an error of the socket, so that one that stays takes no processor time.
const BREATHER: Duration = Duration::from_millis(50);
/// Longest wait for the last answers.
const LAST_WAIT: Duration = Duration::from_secs(2);

/// What the thread shares with the one that sends.
#[derive(Debug)]
struct Shared {
    check: Mutex<(EchoCheck, Faults)>,
    stop: AtomicBool,
}

impl Shared {
    /// A thread that panicked leaves counts behind, which are good enough to be told.
    fn lock(&self) -> MutexGuard<'_, (EchoCheck, Faults)> {
        self.check.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The thread. It tells what it finds once a second, if asked to.
#[derive(Debug)]
pub struct EchoListener {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl EchoListener {
    /// Starts listening.
    pub fn start(socket: Socket, rules: EchoRules, tell: bool) -> Self {
        let check = Mutex::new((EchoCheck::new(rules), Faults::default()));
        let shared = Arc::new(Shared { check, stop: AtomicBool::new(false) });
        let for_thread = Arc::clone(&shared);
        let thread = std::thread::spawn(move || listen(&socket, &for_thread, tell));
        Self { shared, thread: Some(thread) }
    }

    /// Lets `work` have the check.
    pub fn with<T>(&self, work: impl FnOnce(&mut EchoCheck) -> T) -> T {
        work(&mut self.shared.lock().0)
    }

    /// Waits for the last answers, until the deadline of the last line, and ends the thread.
    pub fn finish(&mut self) {
        let start = Instant::now();
        while start.elapsed() < LAST_WAIT && self.with(|check| check.totals().open() > 0) {
            std::thread::sleep(SLICE);
        }
        self.shared.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // If it panicked, it has said so.
            let _ = thread.join();
        }
    }

    /// One line for a person.
    pub fn summary(&self) -> String {
        summary(&self.shared.lock())
    }
}

fn summary((check, faults): &(EchoCheck, Faults)) -> String {
    match faults {
        faults if *faults == Faults::default() => format!("echo: {check}"),
        faults => format!("echo: {check}; ignored {faults}"),
    }
}

fn listen(socket: &Socket, shared: &Shared, tell: bool) {
    let mut buffers = Buffers::default();
    let mut second = EverySecond::new(Instant::now());
    while !shared.stop.load(Ordering::Relaxed) {
        socket.wait_to_receive(SLICE);
        let received = socket.receive(&mut buffers, |datagram| judge(shared, datagram));
        if received.is_err() {
            std::thread::sleep(BREATHER);
        }
        let now = Instant::now();
        let mut check = shared.lock();
        check.0.pass_time(now);
        if tell && second.has_passed(now) {
            regatta_plugin::tell!("udp: {}", summary(&check));
        }
    }
}

fn judge(shared: &Shared, datagram: &[u8]) {
    let now = Instant::now();
    let (check, faults) = &mut *shared.lock();
    for line in lines(datagram) {
        match PoseLine::parse(line, Separator::Space) {
            Ok(answer) => check.judge(&answer, now),
            Err(fault) => faults.count(fault),
        }
    }
}
