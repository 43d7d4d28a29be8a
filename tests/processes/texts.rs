//! The file of all texts that users read, which tests write for a person to read it aloud.

use std::path::Path;

/// The beginning of the line before a part.
const MARK: &str = "##### ";

/// Replaces a part of `texts.txt` in the folder for files of tests, and returns a line that says
/// where it is. Tests of other parts keep theirs.
pub fn write(part: &str, text: &str) -> String {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("texts.txt");
    let known = std::fs::read_to_string(&path).unwrap_or_default();
    let parts = known.split_inclusive('\n').fold(Vec::new(), |mut parts: Vec<String>, line| {
        match parts.last_mut() {
            Some(last) if !line.starts_with(MARK) => last.push_str(line),
            _ => parts.push(line.to_owned()),
        }
        parts
    });
    let title = format!("{MARK}{part}\n");
    let mut parts: Vec<_> = parts.into_iter().filter(|other| !other.starts_with(&title)).collect();
    parts.push(format!("{title}{}\n", text.trim_end()));
    parts.sort();
    std::fs::write(&path, parts.concat()).expect("written");
    format!("{part}: {} lines are in {}", text.lines().count(), path.display())
}
