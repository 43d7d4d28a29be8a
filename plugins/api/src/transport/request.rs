//! The ends of a request-response service, in either home.
//!
//! The requests to a local fleet that is published come from other processes: its servers lie in
//! shared memory.

use super::local;
#[cfg(feature = "shared-memory")]
use super::shared;
use crate::ports::error::{OpenError, ReadError};
use crate::ports::services::{RequestService, service_name};
use crate::process::join::{Home, Participant};
use crate::records::Record;

/// A client of the one server of a service.
pub(crate) enum Client<Q: Record, A: Record> {
    #[cfg(feature = "shared-memory")]
    Shared(shared::Client<Q, A>),
    Local(local::Client<Q, A>),
}

/// A request that was sent.
pub(crate) enum Asked<Q: Record, A: Record> {
    #[cfg(feature = "shared-memory")]
    Shared(shared::Asked<Q, A>),
    Local(local::Asked<A>, core::marker::PhantomData<Q>),
}

impl<Q: Record, A: Record> Client<Q, A> {
    /// Opens a client of a service.
    pub(crate) fn open(
        service: &RequestService<Q, A>,
        participant: &Participant,
    ) -> Result<Self, OpenError> {
        Ok(match participant.home() {
            #[cfg(feature = "shared-memory")]
            Home::Shared(_) => Self::Shared(shared::Client::open(service, participant)?),
            #[cfg(feature = "shared-memory")]
            Home::Local(fleet) if let Some(mirror) = fleet.mirror() => {
                Self::Shared(shared::Client::open(service, mirror)?)
            }
            Home::Local(fleet) => Self::Local(local::Client::open(fleet, service.name)),
        })
    }

    /// Whether the service has a server. One that was killed counts until another process joins the
    /// fleet.
    pub(crate) fn has_server(&self) -> bool {
        match self {
            #[cfg(feature = "shared-memory")]
            Self::Shared(client) => client.has_server(),
            Self::Local(client) => client.has_server(),
        }
    }

    /// Sends a request. The error is the reason why it can't be sent.
    pub(crate) fn send(&self, request: Q) -> Result<Asked<Q, A>, String> {
        match self {
            #[cfg(feature = "shared-memory")]
            Self::Shared(client) => client.send(request).map(Asked::Shared),
            Self::Local(client) => {
                Ok(Asked::Local(client.send(request), core::marker::PhantomData))
            }
        }
    }

    /// Removes the resources of dead processes at the service.
    pub(crate) fn forget_dead(&self) {
        #[cfg(feature = "shared-memory")]
        if let Self::Shared(client) = self {
            client.forget_dead();
        }
    }

    /// Whether the server runs meanwhile, so that waiting for an answer can be of use.
    pub(crate) fn may_wait(&self) -> bool {
        match self {
            #[cfg(feature = "shared-memory")]
            Self::Shared(_) => true,
            Self::Local(_) => false,
        }
    }
}

impl<Q: Record, A: Record> Asked<Q, A> {
    /// Whether the server still has the request. (That of a local fleet ends with the thread that
    /// asks.)
    pub(crate) fn is_connected(&self) -> bool {
        match self {
            #[cfg(feature = "shared-memory")]
            Self::Shared(asked) => asked.is_connected(),
            Self::Local(..) => true,
        }
    }

    /// Takes the answer, once it has come. The error is the reason why it can't be taken.
    pub(crate) fn receive(&self) -> Result<Option<A>, String> {
        match self {
            #[cfg(feature = "shared-memory")]
            Self::Shared(asked) => asked.receive(),
            Self::Local(asked, _) => Ok(asked.take()),
        }
    }
}

/// The one server of a service.
pub(crate) enum Server<Q: Record, A: Record> {
    #[cfg(feature = "shared-memory")]
    Shared(shared::Server<Q, A>),
    Local(local::Server<Q, A>),
}

/// A request that waits for its answer.
pub(crate) enum Request<Q: Record, A: Record> {
    #[cfg(feature = "shared-memory")]
    Shared(shared::Request<Q, A>),
    Local(local::Request<Q, A>),
}

impl<Q: Record, A: Record> Server<Q, A> {
    /// Opens the server of a service.
    pub(crate) fn open(
        service: &RequestService<Q, A>,
        participant: &Participant,
    ) -> Result<Self, OpenError> {
        match participant.home() {
            #[cfg(feature = "shared-memory")]
            Home::Shared(_) => shared::Server::open(service, participant).map(Self::Shared),
            #[cfg(feature = "shared-memory")]
            Home::Local(fleet) if let Some(mirror) = fleet.mirror() => {
                shared::Server::open(service, mirror).map(Self::Shared)
            }
            Home::Local(fleet) => match local::Server::open(fleet, service.name) {
                Some(server) => Ok(Self::Local(server)),
                None => Err(OpenError::Full {
                    service: service_name(fleet.name(), service.name),
                    limit: 1,
                    holders: "this process".to_owned(),
                }),
            },
        }
    }

    /// Takes the oldest request that has arrived.
    pub(crate) fn take(&self) -> Result<Option<Request<Q, A>>, ReadError> {
        Ok(match self {
            #[cfg(feature = "shared-memory")]
            Self::Shared(server) => server.take()?.map(Request::Shared),
            Self::Local(server) => server.take().map(Request::Local),
        })
    }
}

impl<Q: Record, A: Record> Request<Q, A> {
    pub(crate) fn payload(&self) -> &Q {
        match self {
            #[cfg(feature = "shared-memory")]
            Self::Shared(request) => request.payload(),
            Self::Local(request) => &request.payload,
        }
    }

    /// Whether the client still waits for the answer.
    pub(crate) fn is_connected(&self) -> bool {
        match self {
            #[cfg(feature = "shared-memory")]
            Self::Shared(request) => request.is_connected(),
            Self::Local(request) => request.is_connected(),
        }
    }

    /// Answers. A client that has gone away, or is stopped, misses its answer; the server doesn't
    /// wait for it.
    pub(crate) fn answer(&self, answer: A) {
        match self {
            #[cfg(feature = "shared-memory")]
            Self::Shared(request) => shared::answer(request, answer),
            Self::Local(request) => request.answer(answer),
        }
    }
}
