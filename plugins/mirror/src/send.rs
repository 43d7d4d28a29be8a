//! `regatta mirror send`: a reader of a fleet, which offers it to other hosts.

mod columns;
mod control;
mod events;

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use regatta_plugin::{Participant, ReadError, Result, Subscriber, Termination, WorldReader};
use zenoh::Wait;
use zenoh::handlers::{FifoChannel, FifoChannelHandler};
use zenoh::query::{Query, Queryable};

use crate::link::{DEFAULT_LISTEN, Link, LinkError, Outlet, declare_error, key};
use crate::options::SendArgs;
use crate::wire::{Encoding, encode_frame, encode_world};
use columns::Columns;

/// The longest wait for a frame, between two looks at requests of peers.
const POLL: Duration = Duration::from_millis(10);
/// The number of requests that wait; more hold up their connection.
const QUEUE: usize = 16;

/// Offers a fleet until Ctrl-C.
pub fn run(args: &SendArgs) -> Result {
    let termination = Termination::watch()?;
    let link = Link::open(&args.link, Some(DEFAULT_LISTEN))?;
    tell(args, &link);
    let mut sender = Sender::open(args, &link)?;
    let stop = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let threads = start_threads(scope, args, &link, &stop);
        let outcome = threads.and_then(|()| {
            while !termination.requested() {
                sender.advance()?;
            }
            Ok(())
        });
        stop.store(true, Ordering::Relaxed);
        outcome
    })
}

/// Tells where it listens, and who may connect.
fn tell(args: &SendArgs, link: &Link) {
    let steering = if args.read_only { "see" } else { "see and steer" };
    let access = match link.asks_credentials {
        true => "peers must show credentials".to_owned(),
        false => format!(
            "without credentials: anyone who reaches the address, including other users of this \
             host, can {steering} the fleet; --config sets passwords or certificates"
        ),
    };
    regatta_plugin::tell!(
        "mirror: fleet '{}', listening on {}, connecting to {:?}; {access}",
        args.fleet,
        link.listens,
        args.link.connect
    );
}

fn start_threads<'scope>(
    scope: &'scope std::thread::Scope<'scope, '_>,
    args: &'scope SendArgs,
    link: &Link,
    stop: &'scope AtomicBool,
) -> Result {
    let outlet = Outlet::blocking(&link.session, key(&args.fleet, "events"))?;
    scope.spawn(move || events::send(&args.fleet, &outlet, stop));
    if args.read_only {
        return Ok(());
    }
    let requests = queryable(link, key(&args.fleet, "control"))?;
    scope.spawn(move || control::serve(&args.fleet, &requests, stop));
    let name = key(&args.fleet, "commands");
    let commands = link
        .session
        .declare_subscriber(name.clone())
        .with(FifoChannel::new(QUEUE))
        .wait()
        .map_err(|error| declare_error(&name, &error))?;
    scope.spawn(move || control::take_commands(&args.fleet, &commands, stop));
    Ok(())
}

/// Requests of peers for a key.
pub type Requests = Queryable<FifoChannelHandler<Query>>;

fn queryable(link: &Link, name: String) -> Result<Requests, LinkError> {
    link.session
        .declare_queryable(name.clone())
        .with(FifoChannel::new(QUEUE))
        .wait()
        .map_err(|error| declare_error(&name, &error))
}

/// Sends frames, and answers requests for the world and for columns.
struct Sender {
    frames: Subscriber,
    worlds: WorldReader,
    outlets: [(Encoding, Outlet); 2],
    world_requests: Requests,
    world_key: String,
    columns: Columns,
    /// The shortest time between two frames.
    period: Duration,
    /// The time at which a frame is due.
    due: Instant,
}

impl Sender {
    fn open(args: &SendArgs, link: &Link) -> Result<Self> {
        let participant = Participant::join(&args.fleet, "mirror-send")?;
        let [raw, q16] = Encoding::ALL.map(|encoding| {
            let name = key(&args.fleet, &format!("frames/{}", encoding.name()));
            Outlet::dropping(&link.session, name).map(|outlet| (encoding, outlet))
        });
        let world_key = key(&args.fleet, "world");
        Ok(Self {
            frames: Subscriber::open_on(&participant)?,
            worlds: WorldReader::open_on(&participant)?,
            outlets: [raw?, q16?],
            world_requests: queryable(link, world_key.clone())?,
            world_key,
            columns: Columns::open(participant, link)?,
            period: Duration::from_secs_f64(args.rate.map_or(0.0, |rate| 1.0 / rate)),
            due: Instant::now(),
        })
    }

    /// Waits for a frame and sends it, and answers requests.
    fn advance(&mut self) -> Result {
        self.answer_world()?;
        self.columns.advance()?;
        let left = self.due.saturating_duration_since(Instant::now());
        if !left.is_zero() {
            std::thread::sleep(left.min(POLL));
            return Ok(());
        }
        self.send_frame()?;
        Ok(())
    }

    fn send_frame(&mut self) -> Result<(), ReadError> {
        if self.frames.wait(POLL)?.is_none() {
            return Ok(());
        }
        let Some(frame) = self.frames.current()? else { return Ok(()) };
        for (encoding, outlet) in &self.outlets {
            if outlet.is_wanted() {
                outlet.put(encode_frame(&frame, *encoding));
            }
        }
        self.frames.release();
        if !self.period.is_zero() {
            // Frames that were missed aren't made up for.
            self.due = (self.due + self.period).max(Instant::now() - self.period);
        }
        Ok(())
    }

    fn answer_world(&mut self) -> Result {
        while let Ok(Some(query)) = self.world_requests.try_recv() {
            self.worlds.latest()?;
            if let Some(world) = self.worlds.current()? {
                // A peer that has gone away needs no answer.
                let _ = query.reply(self.world_key.as_str(), encode_world(&world)).wait();
            }
        }
        Ok(())
    }
}
