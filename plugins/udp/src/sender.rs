//! `regatta plugin udp`: sends a fleet's poses as lines in datagrams.

use std::ffi::OsString;
use std::time::{Duration, Instant};

use clap::Parser;
use regatta_plugin::frame::RobotState;
use regatta_plugin::{Frame, Participant, Plugin, Rate, Result};

use crate::echo::EchoRules;
use crate::echo_listener::EchoListener;
use crate::line::{AngleUnit, LineFormat, PoseLine, Separator};
use crate::options::{self, Form, Offset, RobotRange};
use crate::outlet::{Outlet, SendTotals};
use crate::packer::Packer;
use crate::socket::{Listen, Socket, resolve_receiver};
use crate::tally::{Effort, EverySecond};

/// Send poses over UDP, as lines `id,x,y,theta`
#[derive(Parser, Debug)]
#[command(name = "udp", max_term_width = 100)]
#[command(mut_arg("rate", |rate| rate.help("Frames per second to send, or 'all' [default: 50]")))]
#[command(mut_arg("verbose", |verbose| verbose.help(
    "Print statistics once a second, and warnings of the shared-memory library (iceoryx2); -vv for \
     its complete log"
)))]
struct SenderOptions {
    /// Send to this address
    #[arg(long, value_name = "HOST:PORT")]
    to: String,
    /// Send only these robots: the first, and the one after the last
    #[arg(long, value_name = "A..B", default_value = "..")]
    robots: RobotRange,
    #[command(flatten)]
    form: Form,
    /// Fraction of the time between frames over which a frame's datagrams are spread, 0 to 1
    #[arg(long, value_name = "PART", default_value = "0.5")]
    pace: f64,
    /// Receive answers `id x y theta` at this address, and compare them with the sent lines
    #[arg(long, value_name = "[HOST:]PORT")]
    listen: Option<Listen>,
    /// Offset that the other program adds to positions before it answers, in metres
    #[arg(
        long,
        value_name = "X,Y",
        default_value = "0,0",
        allow_hyphen_values = true,
        requires = "listen"
    )]
    echo_offset: Offset,
    /// Decimals of the answers [default: those of the sent lines]
    #[arg(long, value_name = "N", value_parser = options::decimals, requires = "listen")]
    echo_decimals: Option<usize>,
    /// Seconds within which a line must be answered
    #[arg(long, value_name = "SECONDS", default_value = "1", requires = "listen")]
    #[arg(value_parser = options::seconds)]
    echo_deadline: Duration,
    /// Print the final statistics on standard output as JSON, too
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    plugin: regatta_plugin::Options,
}

/// Runs the plugin with a command line, whose first argument is the plugin's name.
///
/// # Errors
/// Returns an error if an option is invalid, a socket can't be opened, or the fleet can't be read.
pub fn run(args: impl IntoIterator<Item: Into<OsString> + Clone>) -> Result {
    let Some(options) = regatta_kit::parse::<SenderOptions>(args)? else { return Ok(()) };
    let sender = Sender::open(&options)?;
    options.plugin.run(sender, "udp")
}

/// The plugin.
#[derive(Debug)]
struct Sender {
    robots: RobotRange,
    unit: AngleUnit,
    packer: Packer,
    outlet: Outlet,
    echo: Option<EchoListener>,
    effort: Effort,
    second: EverySecond,
    verbose: bool,
    json: bool,
}

impl Sender {
    fn open(options: &SenderOptions) -> Result<Self> {
        let unit = options.form.unit();
        let format = LineFormat::new(Separator::Comma, options.form.decimals, unit);
        let to = resolve_receiver(&options.to)?;
        let verbose = options.plugin.verbose > 0;
        let echo = options.listen.as_ref().map(|listen| -> Result<_> {
            let decimals = options.echo_decimals.unwrap_or(crate::fixed::MAX_DECIMALS);
            let rules = EchoRules::new(
                format,
                decimals,
                unit,
                options.echo_offset.0,
                options.echo_deadline,
            );
            let socket = Socket::listen(listen)?;
            regatta_plugin::tell!("udp: listening for answers on {}", socket.local_address()?);
            Ok(EchoListener::start(socket, rules, verbose))
        });
        Ok(Self {
            robots: options.robots.clone(),
            unit,
            packer: Packer::new(format, options.form.mtu),
            outlet: Outlet::open("udp", to, options.pace)?,
            echo: echo.transpose()?,
            effort: Effort::start(),
            second: EverySecond::new(Instant::now()),
            verbose,
            json: options.json,
        })
    }

