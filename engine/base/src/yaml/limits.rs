//! Limits of a text that hold before a parser sees it: to look for the end of deeply nested
//! brackets, or for the directive of a tag, takes YAML parsers a time that grows with the square
//! of their number. Lists that begin on one line stay in their memory until the line ends.

use super::{Error, MAX_DEPTH};

/// The most lines that begin with `%`.
const MAX_DIRECTIVES: usize = 20;

/// Checks in one pass that a text may be given to any parser of YAML.
///
/// # Errors
/// If brackets, or the lists that begin on a line, are nested more than [`MAX_DEPTH`] deep, or
/// there are many directives.
pub fn check_limits(text: &str) -> Result<(), Error> {
    let (mut line, mut depth, mut directives, mut before) = (1, 0usize, 0, b'\n');
    let mut begin = LineBegin::default();
    for byte in text.bytes() {
        begin.take(before, byte);
        match byte {
            b'\n' => line += 1,
            b'[' | b'{' if begins_value(before) => depth += 1,
            b']' | b'}' => depth = depth.saturating_sub(1),
            b'%' if before == b'\n' => directives += 1,
            _ => {}
        }
        if depth > MAX_DEPTH {
            return Err(Error { line, reason: format!("more than {MAX_DEPTH} nested brackets") });
        }
        if begin.indicators > MAX_DEPTH {
            return Err(Error { line, reason: format!("more than {MAX_DEPTH} nested lists") });
        }
        if directives > MAX_DIRECTIVES {
            let reason = format!("more than {MAX_DIRECTIVES} directives (lines with `%`)");
            return Err(Error { line, reason });
        }
        before = byte;
    }
    Ok(())
}

/// The start of a line: blanks, and the indicators of items and keys (`-` and `?`).
#[derive(Default)]
struct LineBegin {
    indicators: usize,
    is_over: bool,
}

impl LineBegin {
    fn take(&mut self, before: u8, byte: u8) {
        match byte {
            b'\n' => *self = Self::default(),
            _ if self.is_over || byte.is_ascii_whitespace() => {}
            b'-' | b'?' if before.is_ascii_whitespace() => self.indicators += 1,
            _ => self.is_over = true,
        }
    }
}

/// Whether a bracket after a byte may open a list or a map. Within a word it is a part of it.
fn begins_value(before: u8) -> bool {
    before.is_ascii_whitespace() || b"[{,:-?".contains(&before)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nesting_is_limited_and_brackets_in_words_do_not_count() {
        for pair in ["[", "{a: ", "- [", "{a,[", "? {"] {
            let error = check_limits(&format!("a: 1\n{}", pair.repeat(200))).expect_err(pair);
            assert_eq!((error.line, &*error.reason), (2, "more than 100 nested brackets"));
        }
        assert!(check_limits(&"[[1, 2], {a: [b]}]\n".repeat(1000)).is_ok());
        assert!(check_limits(&"- \"[a\"\n- b[c\n".repeat(1000)).is_ok());
        assert!(check_limits(&format!("{}{}", "[".repeat(100), "]".repeat(100))).is_ok());
    }

    #[test]
    fn lists_that_begin_on_one_line_are_limited() {
        for pair in ["- ", "? ", "- ? ", "-\t"] {
            let error = check_limits(&format!("a: 1\n {}", pair.repeat(101))).expect_err(pair);
            assert_eq!((error.line, &*error.reason), (2, "more than 100 nested lists"));
        }
        let rule = format!("- a: b - c\n{}\n{} - 1\n", "-".repeat(1000), "- ".repeat(50));
        assert!(check_limits(&rule.repeat(1000)).is_ok());
    }

    #[test]
    fn directives_are_limited() {
        assert!(check_limits("%YAML 1.2\n---\na: 50 %\n").is_ok());
        assert!(check_limits(&"a: 50 %\n".repeat(1000)).is_ok());
        let error = check_limits(&"%TAG !a! b\n".repeat(1000)).expect_err("many directives");
        assert_eq!((error.line, error.reason.contains("directives")), (21, true));
    }
}
