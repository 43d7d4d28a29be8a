//! The queries of requests.

use crate::tasks::order::{OrderName, State};
use crate::tasks::store::Page;

/// The largest number of orders in an answer.
const MAX_PAGE: usize = 100_000;

/// Returns the value of a parameter.
pub(super) fn parameter(query: Option<&str>, name: &str) -> Option<String> {
    let mut pairs = query.unwrap_or("").split('&').filter_map(|pair| pair.split_once('='));
    pairs.find(|(key, _)| *key == name).map(|(_, value)| unescape(value))
}

/// Returns which orders a query asks for, or what is wrong with it.
pub(super) fn page(query: Option<&str>) -> Result<Page, String> {
    let state = parameter(query, "state");
    if let Some(state) =
        state.as_deref().filter(|state| *state != "open" && !State::NAMES.contains(state))
    {
        return Err(format!(
            "unknown state `{}`; there are open, {}",
            state.escape_debug(),
            State::NAMES.join(", ")
        ));
    }
    let limit = parameter(query, "limit").map(|text| {
        let limit = text.parse().ok().filter(|limit| (1..=MAX_PAGE).contains(limit));
        limit.ok_or_else(|| {
            format!("`limit` is `{}`, and must be 1 to {MAX_PAGE}", text.escape_debug())
        })
    });
    let after = parameter(query, "after").map(|name| OrderName::stored(&name));
    let after = after.transpose().map_err(|error| format!("`after`: {error}"))?;
    Ok(Page { state, after, limit: limit.transpose()?.unwrap_or(MAX_PAGE) })
}

/// Replaces `%20` and the like. Whatever isn't UTF-8 then becomes no name.
fn unescape(text: &str) -> String {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let [first, left @ ..] = rest {
        let hex =
            left.get(..2).filter(|_| *first == b'%').and_then(|hex| std::str::from_utf8(hex).ok());
        let byte = hex.and_then(|hex| u8::from_str_radix(hex, 16).ok());
        bytes.push(byte.unwrap_or(*first));
        rest = if byte.is_some() { &left[2..] } else { left };
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_unescaped() {
        for (value, expected) in
            [("a%20b", "a b"), ("Gr%C3%B6%c3%9Fe", "Größe"), ("%", "%"), ("%zz%4", "%zz%4")]
        {
            assert_eq!(
                parameter(Some(&format!("x=1&name={value}")), "name").as_deref(),
                Some(expected)
            );
        }
        assert_eq!(parameter(Some("name"), "name"), None);
        assert!(
            page(Some("limit=0")).is_err()
                && page(Some("limit=-1")).is_err()
                && page(Some("after=a/b")).is_err()
        );
        assert_eq!(page(Some("limit=7")).map(|page| page.limit), Ok(7));
    }
}
