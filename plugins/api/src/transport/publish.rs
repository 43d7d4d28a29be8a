//! The ends of a publish-subscribe service, in either home.

use std::rc::Rc;

use super::claim::Member;
use super::local::{self, LocalFleet};
#[cfg(feature = "shared-memory")]
use super::shared;
use crate::ports::error::{OpenError, PublishError, ReadError};
use crate::ports::services::SliceService;
use crate::process::join::{Home, Participant};
use crate::records::{Header, Record};

/// The sending end of a publish-subscribe service. Never waits for a receiver.
pub(crate) enum Publisher<T: Record, H: Header> {
    #[cfg(feature = "shared-memory")]
    Shared(shared::Publisher<T, H>),
    Local(LocalPublisher<T, H>),
}

/// The sending end of a service of a local fleet.
#[derive(Clone)]
pub(crate) struct LocalPublisher<T: Record, H: Header> {
    port: Rc<local::Publisher<T, H>>,
    /// The sending end in shared memory, if the fleet is published.
    #[cfg(feature = "shared-memory")]
    mirror: Option<Rc<shared::Publisher<T, H>>>,
}

impl<T: Record, H: Header> Publisher<T, H> {
    /// Opens one of several sending ends of a service. The first segment of shared memory holds
    /// slices of `first_len` records; longer ones make it grow.
    pub(crate) fn open(
        service: &SliceService<T, H>,
        participant: &Participant,
        first_len: usize,
    ) -> Result<Self, OpenError> {
        match participant.home() {
            #[cfg(feature = "shared-memory")]
            Home::Shared(_) => {
                shared::Publisher::open(service, participant, first_len).map(Self::Shared)
            }
            Home::Local(fleet) => {
                let port = local::Publisher::open(fleet, service.name, &service.quality)
                    .ok_or_else(|| full(service.name, service.quality.publishers, fleet))?;
                Ok(Self::Local(LocalPublisher {
                    port: Rc::new(port),
                    // Commands go to the local producer alone.
                    #[cfg(feature = "shared-memory")]
                    mirror: match fleet.mirror().filter(|_| service.quality.overflows) {
                        Some(mirror) => {
                            Some(Rc::new(shared::Publisher::open(service, mirror, first_len)?))
                        }
                        None => None,
                    },
                }))
            }
        }
    }

    /// Opens the one sending end of the service with a name. `taken` makes the error if there is
    /// one, given its owner.
    pub(crate) fn open_only(
        service: &SliceService<T, H>,
        name: &str,
        participant: &Participant,
        first_len: usize,
        taken: impl FnOnce(String) -> OpenError,
    ) -> Result<Self, OpenError> {
        match participant.home() {
            #[cfg(feature = "shared-memory")]
            Home::Shared(_) => {
                shared::Publisher::open_only(service, name, participant, first_len, taken)
                    .map(Self::Shared)
            }
            Home::Local(fleet) => {
                let Some(port) = local::Publisher::open(fleet, name, &service.quality) else {
                    return Err(taken(THIS_PROCESS.to_owned()));
                };
                Ok(Self::Local(LocalPublisher {
                    port: Rc::new(port),
                    #[cfg(feature = "shared-memory")]
                    mirror: match fleet.mirror() {
                        Some(mirror) => Some(Rc::new(shared::Publisher::open_only(
                            service, name, mirror, first_len, taken,
                        )?)),
                        None => None,
                    },
                }))
            }
        }
    }

    /// Loans the memory of a header and `len` records, to be written in place. Their values are
    /// left over from an older sample; the header is zero.
    pub(crate) fn loan(&self, len: usize) -> Result<Loan<T, H>, PublishError> {
        match self {
            #[cfg(feature = "shared-memory")]
            Self::Shared(publisher) => Ok(Loan::Shared(publisher.loan(len)?)),
            Self::Local(publisher) => {
                let (sample, publisher) = (publisher.port.loan(len), publisher.clone());
                Ok(Loan::Local(LocalLoan { sample, publisher }))
            }
        }
    }

    /// Sends copies of `records`, and returns the number of receivers that have them.
    pub(crate) fn send(&self, header: H, records: &[T]) -> Result<usize, PublishError> {
        #[cfg(feature = "shared-memory")]
        if let Self::Shared(publisher) = self {
            return publisher.send_copies(header, records);
        }
        let mut loan = self.loan(records.len())?;
        *loan.header_mut() = header;
        loan.records_mut().copy_from_slice(records);
        loan.send()
    }

    /// Connects receivers that have joined since, and gives them the samples that the service keeps
    /// for late joiners.
    pub(crate) fn update(&self) {
        #[cfg(feature = "shared-memory")]
        match self {
            Self::Shared(publisher) => publisher.update(),
            Self::Local(publisher) => {
                if let Some(mirror) = &publisher.mirror {
                    mirror.update();
                }
            }
        }
    }

    /// The number of receivers of the service.
    pub(crate) fn readers(&self) -> usize {
        match self {
            #[cfg(feature = "shared-memory")]
            Self::Shared(publisher) => publisher.readers(),
            Self::Local(publisher) => {
                let readers = publisher.port.readers();
                #[cfg(feature = "shared-memory")]
                let readers =
                    readers + publisher.mirror.as_ref().map_or(0, |mirror| mirror.readers());
                readers
            }
        }
    }
}

/// The owner of a port of a local fleet, in error messages.
const THIS_PROCESS: &str = "this process";

fn full(service: &str, limit: usize, fleet: &LocalFleet) -> OpenError {
    let service = crate::ports::services::service_name(fleet.name(), service);
    OpenError::Full { service, limit, holders: THIS_PROCESS.to_owned() }
}