    /// Returns a frame's lines: one for each selected robot that isn't absent.
    fn lines<'frame>(&self, frame: &Frame<'frame>) -> impl Iterator<Item = PoseLine> + use<'frame> {
        let end = self.robots.0.end.min(frame.len() as u32);
        let (unit, columns) = (self.unit, frame.columns());
        (self.robots.0.start.min(end)..end).filter_map(move |id| {
            let row = id as usize;
            let is_present = columns.state[row] != RobotState::Absent as u8;
            is_present.then(|| PoseLine {
                id,
                x: columns.x[row],
                y: columns.y[row],
                theta: unit.from_radians(columns.theta[row]),
            })
        })
    }

    /// Prints statistics and errors, at most once a second.
    fn report(&mut self, now: Instant) {
        if !self.second.has_passed(now) {
            return;
        }
        if self.verbose {
            regatta_plugin::tell!("udp: {}", self.summary());
        }
        if let Some(error) = self.outlet.failure.take() {
            regatta_plugin::tell!(
                "udp: can't send all lines to {}: {}",
                self.outlet.to,
                describe(&error)
            );
        }
    }

    fn summary(&self) -> String {
        let SendTotals { frames, lines, datagrams, bytes, refused, not_finite } = self.outlet.sent;
        let mut text = format!(
            "{lines} lines of {frames} frames sent to {} in {datagrams} datagrams ({bytes} bytes) \
             {}",
            self.outlet.to, self.effort
        );
        for (count, name) in [(refused, "lines not sent"), (not_finite, "poses not finite")] {
            if count > 0 {
                text += &format!(", {count} {name}");
            }
        }
        text
    }

    fn json(&self) -> serde_json::Value {
        let SendTotals { frames, lines, datagrams, bytes, refused, not_finite } = self.outlet.sent;
        let echo = self.echo.as_ref().map(|echo| {
            let totals = echo.with(|check| check.totals());
            serde_json::json!({
                "sent": totals.sent, "answered": totals.answered, "missing": totals.missing,
                "late": totals.late, "differing": totals.differing, "unchecked": totals.unchecked,
                "open": totals.open(), "repeated": totals.repeated, "unknown": totals.unknown,
            })
        });
        serde_json::json!({
            "frames": frames, "lines": lines, "datagrams": datagrams, "bytes": bytes,
            "lines_not_sent": refused, "poses_not_finite": not_finite,
            "wall_secs": self.effort.wall_secs(), "cpu_secs": self.effort.cpu_secs(), "echo": echo,
        })
    }
}

impl Plugin for Sender {
    fn on_start(&mut self, _: &Participant) -> Result {
        self.effort = Effort::start();
        Ok(())
    }

    fn on_frame(&mut self, frame: &Frame) -> Result {
        if frame.header().is_warm_up() {
            return Ok(());
        }
        let now = Instant::now();
        if let Some(echo) = &self.echo {
            let mut sent = echo.with(|check| check.frame(self.robots.0.start, now));
            for line in self.lines(frame).filter(PoseLine::is_finite) {
                sent.push(&line);
            }
            echo.with(|check| check.note(sent));
        }
        self.outlet.start_frame(now, frame.header());
        for line in self.lines(frame) {
            if line.is_finite() {
                self.packer.push(&line, |batch| self.outlet.send(batch));
            } else {
                self.outlet.sent.not_finite += 1;
            }
        }
        self.packer.flush(|batch| self.outlet.send(batch));
        self.outlet.sent.frames += 1;
        self.report(now);
        Ok(())
    }

    fn on_stop(&mut self) -> Result {
        if let Some(echo) = &mut self.echo {
            echo.finish();
            regatta_plugin::tell!("udp: {}", echo.summary());
        }
        regatta_plugin::tell!("udp: {}", self.summary());
        if self.json {
            println!("{}", self.json());
        }
        Ok(())
    }

    fn rate(&self) -> Rate {
        Rate::PerSecond(50.0)
    }
}

/// Returns the text of an error of sending, with advice for datagrams that are too long.
fn describe(error: &std::io::Error) -> String {
    let too_long = quinn_udp::is_msg_size_err(error);
    if too_long { format!("{error}; lower --mtu") } else { error.to_string() }
}
