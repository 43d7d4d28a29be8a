//! Fleets in the memory of one process: their ports call each other.

mod claim;

use core::any::{Any, TypeId};
use core::cell::{Cell, RefCell};
use std::collections::{BTreeMap, VecDeque};
use std::rc::{Rc, Weak};

use crate::ports::services::Quality;
use crate::process::join::Participant;
use crate::records::name::{ColumnName, FleetName};
use crate::records::{Header, Record};

pub(crate) use claim::{Claim, Claimed};

/// A fleet whose ports lie in the memory of this process, on one thread: the engine and its
/// plugins run in turn, without shared memory, wake-ups or locks.
///
/// Ports are opened on a [`Participant`] as in a fleet of processes. No other process sees them,
/// unless the fleet is [published](Self::published).
///
/// ```
/// use regatta_plugin::{LocalFleet, ProducerPorts, Result, Subscriber};
///
/// # fn main() -> Result {
/// let fleet = LocalFleet::new("example".parse()?);
/// let producer = ProducerPorts::create_on(fleet.join("producer"), 1)?;
/// let mut frames = Subscriber::open_on(&fleet.join("reader"))?;
/// let mut frame = producer.loan(1)?;
/// frame.columns_mut().x[0] = 2.5;
/// frame.send()?;
/// assert_eq!(frames.latest()?.expect("a frame").x(), [2.5]);
/// # Ok(())
/// # }
/// ```
#[derive(Clone)]
pub struct LocalFleet {
    name: FleetName,
    services: Rc<RefCell<Services>>,
    /// The participants so far.
    members: Rc<Cell<u64>>,
    /// The number of the participant that this belongs to.
    member: u64,
    /// The fleet's participant in shared memory, if it is published.
    #[cfg(feature = "shared-memory")]
    mirror: Option<Rc<Participant>>,
}

/// Services by name and type.
type Services = BTreeMap<(String, TypeId), Rc<dyn Any>>;

impl LocalFleet {
    /// Creates a fleet that no other process sees.
    pub fn new(name: FleetName) -> Self {
        Self {
            name,
            services: Rc::default(),
            members: Rc::default(),
            member: 0,
            #[cfg(feature = "shared-memory")]
            mirror: None,
        }
    }

    /// Creates a fleet whose frames, events and columns go to shared memory, too, where processes
    /// can watch them and ask for its status. It never waits for them, and takes no commands from
    /// them.
    ///
    /// # Errors
    /// [`OpenError`](crate::OpenError) if this process may not use shared memory. A second
    /// producer of the fleet is noticed when the ports are opened.
    #[cfg(feature = "shared-memory")]
    pub fn published(name: FleetName) -> Result<Self, crate::OpenError> {
        let mirror = Participant::join(&name, "engine")?;
        Ok(Self { mirror: Some(Rc::new(mirror)), ..Self::new(name) })
    }

    /// Joins the fleet under a name.
    pub fn join(&self, name: &str) -> Participant {
        self.members.set(self.members.get() + 1);
        Participant::of_local(Self { member: self.members.get(), ..self.clone() }, name)
    }

    /// The name of the fleet.
    pub fn name(&self) -> &FleetName {
        &self.name
    }

    /// The fleet's participant in shared memory, if it is published.
    #[cfg(feature = "shared-memory")]
    pub(crate) fn mirror(&self) -> Option<&Participant> {
        self.mirror.as_deref()
    }

    /// Returns the columns that have a port, sorted.
    pub(crate) fn column_names(&self) -> Vec<ColumnName> {
        let services = self.services.borrow();
        let names = services.keys().filter_map(|(name, _)| name.strip_prefix("columns/"));
        names.filter_map(|name| name.parse().ok()).collect()
    }

    /// Returns a service, which is made with its first port.
    fn service<S: Default + 'static>(&self, name: &str) -> Rc<S> {
        let key = (name.to_owned(), TypeId::of::<S>());
        let mut services = self.services.borrow_mut();
        let service = Rc::clone(services.entry(key).or_insert_with(|| Rc::new(S::default())));
        // The key has the type.
        service.downcast().unwrap_or_default()
    }
}

