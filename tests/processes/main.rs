//! Whole processes: the real binary, real shared memory, real signals. Each test has a fleet name of its
//! own, so that all run side by side.

mod collision;
mod command_line;
mod control;
mod determinism;
mod fleet;
mod lockstep;
mod metrics;
mod own_plugin;
mod producers;
mod readers;
mod record;
mod replay;
mod restart;
mod routes;
mod terminal;
mod top;
mod udp;
