//! Ports in shared memory, by iceoryx2.

mod claim;
mod full_memory;
mod obstacle;
mod open;
mod places;
mod publish;
mod request;
mod wake;

pub(crate) use claim::{Claim, Holder, claim};
pub(crate) use full_memory::{FULL, guarded, loan_record, received, unless_full};
pub(crate) use open::{done, service_names, version_of};
pub(crate) use places::place;
pub(crate) use publish::{Loan, Publisher, Sample, Subscriber};
pub(crate) use request::{Asked, Client, Request, Server, answer};
pub(crate) use wake::{Notifier, Wake, notifier};

/// Within a process no port is shared between threads, so no operation takes a lock.
pub(crate) type Ipc = iceoryx2::prelude::ipc::Service;