impl core::fmt::Debug for LocalFleet {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("LocalFleet").field("name", &self.name).finish_non_exhaustive()
    }
}

/// The most buffers that a service keeps for its next samples.
const MAX_FREE: usize = 4;

/// Buffers of old samples, for the next ones.
type Free<T> = Rc<RefCell<Vec<Vec<T>>>>;

/// A sample: a header, and a slice of records.
pub(crate) struct Sample<T, H> {
    pub(super) header: H,
    pub(super) records: Vec<T>,
    /// The number of the participant that sends it.
    pub(super) sender: u64,
    free: Free<T>,
}

impl<T, H> Drop for Sample<T, H> {
    fn drop(&mut self) {
        let mut free = self.free.borrow_mut();
        if free.len() < MAX_FREE {
            free.push(core::mem::take(&mut self.records));
        }
    }
}

/// The samples that wait for a subscriber.
struct Inbox<T, H> {
    samples: RefCell<VecDeque<Rc<Sample<T, H>>>>,
    capacity: usize,
    overflows: bool,
}

impl<T, H> Inbox<T, H> {
    /// Adds a sample. Returns `false` if there is no room for it.
    fn deliver(&self, sample: &Rc<Sample<T, H>>) -> bool {
        let mut samples = self.samples.borrow_mut();
        if samples.len() >= self.capacity {
            if !self.overflows {
                return false;
            }
            samples.pop_front();
        }
        samples.push_back(Rc::clone(sample));
        true
    }
}

/// A publish-subscribe service.
struct Topic<T, H> {
    inboxes: RefCell<Vec<Weak<Inbox<T, H>>>>,
    publishers: Cell<usize>,
    /// The newest sample, for subscribers that join later, if the service keeps it.
    newest: RefCell<Option<Rc<Sample<T, H>>>>,
    free: Free<T>,
}

impl<T, H> Default for Topic<T, H> {
    fn default() -> Self {
        Self {
            inboxes: RefCell::default(),
            publishers: Cell::default(),
            newest: RefCell::default(),
            free: Rc::default(),
        }
    }
}

impl<T: Record, H: Header> Topic<T, H> {
    fn loan(&self, len: usize, sender: u64) -> Sample<T, H> {
        let mut records = self.free.borrow_mut().pop().unwrap_or_default();
        records.resize(len, T::zeroed());
        Sample { header: H::default(), records, sender, free: Rc::clone(&self.free) }
    }

    /// Delivers a sample, and returns the number of subscribers that have it.
    fn send(&self, sample: Sample<T, H>, keeps_newest: bool) -> usize {
        let sample = Rc::new(sample);
        let mut delivered = 0;
        self.inboxes.borrow_mut().retain(|inbox| {
            let Some(inbox) = inbox.upgrade() else { return false };
            delivered += usize::from(inbox.deliver(&sample));
            true
        });
        if keeps_newest {
            *self.newest.borrow_mut() = Some(sample);
        }
        delivered
    }
}

/// The sending end of a service.
pub(crate) struct Publisher<T: 'static, H: 'static> {
    topic: Rc<Topic<T, H>>,
    keeps_newest: bool,
    member: u64,
}

impl<T: Record, H: Header> Publisher<T, H> {
    /// Opens the sending end of a service; `None` if all its places are taken.
    pub(super) fn open(fleet: &LocalFleet, name: &str, quality: &Quality) -> Option<Self> {
        let topic: Rc<Topic<T, H>> = fleet.service(name);
        if topic.publishers.get() >= quality.publishers {
            return None;
        }
        topic.publishers.set(topic.publishers.get() + 1);
        Some(Self { topic, keeps_newest: quality.history > 0, member: fleet.member })
    }

    /// Returns a sample to be written. The values of its records are left over from an older one.
    pub(super) fn loan(&self, len: usize) -> Sample<T, H> {
        self.topic.loan(len, self.member)
    }

    /// Sends a sample, and returns the number of subscribers that have it.
    pub(super) fn send(&self, sample: Sample<T, H>) -> usize {
        self.topic.send(sample, self.keeps_newest)
    }

