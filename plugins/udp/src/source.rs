//! `regatta plugin udp-source`: whoever sends lines becomes the producer of a fleet.

mod answers;
mod control;
pub mod intake;
pub mod robots;
mod ticker;

use std::ffi::OsString;
use std::time::{Duration, Instant};

use clap::Parser;
use regatta_plugin::column::ColumnHeader;
use regatta_plugin::frame::{ClockState, FrameHeader};
use regatta_plugin::publish::Producer;
use regatta_plugin::world::{RobotTypeRecord, Shape};
use regatta_plugin::{FleetName, NAME_VARIABLE, Participant, Result, Termination, set_verbosity};

use crate::line::{LineFormat, Separator};
use crate::options::{self, Form, Offset};
use crate::packer::MAX_DATAGRAM_BYTES;
use crate::socket::{Buffers, Listen, Socket, resolve};
use crate::tally::{Effort, EverySecond, Faults};
use answers::Answers;
use control::clock_state;
use intake::Intake;
use ticker::Ticker;

/// Longest wait between looks at control requests.
const CONTROL_POLL: Duration = Duration::from_millis(5);
/// Most robots that can be allowed.
const MOST_ROBOTS: i64 = 1 << 24;

/// Makes a fleet of the poses that arrive in UDP datagrams, as lines `id,x,y,theta`
#[derive(Parser, Debug)]
#[command(name = "udp-source", bin_name = "regatta plugin udp-source", max_term_width = 100)]
struct SourceOptions {
    /// Where to receive; a port alone is one of this machine's own
    #[arg(long, value_name = "[HOST:]PORT")]
    listen: Listen,
    /// The fleet to make
    #[arg(long, value_name = "NAME", default_value_t)]
    fleet: FleetName,
    /// Frames per second
    #[arg(long, value_name = "HZ", default_value = "50", value_parser = rate)]
    rate: f64,
    /// Robots have ids below this
    #[arg(long, value_name = "N", default_value = "10000", value_parser = clap::value_parser!(u32).range(1..=MOST_ROBOTS))]
    max_robots: u32,
    /// Metres along the heading of a robot; without it, the robots have no type
    #[arg(long, value_name = "METRES", requires = "robot_width", value_parser = metres)]
    robot_length: Option<f32>,
    /// Metres across it
    #[arg(long, value_name = "METRES", requires = "robot_length", value_parser = metres)]
    robot_width: Option<f32>,
    /// What to add to all positions, in metres
    #[arg(long, value_name = "X,Y", default_value = "0,0", allow_hyphen_values = true)]
    offset: Offset,
    /// Where to answer each line to, as `id x y theta` with the offset added
    #[arg(long, value_name = "HOST:PORT")]
    echo_to: Option<String>,
    #[command(flatten)]
    form: Form,
    /// Ignore datagrams that are longer
    #[arg(long, value_name = "BYTES", default_value_t = MAX_DATAGRAM_BYTES)]
    max_datagram: usize,
    /// Seconds of silence after which a robot is gone [default: never]
    #[arg(long, value_name = "SECONDS", value_parser = options::seconds)]
    forget: Option<Duration>,
    /// Print the closing figures as JSON too, on standard output
    #[arg(long)]
    json: bool,
    /// The name to go by in `regatta doctor` [default: the program's name]
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// Tell the figures once a second, and warnings of shared memory (iceoryx2); twice for all of its log
    #[arg(short, long, action = clap::ArgAction::Count)]
    verbose: u8,
}

/// Runs the source with a command line, whose first argument is the plugin.
///
/// # Errors
/// If an option is wrong, the address can't be listened on, the fleet has a producer already, or shared memory
/// fails.
pub fn run(args: impl IntoIterator<Item: Into<OsString> + Clone>) -> Result {
    let Some(options) = options::parse::<SourceOptions>(args)? else { return Ok(()) };
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

/// What a user should know of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Trouble {
    faults: Faults,
    dropped: u64,
    orders_refused: u64,
    answers_refused: u64,
    receive_errors: u64,
}

