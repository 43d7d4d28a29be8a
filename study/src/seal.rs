//! Seals of results. All else in a study's folder follows from the plant, and is compared with it;
//! only the result of a run is known to nobody before. So its file ends with a seal: a keyed hash
//! (SipHash-2-4, 128 bits) of the rest. Without the user's key nobody can change a result, or make
//! one up.
//!
//! ```
//! use regatta_study::seal::Key;
//!
//! let key = Key::random()?;
//! let text = key.sealed(r#"{"orders":7}"#);
//! assert!(key.has_sealed(&text));
//! assert!(!key.has_sealed(&text.replace('7', "8")));
//! assert!(!Key::random()?.has_sealed(&text));
//! # std::io::Result::Ok(())
//! ```

use std::fmt::Write as _;
use std::io::{self, Write as _};
use std::path::Path;

use regatta_base::file;
use siphasher::sip128::SipHasher24;

const KEY_BYTES: usize = 16;
/// The text before the seal, which is the last member of an object, and the text after it.
const BEFORE: &str = ",\"seal\":\"";
const AFTER: &str = "\"}\n";
/// Hexadecimal digits of a seal.
const SEAL_DIGITS: usize = 32;

/// The key of a user's seals.
#[derive(Clone, Debug)]
pub struct Key([u8; KEY_BYTES]);

impl Key {
    /// Reads the key in a file. The first caller makes it, readable for the user alone.
    ///
    /// # Errors
    /// If the file can't be read or written, or holds no key.
    pub fn of_file(path: &Path) -> io::Result<Self> {
        match Self::read(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Self::make(path)?,
            key => return key,
        }
        // Another process may have made it first.
        Self::read(path)
    }

    /// Makes a key that only this value knows.
    ///
    /// # Errors
    /// If the system gives no random numbers.
    pub fn random() -> io::Result<Self> {
        let mut key = [0; KEY_BYTES];
        getrandom::fill(&mut key)?;
        Ok(Self(key))
    }

    fn read(path: &Path) -> io::Result<Self> {
        let bytes = file::read(path, KEY_BYTES as u64)?;
        bytes.try_into().map(Self).map_err(|_| {
            io::Error::new(io::ErrorKind::InvalidData, "it holds no key of studies: remove it")
        })
    }

    fn make(path: &Path) -> io::Result<()> {
        let folder = path.parent().unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder)?;
        let mut file = tempfile::NamedTempFile::new_in(folder)?;
        file.write_all(&Self::random()?.0)?;
        file.as_file().sync_all()?;
        match file.persist_noclobber(path) {
            Err(error) if error.error.kind() != io::ErrorKind::AlreadyExists => Err(error.error),
            _ => Ok(()),
        }
    }

    /// Adds the seal to an object in JSON, as its last member.
    pub fn sealed(&self, json: &str) -> String {
        let body = json.trim_end();
        let body = body.strip_suffix('}').unwrap_or(body);
        format!("{body}{BEFORE}{}{AFTER}", self.seal(body))
    }

    /// Whether a text ends with the seal of all before it.
    pub fn has_sealed(&self, text: &str) -> bool {
        let Some(rest) = text.strip_suffix(AFTER) else { return false };
        let Some((body, seal)) = rest
            .len()
            .checked_sub(SEAL_DIGITS)
            .and_then(|at| rest.split_at_checked(at))
            .and_then(|(body, seal)| Some((body.strip_suffix(BEFORE)?, seal)))
        else {
            return false;
        };
        seal == self.seal(body)
    }

    fn seal(&self, text: &str) -> String {
        let hash = SipHasher24::new_with_key(&self.0).hash(text.as_bytes());
        let mut digits = String::new();
        for byte in hash.as_bytes() {
            // Writing to a text never fails.
            let _ = write!(digits, "{byte:02x}");
        }
        digits
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seal_holds_for_the_whole_text_and_one_key() {
        let key = Key::random().expect("a key");
        let sealed = key.sealed("{\"a\":1,\"seal\":\"0\"}\n");
        assert!(key.has_sealed(&sealed));
        let value: serde_json::Value = serde_json::from_str(&sealed).expect("JSON");
        assert_eq!(value["a"], 1);
        for cut in 0..sealed.len() {
            assert!(!key.has_sealed(&sealed[..cut]), "cut at {cut}");
        }
        for text in ["", "{}", "{\"a\":1}\n", "é\"}\n", &sealed.replace("\"a\":1", "\"a\":10")] {
            assert!(!key.has_sealed(text), "{text}");
        }
        assert!(!Key::random().expect("a key").has_sealed(&sealed), "of another key");
    }

    #[test]
    fn the_key_of_a_file_stays() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("new/study.key");
        let sealed = Key::of_file(&path).expect("made").sealed("{}");
        assert!(Key::of_file(&path).expect("read").has_sealed(&sealed));
        std::fs::write(&path, "short").expect("written");
        let error = Key::of_file(&path).expect_err("no key").to_string();
        assert!(error.contains("remove it"), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn nobody_else_may_read_the_key() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("study.key");
        Key::of_file(&path).expect("made");
        let mode = std::fs::metadata(&path).expect("a file").permissions().mode();
        assert_eq!(mode & 0o077, 0);
    }
}
