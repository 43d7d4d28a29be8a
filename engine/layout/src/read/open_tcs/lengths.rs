//! The lengths of paths. Robots drive the drawn curves; another length is a cost for routing.

use glam::DVec2;

use super::MAX_EXAMPLES;
use super::element::Element;
use crate::model::finding::{FindingKind, Report, Severity, Subject};
use crate::model::path::Path;
use crate::model::value::shorten;
use crate::read::layout::Shape;

/// The property for the length of a path in millimetres.
pub(crate) const LENGTH: &str = "opentcs:length";
/// A length is far from the drawn one from this part of the drawn one on, and from so many metres.
const FAR_PART: f64 = 0.1;
const FAR_METRES: f64 = 0.25;

/// The paths whose lengths are far from the drawn ones.
#[derive(Debug, Default)]
pub(super) struct OtherLengths(Vec<OtherLength>);

/// A length in the file, and that of the drawn curve, in metres.
#[derive(Debug)]
struct OtherLength {
    at: u32,
    path: String,
    given: f64,
    drawn: f64,
}

impl OtherLengths {
    /// Drops the length of a path if it equals that of its shape, and notes one that is far from
    /// it.
    pub(super) fn take(
        &mut self,
        path: &str,
        element: &mut Element<'_>,
        shape: &Shape,
        [from, to]: [Option<DVec2>; 2],
    ) {
        let drawn = match shape {
            Shape::Straight => from.zip(to).map(|(from, to)| from.distance(to)),
            Shape::Cubics(cubics) => Path::from_cubics(cubics).map(|path| path.length()),
        };
        let given = element.get("length").and_then(|length| length.trim().parse::<f64>().ok());
        if let (Some(given), Some(drawn)) = (given, drawn) {
            if (given - millimetres_of(drawn)).abs() <= 1.0 {
                element.take(&["length"]);
            }
            let (path, given) = (path.to_owned(), given / 1000.0);
            let other = OtherLength { at: element.at, path, given, drawn };
            self.0.extend(Some(other).filter(OtherLength::is_far));
        }
        // Layouts of other formats may have a property `length` in another unit.
        for (name, _) in element.attributes.iter_mut().filter(|(name, _)| *name == "length") {
            *name = LENGTH;
        }
    }

    /// Tells of the noted lengths, in one warning.
    pub(super) fn report(&mut self, report: &mut Report<'_>) {
        let mut others = std::mem::take(&mut self.0);
        let Some(first) = others.first() else { return };
        let at = first.at;
        others.sort_by(|a, b| b.difference().total_cmp(&a.difference()));
        let named: Vec<String> =
            others.iter().take(MAX_EXAMPLES).map(OtherLength::in_words).collect();
        let more = match others.len().saturating_sub(MAX_EXAMPLES) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let [plural, have, is] = match others.len() {
            1 => ["", "has", "that of its curve"],
            _ => ["s", "have", "those of their curves"],
        };
        let named = named.join(", ");
        let message = format!(
            "path{plural} {named}{more} {have} a `length` far from {is}: robots drive the curve, \
             and the `length` isn't used; if it is the true one, move the points"
        );
        let kind = FindingKind::Assumption;
        report.add_kind(kind, Severity::Warning, at, Subject::File, message);
    }
}

impl OtherLength {
    fn difference(&self) -> f64 {
        (self.given - self.drawn).abs()
    }

    fn is_far(&self) -> bool {
        self.difference() > (FAR_PART * self.drawn).max(FAR_METRES)
    }

    fn in_words(&self) -> String {
        format!("`{}` ({:.2} m, drawn {:.2} m)", shorten(&self.path), self.given, self.drawn)
    }
}

/// Returns a length in whole millimetres, at least 1, because paths need a length.
pub(crate) fn millimetres_of(metres: f64) -> f64 {
    (metres * 1000.0).round().max(1.0)
}

#[cfg(test)]
mod tests {
    use crate::model::options::ReadOptions;
    use crate::parse;

    /// Returns the warnings about a model with paths of 10 m that have other lengths.
    fn told(lengths: &[&str]) -> Vec<String> {
        let point = |name: &str, x: u32| {
            format!("<point name=\"{name}\" positionX=\"{x}\" positionY=\"0\"/>")
        };
        let path = |(number, length): (usize, &&str)| {
            let [from, to] = if number % 2 == 0 { ["A", "B"] } else { ["B", "A"] };
            format!(
                "<path name=\"P{number}\" sourcePoint=\"{from}\" destinationPoint=\"{to}\" \
                 length=\"{length}\" maxVelocity=\"1000\"/>"
            )
        };
        let paths: String = lengths.iter().enumerate().map(path).collect();
        let points = point("A", 0) + &point("B", 10_000);
        let text = format!("<model version=\"7.0.0\" name=\"m\">{points}{paths}</model>");
        let findings = parse(&text, "m.xml", &ReadOptions::default()).expect("a graph").1;
        let messages = findings.as_slice().iter().map(|finding| finding.message.clone());
        messages.filter(|message| message.contains("`length`")).collect()
    }

    #[test]
    fn lengths_far_from_the_drawn_ones_are_told_once_the_farthest_first() {
        assert!(told(&["10000", "10001", "9100", "10900"]).is_empty(), "within a tenth");
        let told_one = told(&["10000", "25000"]);
        let expected =
            "path `P1` (25.00 m, drawn 10.00 m) has a `length` far from that of its curve";
        assert!(told_one.len() == 1 && told_one[0].starts_with(expected), "{told_one:?}");
        let all = told(&["1", "1", "1", "1", "1", "25000", "1"]);
        assert!(all.len() == 1 && all[0].starts_with("paths `P5` (25.00 m, "), "{all:?}");
        assert!(all[0].contains("(0.00 m, drawn 10.00 m) and 2 more have a `length`"), "{all:?}");
    }
}
