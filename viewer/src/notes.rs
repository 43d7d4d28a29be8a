//! Notes of a recording: lines of a file beside it, each a time in seconds and a text. Replays show
//! them as marks.

use std::fs::OpenOptions;
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

/// Returns the file of a recording's notes.
pub fn file_of(recording: &Path) -> PathBuf {
    let mut path = recording.as_os_str().to_owned();
    path.push(".notes");
    path.into()
}

/// Adds a note at a time on the recording's clock, in nanoseconds. What the file has already is
/// left as it is.
///
/// # Errors
/// If the file can't be written.
pub fn append(recording: &Path, time_nanos: u64, text: &str) -> io::Result<()> {
    let path = file_of(recording);
    if path.symlink_metadata().is_ok_and(|metadata| !metadata.is_file()) {
        let reason = "this is a link or a device, and not a file of notes: remove it";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, reason));
    }
    let mut file = OpenOptions::new().read(true).append(true).create(true).open(path)?;
    let (seconds, nanos) = (time_nanos / 1_000_000_000, time_nanos % 1_000_000_000);
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let line_end = if ends_within_a_line(&mut file)? { "\n" } else { "" };
    // One write, so that two windows don't mix their lines.
    file.write_all(format!("{line_end}{seconds}.{nanos:09} {text}\n").as_bytes())
}

fn ends_within_a_line(file: &mut std::fs::File) -> io::Result<bool> {
    let mut last = [b'\n'];
    if file.seek(SeekFrom::End(0))? > 0 {
        file.seek(SeekFrom::End(-1))?;
        file.read_exact(&mut last)?;
    }
    Ok(last != [b'\n'])
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn notes_are_added_as_lines_and_what_was_there_is_kept() {
        let folder = std::env::temp_dir().join(format!("regatta-notes-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        let recording = folder.join("run.mcap");
        append(&recording, 12_500_000_000, "robot 7\nis stuck ").expect("written");
        append(&recording, 7, "at the start").expect("written");
        let path = folder.join("run.mcap.notes");
        let text = fs::read_to_string(&path).expect("notes");
        assert_eq!(text, "12.500000000 robot 7 is stuck\n0.000000007 at the start\n");
        fs::write(&path, "3 typed by hand, without an end").expect("written");
        append(&recording, 4_000_000_000, "more").expect("written");
        let text = fs::read_to_string(&path).expect("notes");
        assert_eq!(text, "3 typed by hand, without an end\n4.000000000 more\n");
        #[cfg(unix)]
        {
            // A recording of somebody else may come with a link to a file of the user.
            fs::remove_file(&path).expect("removed");
            std::os::unix::fs::symlink(folder.join("other"), &path).expect("a link");
            assert!(append(&recording, 7, "through a link").is_err());
        }
        fs::remove_dir_all(&folder).expect("removed");
        assert!(append(Path::new("/missing/folder/run.mcap"), 0, "a").is_err());
    }
}
