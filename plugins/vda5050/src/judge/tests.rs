//! A correct conversation has no findings; each rule finds its planted fault.

mod conversation;
mod faults;
mod hostile;

use conversation::Conversation;

use crate::message::Version;

fn texts(talk: &Conversation) -> Vec<String> {
    talk.judged(100.0).iter().map(ToString::to_string).collect()
}

#[test]
fn a_correct_conversation_has_no_findings() {
    for version in Version::ALL {
        let findings = Conversation::correct(version).judged(100.0);
        let texts: Vec<_> = findings.iter().map(ToString::to_string).collect();
        assert!(findings.is_empty(), "{version}: {texts:#?}");
    }
}

/// A broker may deliver a message again that wasn't acknowledged, also after later ones.
#[test]
fn messages_that_are_delivered_again_are_no_breach() {
    for version in Version::ALL {
        let mut talk = Conversation::correct(version);
        let twice = talk.messages.iter().flat_map(|sent| [sent.clone(), sent.clone()]);
        talk.messages = twice.collect();
        assert_eq!(texts(&talk), [""; 0], "{version}: each message twice");
        let mut talk = Conversation::correct(version);
        for topic in ["state", "order"] {
            let (mut first, mut second) =
                (talk.sent(topic, 0).clone(), talk.sent(topic, 1).clone());
            let later = second.time + 0.05;
            (first.time, second.time) = (later, later);
            talk.messages.extend([first, second]);
        }
        assert_eq!(texts(&talk), [""; 0], "{version}: two messages twice, in their order");
    }
}

#[test]
fn a_header_id_that_another_message_has_is_a_breach() {
    for version in Version::ALL {
        let mut talk = Conversation::correct(version);
        let mut other = talk.sent("state", 11).clone();
        other.time += 0.1;
        other.content["driving"] = true.into();
        talk.messages.push(other);
        let found = texts(&talk);
        assert!(found.iter().any(|text| text.contains("header-id-repeated")), "{found:#?}");
    }
}