impl Source {
    fn open(options: &SourceOptions) -> Result<Self> {
        let socket = Socket::listen(&options.listen)?;
        let unit = options.form.unit();
        let format = LineFormat::new(Separator::Space, options.form.decimals, unit);
        let answers = options.echo_to.as_ref().map(|to| Answers::open(resolve(to)?, format, options.form.mtu));
        let answers = answers.transpose()?;
        let name = options.name.clone().or_else(|| std::env::var(NAME_VARIABLE).ok());
        let participant = Participant::join(&options.fleet, name.as_deref().unwrap_or("udp-source"))?;
        let mut producer = Producer::create_on(participant, 0)?;
        producer.check_room(options.max_robots as usize)?;
        let kinds: Vec<_> = robot_type(options).into_iter().collect();
        producer.publish_world(&[], &[], &kinds)?;
        eprintln!(
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

    /// Tells once a second what is going on: always what is wrong, the rest if asked to.
    fn tell(&mut self) {
        if !self.second.has_passed(Instant::now()) {
            return;
        }
        let trouble = self.trouble();
        if self.verbose {
            eprintln!("udp-source: {}", self.summary());
        } else if trouble != self.told {
            eprintln!("udp-source: ignored so far: {}", trouble.text());
        }
        self.told = trouble;
    }

    fn trouble(&self) -> Trouble {
        Trouble {
            faults: self.intake.faults,
            dropped: self.socket.dropped().unwrap_or(0),
            orders_refused: self.orders_refused,
            answers_refused: self.answers.as_ref().map_or(0, |answers| answers.refused),
            receive_errors: self.receive_errors,
        }
    }

    fn summary(&self) -> String {
        let Intake { lines, datagrams, bytes, .. } = self.intake;
        let [standing, driving] = self.intake.robots.standing_and_driving(self.now());
        let answered = self.answers.as_ref().map_or(String::new(), |answers| format!(", {} answered", answers.sent));
        format!(
            "{lines} lines of {} robots received in {datagrams} datagrams ({bytes} bytes){answered} {}; {} frames, \
             {} late; ignored: {}",
            standing + driving,
            self.effort,
            self.ticker.tick,
            self.ticker.late_ticks,
            self.trouble().text()
        )
    }

    fn close(&self, json: bool) {
        eprintln!("udp-source: {}", self.summary());
        if !json {
            return;
        }
        let Intake { lines, datagrams, bytes, faults, .. } = self.intake;
        let json = serde_json::json!({
            "lines": lines, "datagrams": datagrams, "bytes": bytes, "dropped_packets": self.socket.dropped(),
            "receive_buffer_bytes": self.socket.receive_buffer_bytes(),
            "malformed": faults.malformed, "negative_ids": faults.negative_id, "ids_too_large": faults.id_too_large,
            "not_finite": faults.not_finite, "oversized_datagrams": faults.oversized,
            "answers": self.answers.as_ref().map(|answers| answers.sent), "orders_refused": self.orders_refused,
            "frames": self.ticker.tick, "late_ticks": self.ticker.late_ticks,
            "wall_secs": self.effort.wall_secs(), "cpu_secs": self.effort.cpu_secs(),
        });
        println!("{json}");
    }
}

impl Trouble {
    fn text(&self) -> String {
        let mut text = self.faults.to_string();
        for (count, what) in [
            (self.dropped, "packets dropped by the system, of up to 64 datagrams each (the receive buffer was full)"),
            (self.orders_refused, "orders refused (robots are driven by whoever sends the poses)"),
            (self.answers_refused, "answers not sent"),
            (self.receive_errors, "errors of the socket"),
        ] {
            if count > 0 {
                text += &format!(", {count} {what}");
            }
        }
        text.strip_prefix("nothing, ").map_or(text.clone(), str::to_owned)
    }
}

fn robot_type(options: &SourceOptions) -> Option<RobotTypeRecord> {
    Some(RobotTypeRecord {
        name: RobotTypeRecord::padded_name("udp"),
        shape: Shape::Rectangle as u32,
        length: options.robot_length?,
        width: options.robot_width?,
        max_speed: f32::INFINITY,
        max_acceleration: f32::INFINITY,
    })
}

fn rate(text: &str) -> Result<f64, String> {
    let rate = text.parse().ok().filter(|rate| (0.1..=1000.0).contains(rate));
    rate.ok_or_else(|| "give frames per second, 0.1 to 1000".to_owned())
}

fn metres(text: &str) -> Result<f32, String> {
    let metres = text.parse().ok().filter(|metres| (0.001..=1000.0).contains(metres));
    metres.ok_or_else(|| "give metres, 0.001 to 1000".to_owned())
}
