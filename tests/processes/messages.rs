//! The style of messages on standard error: `NAME: message`.

use std::fs;
use std::path::{Path, PathBuf};

/// The folders whose programs print messages.
const FOLDERS: [&str; 5] = ["src", "plugins", "engine", "study", "viewer"];
/// Messages of another form: the second line of an error, and a question.
const OTHERS: [&str; 2] = ["  because: ", "{name} wants to start "];

/// Returns the files of Rust in a folder and its subfolders, without tests.
fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("read").path());
    entries
        .flat_map(|path| match path.is_dir() {
            true => rust_files(&path),
            false => vec![path],
        })
        .filter(|path| path.extension().is_some_and(|ending| ending == "rs"))
        .filter(|path| path.iter().all(|part| part != "tests"))
        .collect()
}

/// Returns the formats of the messages that a text prints.
fn messages(text: &str) -> Vec<&str> {
    let calls = text.split("tell!(").skip(1).map(str::trim_start);
    calls.filter_map(|call| call.strip_prefix('"')?.split('"').next()).collect()
}

/// Whether a message begins with a name, or is one that comes with its name.
fn is_named(message: &str) -> bool {
    let (name, rest) = message.split_once(": ").unwrap_or((message, ""));
    let is_placeholder =
        name.starts_with('{') && name.find('}').is_some_and(|end| end + 1 == name.len());
    let is_word = |name: &str| {
        name.bytes().all(|byte| byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'-')
    };
    is_placeholder || (!rest.is_empty() && is_word(name))
}

#[test]
fn messages_begin_with_a_name() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut count = 0;
    for path in FOLDERS.iter().flat_map(|folder| rust_files(&root.join(folder))) {
        let text = fs::read_to_string(&path).expect("a text");
        for message in messages(&text) {
            let is_other = OTHERS.iter().any(|other| message.starts_with(other));
            assert!(is_other || is_named(message), "{}: '{message}'", path.display());
            count += 1;
        }
    }
    assert!(count > 80, "{count} messages");
}

#[test]
fn only_messages_with_a_name_are_named() {
    for message in ["regatta: no display", "{}: waiting", "udp-source: {}", "{finding}"] {
        assert!(is_named(message), "{message}");
    }
    for message in ["fleet '{fleet}': 3 ticks", "the warm-up ends early: {error}", "{} of {}"] {
        assert!(!is_named(message), "{message}");
    }
}
