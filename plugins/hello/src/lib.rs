//! The smallest plugin: prints the centre of the fleet. Copy this folder to write your own.

use regatta_plugin::{Frame, Plugin, Result};

/// Prints the centre of all robots, frame by frame.
pub struct Centre;

impl Plugin for Centre {
    fn on_frame(&mut self, frame: &Frame) -> Result {
        let mean = |column: &[f32]| column.iter().sum::<f32>() / frame.len() as f32;
        println!(
            "tick {}: centre ({:.2}, {:.2}) m",
            frame.tick(),
            mean(frame.x()),
            mean(frame.y())
        );
        Ok(())
    }
}
