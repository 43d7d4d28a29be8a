//! The transport of samples and requests: how they get from one port to another.
//!
//! A fleet lives in one of two homes. In *shared memory* its ports belong to processes of their
//! own, and iceoryx2 connects them ([`shared`]). In *local memory* all of them belong to one
//! thread, and a sample that is sent is a reference that receivers count ([`local`]). The types of
//! this module are those of both: a port can't tell where it lives.
//!
//! A local fleet may be *published*: then what its ports publish goes to shared memory, too, for
//! processes that watch.

pub mod local;
#[cfg(feature = "shared-memory")]
pub(crate) mod shared;

mod claim;
#[cfg_attr(
    not(feature = "shared-memory"),
    allow(unused_variables, reason = "only shared memory has segments of a first size")
)]
mod publish;
mod request;
mod wake;

pub(crate) use claim::{Claim, Holder, Member};
pub(crate) use publish::{Loan, Publisher, Sample, Subscriber};
pub(crate) use request::{Asked, Client, Request, Server};
pub(crate) use wake::{Notifier, Wake};
