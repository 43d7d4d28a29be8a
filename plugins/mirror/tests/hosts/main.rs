//! A fleet, its sender and its receiver as processes of their own. This program starts itself again
//! as each.

mod engine;
mod link;
mod namespaces;
mod process;
mod steering;
