//! `regatta plugin udp-source`: a producer whose robots are where the received lines say.

mod figures;
pub mod intake;
mod producer;
pub mod robots;

use std::ffi::OsString;
use std::time::{Duration, Instant};

use clap::Parser;
use regatta_kit::parse;
use regatta_plugin::column::TYPE;
use regatta_plugin::producer::{LockstepOptions, Session, Speed};
use regatta_plugin::world::RobotTypeRecord;
use regatta_plugin::{
    FleetName, NAME_VARIABLE, Participant, ProducerPorts, Result, Termination, set_verbosity,
};

use crate::line::{LineFormat, Separator};
use crate::options::{self, Form, Offset};
use crate::outlet::Answers;
use crate::packer::MAX_DATAGRAM_BYTES;
use crate::socket::{Buffers, Listen, Socket, resolve_receiver};
use crate::tally::{Effort, EverySecond};
use figures::Trouble;
use intake::Intake;

/// The largest value of `--max-robots`.
const MAX_ROBOTS: i64 = 1 << 24;

/// Publish poses that are received over UDP as a fleet, from lines `id,x,y,theta`
#[derive(Parser, Debug)]
#[command(name = "udp-source", max_term_width = 100)]
struct SourceOptions {
    /// Receive at this address; a port without a host is on the loopback interface
    #[arg(long, value_name = "[HOST:]PORT")]
    listen: Listen,
    /// Name of the fleet
    #[arg(long, value_name = "NAME", default_value_t)]
    fleet: FleetName,
    /// Frames per second
    #[arg(long, value_name = "HZ", default_value = "50", value_parser = rate)]
    rate: f64,
    /// Ignore robots whose id is this number or higher
    #[arg(long, value_name = "N", default_value = "10000")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=MAX_ROBOTS))]
    max_robots: u32,
    /// Length of the robots along their heading, in metres; without it, the robots have no type
    #[arg(long, value_name = "METRES", requires = "robot_width", value_parser = metres)]
    robot_length: Option<f32>,
    /// Width of the robots across their heading, in metres
    #[arg(long, value_name = "METRES", requires = "robot_length", value_parser = metres)]
    robot_width: Option<f32>,
    /// Offset that is added to all positions, in metres
    #[arg(long, value_name = "X,Y", default_value = "0,0", allow_hyphen_values = true)]
    offset: Offset,
    /// Answer each line to this address, as `id x y theta` with the offset added
    #[arg(long, value_name = "HOST:PORT")]
    echo_to: Option<String>,
    #[command(flatten)]
    form: Form,
    /// Ignore datagrams that are longer than this number of bytes
    #[arg(long, value_name = "BYTES", default_value_t = MAX_DATAGRAM_BYTES)]
    #[arg(value_parser = options::datagram_limit)]
    max_datagram: usize,
    /// Remove a robot when no line about it arrives for this many seconds [default: never]
    #[arg(long, value_name = "SECONDS", value_parser = options::seconds)]
    forget: Option<Duration>,
    /// Print the final statistics on standard output as JSON, too
    #[arg(long)]
    json: bool,
    /// Name in `regatta doctor` [default: the program's name]
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// Print statistics once a second, and warnings of the shared-memory library (iceoryx2); -vv
    /// for its complete log
    #[arg(short, long, action = clap::ArgAction::Count)]
    verbose: u8,
}

impl SourceOptions {
    /// Returns the robots' type, if a length and width are given.
    fn robot_type(&self) -> Option<RobotTypeRecord> {
        Some(RobotTypeRecord::new("udp", self.robot_length?, self.robot_width?))
    }
}

fn rate(text: &str) -> Result<f64, String> {
    let rate = text.parse().ok().filter(|rate| (0.1..=1000.0).contains(rate));
    rate.ok_or_else(|| "give a number of frames per second from 0.1 to 1000".to_owned())
}

fn metres(text: &str) -> Result<f32, String> {
    let metres = text.parse().ok().filter(|metres| (0.001..=1000.0).contains(metres));
    metres.ok_or_else(|| "give a number of metres from 0.001 to 1000".to_owned())
}

/// The pause after an error of the socket, so that a persistent error takes no processor time.
const ERROR_PAUSE: Duration = Duration::from_millis(1);

/// Runs the source with a command line, whose first argument is the plugin's name.
///
/// # Errors
/// If an option is invalid, the address can't be listened on, the fleet has a producer already, or
/// shared memory fails.
pub fn run(args: impl IntoIterator<Item: Into<OsString> + Clone>) -> Result {
    let Some(options) = parse::<SourceOptions>(args)? else { return Ok(()) };
    set_verbosity(options.verbose);
    let termination = Termination::watch()?;
    let socket = Socket::listen(&options.listen)?;
    let name = options.name.clone().or_else(|| std::env::var(NAME_VARIABLE).ok());
    let participant = Participant::join(&options.fleet, name.as_deref().unwrap_or("udp-source"))?;
    let ports = ProducerPorts::create_on(participant, 0)?;
    ports.check_room(options.max_robots as usize)?;
    let mut source = Source::new(socket, &options)?;
    let tick_period = Duration::from_secs_f64(1.0 / options.rate);
    let mut session =
        Session::new(ports, tick_period, Speed::default(), LockstepOptions::default());
    let result = session.run(&mut source, &termination);
    source.report_end(&session, options.json);
    result
}

struct Source {
    socket: Socket,
    buffers: Buffers,
    intake: Intake,
    answers: Option<Answers>,
    forget: Option<Duration>,
    robot_type: Option<RobotTypeRecord>,
    /// The number of rows of the column `type` that was published last.
    typed_rows: usize,
    receive_errors: u64,
    started: Instant,
    effort: Effort,
    second: EverySecond,
    reported: Trouble,
    verbose: bool,
}

impl Source {
    fn new(socket: Socket, options: &SourceOptions) -> Result<Self> {
        let unit = options.form.unit();
        let format = LineFormat::new(Separator::Space, options.form.decimals, unit);
        let answers = options
            .echo_to
            .as_ref()
            .map(|to| Answers::open(resolve_receiver(to)?, format, options.form.mtu));
        regatta_plugin::tell!(
            "udp-source: listening on {} with {} bytes of receive buffer, for fleet '{}'",
            socket.local_address()?,
            socket.receive_buffer_bytes(),
            options.fleet
        );
        let now = Instant::now();
        Ok(Self {
            socket,
            buffers: Buffers::default(),
            intake: Intake::new(unit, options.offset.0, options.max_datagram, options.max_robots),
            answers: answers.transpose()?,
            forget: options.forget,
            robot_type: options.robot_type(),
            typed_rows: 0,
            receive_errors: 0,
            started: now,
            effort: Effort::start(),
            second: EverySecond::new(now),
            reported: Trouble::default(),
            verbose: options.verbose > 0,
        })
    }

    /// Time since the start.
    fn now(&self) -> Duration {
        self.started.elapsed()
    }

    /// Receives datagrams until `end`, but at least once.
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

    /// Receives the datagrams that have arrived, and returns whether there were any.
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
            std::thread::sleep(ERROR_PAUSE);
            false
        })
    }

    fn publish_types(&mut self, session: &mut Session, rows: usize) -> Result {
        if self.robot_type.is_some() && rows != self.typed_rows {
            let tick = session.tick();
            session.ports().publish_column(TYPE.name(), tick, &vec![0.0; rows])?;
            self.typed_rows = rows;
        }
        Ok(())
    }
}
