//! The fuzz target of messages to the plugin foxglove: whatever a client sends, it is read or
//! refused.

use regatta_foxglove::protocol::{Request, parse};

/// Reads a message as text and as a binary message.
pub fn read(message: &[u8]) {
    for is_text in [true, false] {
        let Ok(request) = parse(message, is_text) else { continue };
        if let Request::Call(call) = request {
            assert!(call.encoding.len() + call.payload.len() <= message.len());
        }
    }
}
