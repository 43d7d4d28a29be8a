//! The time that a jump within a recording takes, until the picture of that time is there.

use std::time::{Duration, Instant};

use regatta_base::random;
use regatta_interface::text::with_plural;
use regatta_plugin::{Control, Error, Result};
use regatta_scene::Detail;

use super::HeadlessViewer;

/// The number of jumps.
const JUMPS: u64 = 50;

impl HeadlessViewer<'_> {
    /// Jumps to random times, always the same ones, and prints the median and the longest duration
    /// in milliseconds: until the replay answers, of drawing alone, and until the picture is drawn.
    pub(super) fn scrub(&mut self) -> Result {
        if !self.wait_for_fleet()? {
            return Ok(());
        }
        if self.gpu.is_software() {
            self.stage.scene.detail = Detail::software();
        }
        self.wait_for_columns()?;
        let Some(recording) = self.stage.feed.recording() else {
            return Err(Error::new("this isn't a recording"));
        };
        let (start, end) = (recording.header.start_nanos, recording.header.end_nanos);
        let mut control = Control::open_on(&self.participant)?;
        control.pause()?;
        let (mut answers, mut drawings, mut pictures) = (Vec::new(), Vec::new(), Vec::new());
        for jump in 0..JUMPS {
            let part = random::unit(random::mix(jump));
            let time = start + ((end - start) as f64 * part) as u64;
            let began = Instant::now();
            let status = control.seek(Duration::from_nanos(time))?;
            answers.push(began.elapsed());
            self.stage.update(Instant::now())?;
            let shown = self.stage.feed.frame().map(|frame| frame.tick());
            if shown != Some(status.tick) {
                return Err(Error::new(format!(
                    "the frame of tick {} is not there, but {shown:?}",
                    status.tick
                )));
            }
            let drawn = Instant::now();
            self.render(1.0)?;
            drawings.push(drawn.elapsed());
            pictures.push(began.elapsed());
        }
        let robots = self.stage.feed.frame().map_or(0, |frame| frame.len());
        let robots = with_plural(robots as u64, "robot");
        println!(
            "{JUMPS} jumps in {:.1} s of {robots}: median, longest",
            (end - start) as f64 * 1e-9
        );
        print("answer", answers);
        print("drawing", drawings);
        print("picture", pictures);
        Ok(())
    }
}

fn print(what: &str, mut times: Vec<Duration>) {
    times.sort_unstable();
    let [median, longest] =
        [times.len() / 2, times.len() - 1].map(|i| times[i].as_secs_f64() * 1e3);
    println!("{what:8} {median:7.1} ms {longest:7.1} ms");
}
