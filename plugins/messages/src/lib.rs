//! The messages in which recordings and live views have a fleet: protocol buffers of our own, bit
//! for bit, and those of Foxglove, which general tools show.
//!
//! | module | |
//! |---|---|
//! | [`schema`] | the topics, and the types of their messages; `proto/` defines these |
//! | [`encode`] | the records of the contract as messages of our own |
//! | [`scene`] | fleet, route graph and contacts as messages of Foxglove |

pub mod encode;
pub mod scene;
pub mod schema;

pub use schema::Topic;
