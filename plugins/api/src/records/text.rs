//! Text in records: UTF-8 in a field of fixed length, padded with zeros.

/// Returns the text in a padded field, up to the first byte that is not UTF-8.
pub(crate) fn text(bytes: &[u8]) -> &str {
    let bytes = bytes.split(|byte| *byte == 0).next().unwrap_or_default();
    match core::str::from_utf8(bytes) {
        Ok(text) => text,
        Err(error) => core::str::from_utf8(&bytes[..error.valid_up_to()]).unwrap_or_default(),
    }
}

/// Returns `text` as a padded field, cut after the last whole character that fits.
pub(crate) fn padded<const N: usize>(text: &str) -> [u8; N] {
    let cut = cut(text, N);
    let mut bytes = [0; N];
    bytes[..cut.len()].copy_from_slice(cut.as_bytes());
    bytes
}

/// Returns the longest prefix of `text` of at most `bytes` bytes.
pub(crate) fn cut(text: &str, bytes: usize) -> &str {
    &text[..text.floor_char_boundary(bytes)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_fields_are_cut_at_whole_characters() {
        assert_eq!(text(&padded::<4>("abcdef")), "abcd");
        assert_eq!(text(&padded::<4>("abcé")), "abc");
        assert_eq!(text(&padded::<4>("")), "");
        assert_eq!(text(&[b'a', 0xff, b'b']), "a");
    }
}
