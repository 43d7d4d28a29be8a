//! `udp`
pub mod fixed;
pub mod line;
pub mod packer;
