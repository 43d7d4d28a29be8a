//! The text formats of metrics: that of Prometheus, and OpenMetrics.
//!
//! Both are written directly: they differ in a few names only, and no crate writes both.

use std::fmt::Write as _;

use crate::durations::{BOUNDS, Histogram, TimeSummary};

/// A text format.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Format {
    /// The text format of Prometheus, version 0.0.4.
    #[default]
    Prometheus,
    /// OpenMetrics, version 1.0.0.
    OpenMetrics,
}

impl Format {
    /// Chooses the format that a client prefers by its header `Accept`: OpenMetrics only if it is
    /// named.
    pub fn accepted(accept: &str) -> Self {
        let [mut text, mut open_metrics] = [0.0_f32; 2];
        for range in accept.split(',') {
            let mut parts = range.split(';').map(str::trim);
            let media_type = parts.next().unwrap_or_default();
            let parameters: Vec<_> =
                parts.filter_map(|parameter| parameter.split_once('=')).collect();
            let [quality, version] = ["q", "version"].map(|name| {
                parameters.iter().find(|(other, _)| *other == name).map(|(_, value)| *value)
            });
            let quality: f32 = quality.map_or(Ok(1.0), str::parse).unwrap_or(0.0);
            let version = version.map(|version| version.trim_matches('"'));
            match media_type {
                "application/openmetrics-text"
                    if version.is_none_or(|version| version == "1.0.0") =>
                {
                    open_metrics = quality.max(open_metrics);
                }
                "text/plain" if version.is_none_or(|version| version == "0.0.4") => {
                    text = quality.max(text)
                }
                _ => {}
            }
        }
        if open_metrics > 0.0 && open_metrics >= text {
            Self::OpenMetrics
        } else {
            Self::Prometheus
        }
    }

    /// The `Content-Type` of a page.
    pub fn content_type(self) -> &'static str {
        match self {
            Self::Prometheus => "text/plain; version=0.0.4; charset=utf-8",
            Self::OpenMetrics => "application/openmetrics-text; version=1.0.0; charset=utf-8",
        }
    }
}

/// A number that a sample can have. Counts are exact below 2⁵³.
pub trait Number: Copy {
    /// Returns the number.
    fn value(self) -> f64;
}

impl Number for u64 {
    fn value(self) -> f64 {
        self as f64
    }
}

impl Number for f64 {
    fn value(self) -> f64 {
        self
    }
}

impl Number for bool {
    fn value(self) -> f64 {
        f64::from(u8::from(self))
    }
}

/// A label of a sample: its name and its value.
pub type Label<'a> = (&'a str, &'a str);

/// A page under construction. Every sample has the fleet's name as a label.
#[derive(Debug)]
pub struct Exposition<'a> {
    format: Format,
    fleet: &'a str,
    text: String,
}

impl<'a> Exposition<'a> {
    /// Creates an empty page.
    pub fn new(format: Format, fleet: &'a str) -> Self {
        Self { format, fleet, text: String::new() }
    }

    /// Returns the text of the page.
    pub fn finish(mut self) -> String {
        if self.format == Format::OpenMetrics {
            self.text.push_str("# EOF\n");
        }
        self.text
    }

    /// Adds a family with one sample.
    pub fn one(&mut self, name: &str, help: &str, value: impl Number) {
        self.each(name, help, [([], value)]);
    }

