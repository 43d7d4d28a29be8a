//! A correct conversation has no findings; each rule finds its planted fault.

mod conversation;
mod faults;
mod hostile;

use conversation::Conversation;

use crate::message::Version;

#[test]
fn a_correct_conversation_has_no_findings() {
    for version in Version::ALL {
        let findings = Conversation::correct(version).judged(100.0);
        let texts: Vec<_> = findings.iter().map(ToString::to_string).collect();
        assert!(findings.is_empty(), "{version}: {texts:#?}");
    }
}
