//! Receives a visualiser's answers on a separate thread.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use parking_lot::Mutex;

use crate::echo::{EchoCheck, EchoRules};
use crate::line::{PoseLine, Separator, lines};
use crate::socket::{Buffers, Socket};
use crate::tally::{EverySecond, Faults};

/// The longest wait for a datagram before the deadlines are checked.
const POLL_PERIOD: Duration = Duration::from_millis(50);
/// The pause after an error of the socket, so that a persistent error takes no processor time.
const ERROR_PAUSE: Duration = Duration::from_millis(50);
/// The longest wait for the last answers.
const FINISH_TIMEOUT: Duration = Duration::from_secs(2);

/// The state that the receiving and the sending thread share.
#[derive(Debug)]
struct Shared {
    results: Mutex<Results>,
    stop: AtomicBool,
}

#[derive(Debug)]
struct Results {
    check: EchoCheck,
    faults: Faults,
}

/// The handle of the thread that receives and checks answers.
#[derive(Debug)]
pub struct EchoListener {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl EchoListener {
    /// Starts the thread. With `verbose`, it prints its results once a second.
    pub fn start(socket: Socket, rules: EchoRules, verbose: bool) -> Self {
        let results = Results { check: EchoCheck::new(rules), faults: Faults::default() };
        let shared =
            Arc::new(Shared { results: Mutex::new(results), stop: AtomicBool::new(false) });
        let for_thread = Arc::clone(&shared);
        let thread = std::thread::spawn(move || listen(&socket, &for_thread, verbose));
        Self { shared, thread: Some(thread) }
    }

    /// Calls `work` with the check.
    pub fn with<T>(&self, work: impl FnOnce(&mut EchoCheck) -> T) -> T {
        work(&mut self.shared.results.lock().check)
    }

    /// Waits for the last answers, at most until the deadline of the last line, and ends the
    /// thread.
    pub fn finish(&mut self) {
        let start = Instant::now();
        while start.elapsed() < FINISH_TIMEOUT && self.with(|check| check.totals().open() > 0) {
            std::thread::sleep(POLL_PERIOD);
        }
        self.shared.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // The panic of a thread has already been printed.
            let _ = thread.join();
        }
    }

    /// Returns the results in one line of text.
    pub fn summary(&self) -> String {
        self.shared.results.lock().summary()
    }
}

impl Results {
    fn summary(&self) -> String {
        let Self { check, faults } = self;
        if *faults == Faults::default() {
            format!("echo: {check}")
        } else {
            format!("echo: {check}; ignored {faults}")
        }
    }
}

fn listen(socket: &Socket, shared: &Shared, verbose: bool) {
    let mut buffers = Buffers::default();
    let mut second = EverySecond::new(Instant::now());
    while !shared.stop.load(Ordering::Relaxed) {
        socket.wait_to_receive(POLL_PERIOD);
        let received = socket.receive(&mut buffers, |datagram| judge(shared, datagram));
        if received.is_err() {
            std::thread::sleep(ERROR_PAUSE);
        }
        let now = Instant::now();
        let mut results = shared.results.lock();
        results.check.pass_time(now);
        if verbose && second.has_passed(now) {
            regatta_plugin::tell!("udp: {}", results.summary());
        }
    }
}

fn judge(shared: &Shared, datagram: &[u8]) {
    let now = Instant::now();
    let Results { check, faults } = &mut *shared.results.lock();
    for line in lines(datagram) {
        match PoseLine::parse(line, Separator::Space) {
            Ok(answer) => check.judge(&answer, now),
            Err(fault) => faults.count(fault),
        }
    }
}
