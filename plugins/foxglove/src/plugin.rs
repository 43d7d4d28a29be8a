//! The plugin: encodes what clients read.

use std::ffi::OsString;
use std::sync::Arc;
use std::time::{Duration, Instant};

use prost::Message;
use regatta_kit::private;
use regatta_messages::{encode, scene};
use regatta_plugin::column::ACTIVITY;
use regatta_plugin::frame::FrameHeader;
use regatta_plugin::{
    ColumnReader, ContactEventReader, ContactReader, Frame, Participant, Plugin, Rate, Result,
    Subscriber, WorkReader, World, WorldReader, tell,
};

use crate::channel::{Channel, ChannelSet};
use crate::desk::Desk;
use crate::figures::FigureMaker;
use crate::hub::Hub;
use crate::options::Cli;
use crate::server::{Gate, Server};
use crate::{journal, layout};

/// The time between two messages with figures.
const FIGURES_EVERY: Duration = Duration::from_millis(500);

/// Runs the plugin with a command line, whose first argument is the name of the program.
///
/// # Errors
/// Fails if an option is invalid, the address can't be listened on, or as [`regatta_plugin::run`]
/// does.
pub fn run_from<A: Into<OsString> + Clone>(args: impl IntoIterator<Item = A>) -> Result {
    regatta_kit::run_from(args, |cli: Cli| match &cli.layout {
        Some(path) => layout::write(path, &cli.options.fleet),
        None => cli.options.clone().run(Foxglove::open(&cli)?, "foxglove"),
    })
}

/// The plugin.
struct Foxglove {
    hub: Arc<Hub>,
    /// Held while it runs.
    _server: Server,
    sources: Option<Sources>,
    figures: FigureMaker,
    figures_sent: Instant,
    newest: FrameHeader,
}

/// The ports that the plugin reads, besides the frames that it is called with.
struct Sources {
    /// For clients that join a paused fleet.
    frames: Subscriber,
    worlds: WorldReader,
    contacts: ContactReader,
    contact_events: ContactEventReader,
    activities: ColumnReader,
    work: WorkReader,
}

impl Sources {
    fn open(fleet: &Participant) -> Result<Self> {
        Ok(Self {
            frames: Subscriber::open_on(fleet)?,
            worlds: WorldReader::open_on(fleet)?,
            contacts: ContactReader::open_on(fleet)?,
            contact_events: ContactEventReader::open_on(fleet)?,
            activities: ColumnReader::open_on(fleet, ACTIVITY.name())?,
            work: WorkReader::open_on(fleet)?,
        })
    }
}

impl Foxglove {
    fn open(cli: &Cli) -> Result<Self> {
        let fleet = cli.options.fleet.clone();
        let hub = Arc::new(Hub::new(fleet.clone(), !cli.read_only));
        let token = cli.token_file.as_deref().map(private::read_token).transpose()?;
        let has_token = token.is_some();
        let is_loopback = cli.listen.ip().is_loopback();
        let gate = Gate { origins: cli.allow_origin.clone(), token, is_loopback };
        let server = Server::start(cli.listen, gate, Arc::clone(&hub), Desk::start(fleet)?)?;
        tell_address(cli, &server, has_token);
        Ok(Self {
            hub,
            _server: server,
            sources: None,
            figures: FigureMaker::default(),
            figures_sent: Instant::now(),
            newest: FrameHeader::default(),
        })
    }

    /// Sends the channels of a frame that somebody reads.
    fn send_frame(&self, frame: &Frame<'_>, channels: ChannelSet) {
        let nanos = frame.header().sim_time_nanos;
        for channel in Channel::OF_FRAMES.into_iter().filter(|channel| channels.has(*channel)) {
            self.hub.publish(channel, nanos, encode_frame(channel, frame));
        }
    }

    /// Sends contacts, if there are new ones.
    fn send_contacts(&mut self, channels: ChannelSet) -> Result {
        let Some(sources) = &mut self.sources else { return Ok(()) };
        if let Some(contacts) = sources.contacts.latest()? {
            let nanos = contacts.header.sim_time_nanos;
            for channel in Channel::OF_CONTACTS.into_iter().filter(|of| channels.has(*of)) {
                self.hub.publish(channel, nanos, encode_contacts(channel, &contacts));
            }
        }
        let hub = &self.hub;
        let has_readers = channels.has(Channel::Log);
        sources.contact_events.take(|events| {
            if has_readers {
                journal::tell_contacts(hub, events.records);
            }
            Ok(())
        })
    }

    /// Sends figures, if they are due.
    fn send_figures(&mut self, frame: &Frame<'_>, channels: ChannelSet) -> Result {
        if !channels.has(Channel::Figures) || self.figures_sent.elapsed() < FIGURES_EVERY {
            return Ok(());
        }
        let Some(sources) = &mut self.sources else { return Ok(()) };
        sources.work.take()?;
        let contacts = sources.contacts.current();
        let contacts = contacts.as_ref().map(|contacts| contacts.header);
        let work = sources.work.of_run(frame.run_id());
        let activities = sources.activities.newest_of_run(frame.run_id())?;
        let message = self.figures.encode(frame, activities, contacts, work);
        self.hub.publish(Channel::Figures, frame.header().sim_time_nanos, message);
        self.figures_sent = Instant::now();
        Ok(())
    }