    /// The number of subscribers.
    pub(super) fn readers(&self) -> usize {
        self.topic.inboxes.borrow().iter().filter(|inbox| inbox.strong_count() > 0).count()
    }
}

impl<T, H> Drop for Publisher<T, H> {
    fn drop(&mut self) {
        self.topic.publishers.set(self.topic.publishers.get() - 1);
        self.topic.newest.borrow_mut().take();
    }
}

/// The receiving end of a service.
pub(crate) struct Subscriber<T: 'static, H: 'static> {
    topic: Rc<Topic<T, H>>,
    inbox: Rc<Inbox<T, H>>,
}

impl<T: Record, H: Header> Subscriber<T, H> {
    /// Opens the receiving end of a service; the last `buffer` samples wait to be taken.
    pub(super) fn open(fleet: &LocalFleet, name: &str, quality: &Quality, buffer: usize) -> Self {
        let topic: Rc<Topic<T, H>> = fleet.service(name);
        let inbox = Rc::new(Inbox {
            samples: RefCell::new(topic.newest.borrow().iter().cloned().collect()),
            capacity: buffer,
            overflows: quality.overflows,
        });
        topic.inboxes.borrow_mut().push(Rc::downgrade(&inbox));
        Self { topic, inbox }
    }

    pub(super) fn receive(&self) -> Option<Rc<Sample<T, H>>> {
        self.inbox.samples.borrow_mut().pop_front()
    }

    pub(super) fn has_samples(&self) -> bool {
        !self.inbox.samples.borrow().is_empty()
    }

    pub(super) fn has_publisher(&self) -> bool {
        self.topic.publishers.get() > 0
    }
}

/// A request that waits for its answer.
pub(crate) struct Request<Q, A> {
    pub(super) payload: Q,
    answer: Rc<Cell<Option<A>>>,
}

impl<Q, A> Request<Q, A> {
    pub(super) fn answer(&self, answer: A) {
        self.answer.set(Some(answer));
    }

    /// Whether the client still waits.
    pub(super) fn is_connected(&self) -> bool {
        Rc::strong_count(&self.answer) > 1
    }
}

/// A request-response service.
struct Exchange<Q, A> {
    waiting: RefCell<VecDeque<Request<Q, A>>>,
    has_server: Cell<bool>,
}

impl<Q, A> Default for Exchange<Q, A> {
    fn default() -> Self {
        Self { waiting: RefCell::default(), has_server: Cell::default() }
    }
}

/// The answer to a request, once it has come.
pub(crate) struct Asked<A>(Rc<Cell<Option<A>>>);

impl<A> Asked<A> {
    pub(super) fn take(&self) -> Option<A> {
        self.0.take()
    }
}

/// A client of the one server of a service.
pub(crate) struct Client<Q: 'static, A: 'static>(Rc<Exchange<Q, A>>);

impl<Q: Record, A: Record> Client<Q, A> {
    pub(super) fn open(fleet: &LocalFleet, name: &str) -> Self {
        Self(fleet.service(name))
    }

    pub(super) fn has_server(&self) -> bool {
        self.0.has_server.get()
    }

    pub(super) fn send(&self, payload: Q) -> Asked<A> {
        let answer = Rc::default();
        let request = Request { payload, answer: Rc::clone(&answer) };
        self.0.waiting.borrow_mut().push_back(request);
        Asked(answer)
    }
}

/// The one server of a service.
pub(crate) struct Server<Q: 'static, A: 'static>(Rc<Exchange<Q, A>>);

impl<Q: Record, A: Record> Server<Q, A> {
    /// Opens the server of a service; `None` if it has one.
    pub(super) fn open(fleet: &LocalFleet, name: &str) -> Option<Self> {
        let exchange: Rc<Exchange<Q, A>> = fleet.service(name);
        if exchange.has_server.replace(true) {
            return None;
        }
        Some(Self(exchange))
    }

    pub(super) fn take(&self) -> Option<Request<Q, A>> {
        self.0.waiting.borrow_mut().pop_front()
    }
}

impl<Q, A> Drop for Server<Q, A> {
    fn drop(&mut self) {
        self.0.has_server.set(false);
        self.0.waiting.borrow_mut().clear();
    }
}