/// A sample under construction. Dropped without [`send`](Self::send), no receiver sees it.
pub(crate) enum Loan<T: Record, H: Header> {
    #[cfg(feature = "shared-memory")]
    Shared(shared::Loan<T, H>),
    Local(LocalLoan<T, H>),
}

/// A sample under construction, of a local fleet.
pub(crate) struct LocalLoan<T: Record, H: Header> {
    sample: local::Sample<T, H>,
    publisher: LocalPublisher<T, H>,
}

impl<T: Record, H: Header> Loan<T, H> {
    /// The header.
    pub(crate) fn header_mut(&mut self) -> &mut H {
        match self {
            #[cfg(feature = "shared-memory")]
            Self::Shared(loan) => loan.header_mut(),
            Self::Local(loan) => &mut loan.sample.header,
        }
    }

    /// The records.
    pub(crate) fn records_mut(&mut self) -> &mut [T] {
        match self {
            #[cfg(feature = "shared-memory")]
            Self::Shared(loan) => loan.records_mut(),
            Self::Local(loan) => &mut loan.sample.records,
        }
    }

    /// Sends the sample, and returns the number of receivers that have it.
    pub(crate) fn send(self) -> Result<usize, PublishError> {
        match self {
            #[cfg(feature = "shared-memory")]
            Self::Shared(loan) => loan.send(),
            Self::Local(LocalLoan { sample, publisher }) => {
                #[cfg(feature = "shared-memory")]
                if let Some(mirror) = &publisher.mirror
                    && let Err(error) = mirror.send_copies(sample.header, &sample.records)
                {
                    // Processes that watch miss it; the run doesn't depend on them.
                    tracing::debug!(%error, "publishing to shared memory");
                }
                Ok(publisher.port.send(sample))
            }
        }
    }
}

/// The receiving end of a publish-subscribe service.
pub(crate) enum Subscriber<T: Record, H: Header> {
    #[cfg(feature = "shared-memory")]
    Shared(shared::Subscriber<T, H>),
    Local(local::Subscriber<T, H>),
}

/// A received sample.
pub(crate) enum Sample<T: Record, H: Header> {
    #[cfg(feature = "shared-memory")]
    Shared(shared::Sample<T, H>),
    Local(Rc<local::Sample<T, H>>),
}

impl<T: Record, H: Header> Subscriber<T, H> {
    /// Opens the receiving end of the service with a name. The last `buffer` samples wait to be
    /// taken.
    pub(crate) fn open(
        service: &SliceService<T, H>,
        name: &str,
        participant: &Participant,
        buffer: usize,
    ) -> Result<Self, OpenError> {
        Ok(match participant.home() {
            #[cfg(feature = "shared-memory")]
            Home::Shared(_) => {
                Self::Shared(shared::Subscriber::open(service, name, participant, buffer)?)
            }
            Home::Local(fleet) => {
                Self::Local(local::Subscriber::open(fleet, name, &service.quality, buffer))
            }
        })
    }

    /// Takes the oldest sample that waits.
    pub(crate) fn receive(&self) -> Result<Option<Sample<T, H>>, ReadError> {
        Ok(match self {
            #[cfg(feature = "shared-memory")]
            Self::Shared(subscriber) => subscriber.receive()?.map(Sample::Shared),
            Self::Local(subscriber) => subscriber.receive().map(Sample::Local),
        })
    }

    /// The participant that has sent a sample; `None` if it has closed its port since.
    pub(crate) fn sender(&self, sample: &Sample<T, H>) -> Option<Member> {
        match (self, sample) {
            #[cfg(feature = "shared-memory")]
            (Self::Shared(subscriber), Sample::Shared(sample)) => {
                subscriber.sender(sample).map(Member::Shared)
            }
            (_, Sample::Local(sample)) => Some(Member::Local(sample.sender)),
            #[cfg(feature = "shared-memory")]
            (Self::Local(_), Sample::Shared(_)) => None,
        }
    }

    /// Whether a sample waits to be taken.
    pub(crate) fn has_samples(&self) -> Result<bool, ReadError> {
        match self {
            #[cfg(feature = "shared-memory")]
            Self::Shared(subscriber) => subscriber.has_samples(),
            Self::Local(subscriber) => Ok(subscriber.has_samples()),
        }
    }

    /// Whether the service has a publisher. One that was killed counts until another process joins
    /// the fleet.
    pub(crate) fn has_publisher(&self) -> bool {
        match self {
            #[cfg(feature = "shared-memory")]
            Self::Shared(subscriber) => subscriber.has_publisher(),
            Self::Local(subscriber) => subscriber.has_publisher(),
        }
    }

    /// Removes the resources of dead processes at the service, so that
    /// [`has_publisher`](Self::has_publisher) is exact. Takes a millisecond or so.
    pub(crate) fn forget_dead(&self) {
        #[cfg(feature = "shared-memory")]
        if let Self::Shared(subscriber) = self {
            subscriber.forget_dead();
        }
    }
}

impl<T: Record, H: Header> Sample<T, H> {
    pub(crate) fn header(&self) -> &H {
        match self {
            #[cfg(feature = "shared-memory")]
            Self::Shared(sample) => sample.user_header(),
            Self::Local(sample) => &sample.header,
        }
    }

    pub(crate) fn records(&self) -> &[T] {
        match self {
            #[cfg(feature = "shared-memory")]
            Self::Shared(sample) => sample.payload(),
            Self::Local(sample) => &sample.records,
        }
    }
}
