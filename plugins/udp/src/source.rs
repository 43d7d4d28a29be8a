//! `regatta plugin udp-source`: whoever sends lines becomes the producer of a fleet.

mod answers;
mod control;
mod figures;
pub mod intake;
mod options;
pub mod robots;
mod ticker;

use std::ffi::OsString;
use std::time::{Duration, Instant};

use regatta_plugin::column::ColumnHeader;
use regatta_plugin::frame::{ClockState, FrameHeader};
use regatta_plugin::publish::Producer;
use regatta_plugin::{NAME_VARIABLE, Participant, Result, Termination, set_verbosity};

use crate::line::{LineFormat, Separator};
use crate::options::parse;
use crate::socket::{Buffers, Socket, resolve_receiver};
use crate::tally::{Effort, EverySecond};
use answers::Answers;
use control::clock_state;
use figures::Trouble;
use intake::Intake;
use options::SourceOptions;
use ticker::Ticker;

/// Longest wait between looks at control requests.
const CONTROL_POLL: Duration = Duration::from_millis(5);

/// Runs the source with a command line, whose first argument is the plugin.
///
/// # Errors
/// If an option is wrong, the address can't be listened on, the fleet has a producer already, or shared memory
/// fails.
pub fn run(args: impl IntoIterator<Item: Into<OsString> + Clone>) -> Result {
    let Some(options) = parse::<SourceOptions>(args)? else { return Ok(()) };
    set_verbosity(options.verbose);
    let termination = Termination::watch()?;
    let mut source = Source::open(&options)?;
    let result = source.run(&termination);
    source.close(options.json);
    result
}

struct Source {
    producer: Producer,
    socket: Socket,
    buffers: Buffers,
    intake: Intake,
    answers: Option<Answers>,
    ticker: Ticker,
    paused: bool,
    forget: Option<Duration>,
    has_type: bool,
    /// Rows that the column `type` last told of.
    typed_rows: usize,
    orders_refused: u64,
    receive_errors: u64,
    started: Instant,
    effort: Effort,
    second: EverySecond,
    told: Trouble,
    verbose: bool,
}

impl Source {
    fn open(options: &SourceOptions) -> Result<Self> {
        let socket = Socket::listen(&options.listen)?;
        let unit = options.form.unit();
        let format = LineFormat::new(Separator::Space, options.form.decimals, unit);
        let answers = options.echo_to.as_ref().map(|to| Answers::open(resolve_receiver(to)?, format, options.form.mtu));
        let answers = answers.transpose()?;
        let name = options.name.clone().or_else(|| std::env::var(NAME_VARIABLE).ok());
        let participant = Participant::join(&options.fleet, name.as_deref().unwrap_or("udp-source"))?;
        let mut producer = Producer::create_on(participant, 0)?;
        producer.check_room(options.max_robots as usize)?;
        let kinds: Vec<_> = options.robot_type().into_iter().collect();
        producer.publish_world(&[], &[], &kinds)?;
        regatta_plugin::tell!(
            "udp-source: listening on {} with {} bytes of receive buffer, for fleet '{}'",
            socket.local_address()?,
            socket.receive_buffer_bytes(),
            options.fleet
        );
        let now = Instant::now();
        Ok(Self {
            producer,
            socket,
            buffers: Buffers::default(),
            intake: Intake::new(unit, options.offset.0, options.max_datagram, options.max_robots),
            answers,
            ticker: Ticker::new(Duration::from_secs_f64(1.0 / options.rate), now),
            paused: false,
            forget: options.forget,
            has_type: !kinds.is_empty(),
            typed_rows: 0,
            orders_refused: 0,
            receive_errors: 0,
            started: now,
            effort: Effort::start(),
            second: EverySecond::new(now),
            told: Trouble::default(),
            verbose: options.verbose > 0,
        })
    }

    fn run(&mut self, termination: &Termination) -> Result {
        self.publish(ClockState::Running)?;
        while !termination.requested() {
            self.answer_requests()?;
            let rest = if self.paused { CONTROL_POLL } else { self.ticker.rest(Instant::now()) };
            self.receive_until(Instant::now() + rest.min(CONTROL_POLL));
            self.refuse_orders()?;
            if self.paused {
                self.producer.update();
            } else if self.ticker.rest(Instant::now()).is_zero() {
                self.tick()?;
            }
            self.tell();
        }
        self.publish(ClockState::Stopped)
    }

    /// Time since the start.
    fn now(&self) -> Duration {
        self.started.elapsed()
    }

    /// Takes what comes until then; once at least, however late it is.
    fn receive_until(&mut self, end: Instant) {
        loop {
            let received = self.receive();
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return;
            }
            if !received {
                self.socket.wait_to_receive(left);
            }
        }
    }

    fn receive(&mut self) -> bool {
        let now = self.now();
        let Self { socket, buffers, intake, answers, .. } = self;
        let received = socket.receive(buffers, |datagram| {
            intake.take(datagram, now, |line| {
                if let Some(answers) = answers {
                    answers.push(line);
                }
            });
        });
        if let Some(answers) = answers {
            answers.flush();
        }
        received.unwrap_or_else(|_| {
            self.receive_errors += 1;
            // One that stays takes no processor time.
            std::thread::sleep(CONTROL_POLL / 5);
            false
        })
    }

    fn tick(&mut self) -> Result {
        let start = Instant::now();
        self.ticker.tick += 1;
        if let Some(silence) = self.forget {
            self.intake.robots.forget(silence, self.now());
        }
        self.publish(clock_state(self.paused))?;
        self.ticker.tick_done(start, Instant::now());
        Ok(())
    }

    fn set_paused(&mut self, paused: bool) -> Result {
        self.paused = paused;
        self.ticker.restart(Instant::now());
        self.publish(clock_state(paused))
    }

    /// Publishes the robots as they are now.
    fn publish(&mut self, clock: ClockState) -> Result {
        let rows = self.intake.robots.len();
        let mut frame = self.producer.loan(rows)?;
        let header = frame.header_mut();
        *header = FrameHeader {
            tick: self.ticker.tick,
            sim_time_nanos: self.ticker.sim_time_nanos(),
            late_ticks: self.ticker.late_ticks,
            tick_cost_nanos: self.ticker.last_cost().as_nanos() as u64,
            tick_period_nanos: self.ticker.period().as_nanos() as u64,
            speed: 1.0,
            clock: clock as u32,
            ..*header
        };
        self.intake.robots.write(&mut frame.columns_mut(), self.started.elapsed());
        frame.send()?;
        self.publish_types(rows)?;
        self.producer.notify();
        self.producer.update();
        Ok(())
    }

    fn publish_types(&mut self, rows: usize) -> Result {
        if self.has_type && rows != self.typed_rows {
            let header = ColumnHeader { tick: self.ticker.tick, ..ColumnHeader::default() };
            self.producer.publish_column("type", header, &vec![0.0; rows])?;
            self.typed_rows = rows;
        }
        Ok(())
    }
}