    /// Sends the present state to those who have subscribed since it was sent.
    fn feed(&mut self, hungry: ChannelSet) -> Result {
        let Some(sources) = &mut self.sources else { return Ok(()) };
        let nanos = self.newest.sim_time_nanos;
        if !hungry.and(ChannelSet::of(&Channel::OF_WORLDS)).is_empty() {
            sources.worlds.latest()?;
            if let Some(world) = sources.worlds.current()? {
                for channel in Channel::OF_WORLDS.into_iter().filter(|of| hungry.has(*of)) {
                    self.hub.feed(channel, nanos, encode_world(channel, &world, nanos));
                }
            }
        }
        if let Some(contacts) = sources.contacts.current() {
            for channel in Channel::OF_CONTACTS.into_iter().filter(|of| hungry.has(*of)) {
                self.hub.feed(channel, nanos, encode_contacts(channel, &contacts));
            }
        }
        Ok(())
    }

    /// Sends the last frame to those who have subscribed since, while none comes.
    fn feed_frame(&mut self, hungry: ChannelSet) -> Result {
        let Some(sources) = &mut self.sources else { return Ok(()) };
        if hungry.and(ChannelSet::of(&Channel::OF_FRAMES)).is_empty() {
            return Ok(());
        }
        sources.frames.latest()?;
        if let Some(frame) = sources.frames.current()? {
            let nanos = frame.header().sim_time_nanos;
            for channel in Channel::OF_FRAMES.into_iter().filter(|of| hungry.has(*of)) {
                self.hub.feed(channel, nanos, encode_frame(channel, &frame));
            }
        }
        Ok(())
    }
}

/// Says where the server listens, and who can do what.
fn tell_address(cli: &Cli, server: &Server, has_token: bool) {
    let address = server.address();
    let can = if cli.read_only { "read" } else { "read and steer" };
    let who = match (has_token, address.ip().is_loopback()) {
        (true, _) => "anyone who has the token".to_owned(),
        (false, true) => "there are no credentials: any user of this machine".to_owned(),
        (false, false) => "there are no credentials: anyone who reaches this address".to_owned(),
    };
    let query = if has_token { "/?token=TOKEN" } else { "" };
    let fleet = &cli.options.fleet;
    tell!("foxglove: fleet '{fleet}' at ws://{address}{query}; {who} can {can} it");
}

fn encode_frame(channel: Channel, frame: &Frame<'_>) -> Vec<u8> {
    let nanos = frame.header().sim_time_nanos;
    match channel {
        Channel::Poses => scene::poses(frame, nanos),
        Channel::Robots => scene::robots(frame, nanos),
        _ => encode::frame(frame),
    }
}

fn encode_world(channel: Channel, world: &World<'_>, nanos: u64) -> Vec<u8> {
    match channel {
        Channel::Graph => scene::graph(world, nanos),
        Channel::GraphPoints => scene::graph_points(world, nanos),
        _ => encode::world(world),
    }
}

fn encode_contacts(channel: Channel, contacts: &regatta_plugin::Contacts<'_>) -> Vec<u8> {
    match channel {
        Channel::ContactMarkers => {
            scene::contact_markers(contacts.pairs, contacts.header.sim_time_nanos)
        }
        _ => encode::contacts(contacts.header, contacts.pairs, 0).encode_to_vec(),
    }
}

impl Plugin for Foxglove {
    fn on_start(&mut self, fleet: &Participant) -> Result {
        self.sources = Some(Sources::open(fleet)?);
        Ok(())
    }

    fn on_world(&mut self, _world: &World<'_>) -> Result {
        self.hub.renew(&Channel::OF_WORLDS);
        Ok(())
    }

    fn on_frame(&mut self, frame: &Frame<'_>) -> Result {
        if frame.header().is_warm_up() {
            return Ok(());
        }
        let before = std::mem::replace(&mut self.newest, *frame.header());
        self.hub.take_header(frame.header());
        if let Some(sources) = &mut self.sources {
            // Held for those who came while no frame did.
            sources.frames.release();
        }
        let (wanted, hungry) = self.hub.wanted();
        if wanted.has(Channel::Log) {
            journal::tell_clock(&self.hub, &before, &self.newest);
        }
        self.feed(hungry)?;
        self.send_frame(frame, wanted);
        self.send_contacts(wanted)?;
        self.send_figures(frame, wanted)
    }

    fn on_idle(&mut self, _has_producer: bool) -> Result {
        let (wanted, hungry) = self.hub.wanted();
        self.feed(hungry)?;
        self.feed_frame(hungry)?;
        self.send_contacts(wanted)
    }

    fn rate(&self) -> Rate {
        Rate::PerSecond(20.0)
    }
}
