//! The smallest plugin: prints the centre of the fleet. Copy this folder to write your own.

use regatta_plugin::{Frame, Plugin, Result};

/// Prints the centre of all robots, frame by frame.
pub struct Centre;

impl Plugin for Centre {
    fn on_frame(&mut self, frame: &Frame) -> Result {
        let (x, y) = (mean(frame.x()), mean(frame.y()));
        println!("tick {}: centre ({x:.2}, {y:.2}) m", frame.tick());
        Ok(())
    }
}

fn mean(column: &[f32]) -> f32 {
    column.iter().sum::<f32>() / column.len() as f32
}
