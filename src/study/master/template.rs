//! Texts with placeholders: `{id}`, `{pick}`. Other braces stay as they are, as those of JSON do.

use crate::failure::Failure;

/// A name in braces, and the text that takes its place.
pub type Value<'a> = (&'a str, &'a str);

/// Returns a text with values in the places of their names. `escape` makes a value fit the text.
pub fn filled(text: &str, values: &[Value<'_>], escape: fn(&str) -> String) -> String {
    let (mut filled, mut rest) = (String::new(), text);
    while let Some((before, after)) = rest.split_once('{') {
        filled.push_str(before);
        let found = values
            .iter()
            .find_map(|(name, value)| Some((value, after.strip_prefix(name)?.strip_prefix('}')?)));
        match found {
            Some((value, after)) => {
                filled.push_str(&escape(value));
                rest = after;
            }
            None => {
                filled.push('{');
                rest = after;
            }
        }
    }
    filled + rest
}

/// Returns a value as it is.
pub fn plain(value: &str) -> String {
    value.to_owned()
}

/// Returns a value as a part of a JSON string.
pub fn in_json(value: &str) -> String {
    let quoted = serde_json::Value::from(value).to_string();
    quoted[1..quoted.len() - 1].to_owned()
}

/// Returns a value as a part of the path of an address.
pub fn in_url(value: &str) -> String {
    let is_kept = |byte: &u8| byte.is_ascii_alphanumeric() || b"-._~".contains(byte);
    let bytes = value.bytes().map(|byte| match is_kept(&byte) {
        true => char::from(byte).to_string(),
        false => format!("%{byte:02X}"),
    });
    bytes.collect()
}

/// Splits a command line at spaces; text in single or double quotes stays together.
///
/// # Errors
/// If it has no program, or a quote without its end.
pub fn words(command: &str) -> Result<Vec<String>, Failure> {
    let (mut words, mut word, mut quote) = (Vec::new(), None::<String>, None);
    for character in command.chars() {
        match quote {
            Some(end) if character == end => quote = None,
            None if matches!(character, '"' | '\'') => {
                quote = Some(character);
                word.get_or_insert_default();
            }
            None if character.is_whitespace() => words.extend(word.take()),
            _ => word.get_or_insert_default().push(character),
        }
    }
    if let Some(quote) = quote {
        return Err(format!("'{command}': the quote {quote} has no end").into());
    }
    words.extend(word);
    if words.is_empty() {
        return Err("the command is empty: give a program and its arguments".into());
    }
    Ok(words)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_in_braces_are_replaced_and_other_braces_stay() {
        let values = [("id", "o-1"), ("pick", "a \"b\"")];
        let json = r#"{"id": "{id}", "x": {"from": "{pick}", "{no}": {}}"#;
        assert_eq!(
            filled(json, &values, in_json),
            r#"{"id": "o-1", "x": {"from": "a \"b\"", "{no}": {}}"#
        );
        assert_eq!(filled("/{id}/{pick}", &values, in_url), "/o-1/a%20%22b%22");
        assert_eq!(filled("{", &values, plain), "{");
    }

    #[test]
    fn a_command_line_has_words_with_quotes() {
        let found = words(r#"pub -m '{"id": "{id}"}' "" a"b c"d"#).expect("words");
        assert_eq!(found, ["pub", "-m", r#"{"id": "{id}"}"#, "", "ab cd"]);
        assert!(words(" ").is_err());
        assert_eq!(
            words("a 'b").expect_err("no end").to_string(),
            "'a 'b': the quote ' has no end"
        );
    }
}
