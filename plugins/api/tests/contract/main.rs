//! Tests of the contract by its public interface.

mod common;
mod contacts;
mod frames;
mod homes;
mod layout;
mod messages;
mod processes;
mod vocabulary;
