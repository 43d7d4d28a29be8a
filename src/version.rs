//! The version of this program.

use regatta_plugin::frame::CONTRACT_VERSION;

/// Returns the commit, if this program was built from a git repository.
pub fn commit() -> Option<&'static str> {
    Some(env!("REGATTA_COMMIT")).filter(|commit| !commit.is_empty())
}

/// Returns the version, and the commit if there is one.
pub fn short() -> String {
    match commit() {
        None => env!("CARGO_PKG_VERSION").to_owned(),
        Some(commit) => format!("{} ({commit})", env!("CARGO_PKG_VERSION")),
    }
}

/// Returns the version, and those of [`interfaces`].
pub fn long() -> String {
    format!("{}\n{}", short(), interfaces())
}

/// Returns the versions of the contract and of iceoryx2, a line each: processes can share a fleet
/// if both are equal.
pub fn interfaces() -> String {
    let iceoryx2 = match env!("REGATTA_ICEORYX2") {
        "" => "unknown",
        version => version,
    };
    format!("contract {CONTRACT_VERSION}\niceoryx2 {iceoryx2}")
}
