//! Texts of strangers on a terminal.

use std::borrow::Cow;

/// Returns a text as it may be shown on a terminal: with escapes such as `\u{1b}` in place of
/// characters that would control the terminal or turn the direction of the text. Line breaks and
/// tabs stay.
///
/// ```
/// use regatta_plugin::visible;
///
/// assert_eq!(visible("Tür 7\n"), "Tür 7\n");
/// assert_eq!(visible("\u{1b}[2Jok"), "\\u{1b}[2Jok");
/// ```
pub fn visible(text: &str) -> Cow<'_, str> {
    if text.chars().all(is_harmless) {
        return Cow::Borrowed(text);
    }
    let mut escaped = String::with_capacity(text.len() + 16);
    for character in text.chars() {
        match is_harmless(character) {
            true => escaped.push(character),
            false => escaped.extend(character.escape_unicode()),
        }
    }
    Cow::Owned(escaped)
}

fn is_harmless(character: char) -> bool {
    match character {
        '\n' | '\t' => true,
        '\u{61c}' | '\u{200e}' | '\u{200f}' => false,
        '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => false,
        _ => !character.is_control(),
    }
}

#[cfg(test)]
mod tests {
    use super::visible;

    #[test]
    fn nothing_of_a_text_controls_a_terminal() {
        for (text, shown) in [
            ("a\r\u{8}b", "a\\u{d}\\u{8}b"),
            ("\u{9b}1m\u{7f}", "\\u{9b}1m\\u{7f}"),
            ("gnp.\u{202e}exe\u{2066}", "gnp.\\u{202e}exe\\u{2066}"),
        ] {
            assert_eq!(visible(text), shown);
        }
    }
}
