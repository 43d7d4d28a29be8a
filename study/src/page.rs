//! The page of a study: the same content as HTML with its pictures in it, and as Markdown with
//! pictures beside it.

mod chart;
mod content;
mod heat_map;
mod html;
mod markdown;

pub use chart::COLOURS;
pub use content::{Block, content};
pub use html::html;
pub use markdown::markdown;
