//! A process that was asked to end and still saves its work says so to the one that started it.

use std::fs::File;
use std::io::Write as _;
use std::path::Path;
use std::time::{Duration, Instant};

/// The environment variable with a file that a process appends to while it still saves its work
/// after it was asked to end: the one that started it waits as long as the file grows. `regatta
/// run` sets it.
pub const FINISHING_VARIABLE: &str = "REGATTA_FINISHING";

/// The shortest time between two signs.
const PERIOD: Duration = Duration::from_millis(200);

/// The signs by which a process that was asked to end says that it still saves its work.
///
/// ```
/// # fn save(_block: u32) {}
/// let mut finishing = regatta_plugin::Finishing::begin();
/// for block in 0..1000 {
///     save(block);
///     finishing.goes_on();
/// }
/// ```
///
/// `regatta run` kills a child that neither ends nor gives a sign for 5 s.
#[derive(Debug)]
pub struct Finishing {
    /// `None` if nobody waits.
    file: Option<File>,
    told: Option<Instant>,
}

impl Finishing {
    /// Begins to give signs to the process that started this one.
    pub fn begin() -> Self {
        Self::at(std::env::var_os(FINISHING_VARIABLE).as_deref().map(Path::new))
    }

    fn at(path: Option<&Path>) -> Self {
        let file = path.and_then(|path| File::options().append(true).open(path).ok());
        Self { file, told: None }
    }

    /// Says that the work goes on. To be called often: only some calls give a sign.
    pub fn goes_on(&mut self) {
        let Some(file) = &mut self.file else { return };
        if self.told.is_none_or(|told| told.elapsed() >= PERIOD) {
            self.told = Some(Instant::now());
            // Without room for a byte there is none for the work either.
            let _ = file.write_all(b".");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_are_few_and_only_where_somebody_waits() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("signs");
        Finishing::at(Some(&path)).goes_on();
        assert!(!path.exists(), "it makes no file");
        File::create(&path).expect("created");
        let mut finishing = Finishing::at(Some(&path));
        for _ in 0..1000 {
            finishing.goes_on();
        }
        let signs = path.metadata().expect("there").len();
        assert!((1..20).contains(&signs), "{signs}");
    }
}