    /// Adds a family of samples that differ in their labels, unless there are none. Names that end
    /// in `_total` are counters, those that end in `_info` are facts, all others gauges.
    pub fn each<'l, const LABELS: usize>(
        &mut self,
        name: &str,
        help: &str,
        samples: impl IntoIterator<Item = ([Label<'l>; LABELS], impl Number)>,
    ) {
        let mut samples = samples.into_iter().peekable();
        if samples.peek().is_none() {
            return;
        }
        // In OpenMetrics, the endings belong to the samples rather than to the family.
        let (family, kind) =
            match (self.format, name.strip_suffix("_total"), name.strip_suffix("_info")) {
                (Format::OpenMetrics, Some(family), _) => (family, "counter"),
                (Format::OpenMetrics, _, Some(family)) => (family, "info"),
                (Format::Prometheus, Some(_), _) => (name, "counter"),
                _ => (name, "gauge"),
            };
        self.head(family, help, kind);
        for (labels, value) in samples {
            self.sample(name, "", &labels, value.value());
        }
    }

    /// Adds a family of one histogram.
    pub fn histogram(&mut self, name: &str, help: &str, histogram: &Histogram) {
        self.head(name, help, "histogram");
        let mut cumulative = 0;
        for (bound, count) in BOUNDS.into_iter().zip(histogram.buckets) {
            cumulative += count;
            self.sample(name, "_bucket", &[("le", &self.bound(bound))], cumulative.value());
        }
        self.sample(name, "_bucket", &[("le", "+Inf")], histogram.count.value());
        self.sample(name, "_sum", &[], histogram.sum);
        self.sample(name, "_count", &[], histogram.count.value());
    }

    /// Adds a family of one summary. Without times, it has no quantiles.
    pub fn summary(&mut self, name: &str, help: &str, times: &TimeSummary) {
        self.head(name, help, "summary");
        if times.count > 0 {
            self.sample(name, "", &[("quantile", "0.5")], times.p50);
            self.sample(name, "", &[("quantile", "0.99")], times.p99);
        }
        self.sample(name, "_sum", &[], times.sum);
        self.sample(name, "_count", &[], times.count.value());
    }

    /// Returns the label of a bucket. OpenMetrics has one spelling of each number, that of Go:
    /// 1e-05, 0.5, 1.0.
    fn bound(&self, bound: f64) -> String {
        match self.format {
            Format::Prometheus => bound.to_string(),
            Format::OpenMetrics => format!("{bound:?}").replace("e-", "e-0"),
        }
    }

    fn head(&mut self, family: &str, help: &str, kind: &str) {
        // Writing to a string can't fail.
        let _ = writeln!(self.text, "# HELP {family} {help}\n# TYPE {family} {kind}");
    }

    fn sample(&mut self, name: &str, ending: &str, labels: &[Label<'_>], value: f64) {
        let _ = write!(self.text, "{name}{ending}{{fleet=\"{}\"", self.fleet);
        for (label, value) in labels {
            let value = value.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n");
            let _ = write!(self.text, ",{label}=\"{value}\"");
        }
        let _ = match value {
            f64::INFINITY => writeln!(self.text, "}} +Inf"),
            value => writeln!(self.text, "}} {value}"),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_format_is_what_the_client_prefers() {
        use Format::{OpenMetrics, Prometheus};
        // Of Prometheus 2 and 3, of a browser, of curl.
        let prometheus_2 = "application/openmetrics-text;version=1.0.0;q=0.5,application/openmetrics-text;version=0.0.1;q=0.4,text/plain;version=0.0.4;q=0.3,*/*;q=0.2";
        let prometheus_3 = "application/openmetrics-text;version=1.0.0;escaping=allow-utf-8;q=0.6,text/plain;version=1.0.0;q=0.4,text/plain;version=0.0.4;q=0.3,*/*;q=0.2";
        let cases = [
            (prometheus_2, OpenMetrics),
            (prometheus_3, OpenMetrics),
            ("text/html,application/xhtml+xml,application/xml;q=0.9,*/*;q=0.8", Prometheus),
            ("*/*", Prometheus),
            ("", Prometheus),
            ("application/openmetrics-text", OpenMetrics),
            ("application/openmetrics-text; version=\"1.0.0\"", OpenMetrics),
            ("application/openmetrics-text;version=0.0.1", Prometheus),
            ("application/openmetrics-text;q=0", Prometheus),
            ("application/openmetrics-text;q=0.2, text/plain;q=0.7", Prometheus),
            (";;,q=,=;q=x,\u{e9}", Prometheus),
        ];
        for (accept, format) in cases {
            assert_eq!(Format::accepted(accept), format, "{accept}");
        }
    }

    #[test]
    fn labels_are_escaped_and_infinity_is_spelled_as_prometheus_does() {
        for format in [Format::Prometheus, Format::OpenMetrics] {
            let mut page = Exposition::new(format, "f");
            page.each("a", "A.", [([("name", "a\"b\\c\nd")], f64::INFINITY)]);
            assert!(page.finish().contains(r#"a{fleet="f",name="a\"b\\c\nd"} +Inf"#));
        }
    }
}
