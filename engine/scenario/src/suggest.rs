//! Suggestions for misspelt names.

/// The least Jaro similarity of a suggestion, as in clap.
const LEAST_SIMILARITY: f64 = 0.7;

/// Returns the candidate that a misspelt name most likely means, if any is similar to it.
pub fn closest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let name = name.to_lowercase();
    let similar = candidates
        .into_iter()
        .map(|candidate| (strsim::jaro(&name, &candidate.to_lowercase()), candidate));
    let best = similar
        .filter(|(similarity, _)| *similarity > LEAST_SIMILARITY)
        .max_by(|a, b| a.0.total_cmp(&b.0));
    best.map(|(_, candidate)| candidate)
}

/// Returns the end of a message about an unknown name: a question that names the closest candidate,
/// or nothing.
pub(super) fn did_you_mean<'a>(
    name: &str,
    candidates: impl IntoIterator<Item = &'a str>,
) -> String {
    closest(name, candidates)
        .map(|candidate| format!("; did you mean '{candidate}'?"))
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_most_similar_name_is_suggested() {
        let plugins = ["collision", "hello", "metrics", "udp", "udp-source"];
        assert_eq!(closest("helo", plugins), Some("hello"));
        assert_eq!(closest("Colision", plugins), Some("collision"));
        assert_eq!(closest("udp-sauce", plugins), Some("udp-source"));
        assert_eq!(closest("xyz", plugins), None);
        assert_eq!(closest("", plugins), None);
    }
}
