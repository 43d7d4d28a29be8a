//! Mathematics and text that the layout crate and plugins share: it knows neither layouts nor the
//! contract. The motion kernel and the validator keep implementations of their own on purpose: the
//! kernel for its bits, the validator for its independence.

mod ln;
pub mod random;

pub use ln::ln;
