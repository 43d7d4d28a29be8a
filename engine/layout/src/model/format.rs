//! The formats of layouts.

use std::fmt;

/// A format of route graphs.
///
/// ```
/// use regatta_layout::Format;
///
/// assert_eq!("LIF".parse(), Ok(Format::Lif));
/// assert_eq!(Format::OpenRmfBuilding.name(), "open-rmf-building");
/// ```
#[derive(
    Clone,
    Copy,
    Debug,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    strum::IntoStaticStr,
    strum::VariantArray,
)]
#[strum(serialize_all = "kebab-case")]
pub enum Format {
    /// Our own YAML, that of the institute.
    Regatta,
    /// VDMA Layout Interchange Format 1.0: JSON.
    Lif,
    /// A navigation graph of Open-RMF: YAML.
    OpenRmf,
    /// A building map of Open-RMF's traffic editor: YAML.
    OpenRmfBuilding,
    /// A graph of Nav2's Route Server: GeoJSON.
    Nav2,
    /// A plant model of openTCS: XML.
    #[strum(serialize = "opentcs")]
    OpenTcs,
    /// A grid map of the MovingAI benchmarks.
    #[strum(serialize = "movingai")]
    MovingAi,
    /// A drawing: DXF in ASCII.
    Dxf,
    /// Tables of nodes and edges.
    Csv,
    /// A map of the ROS map server: YAML and a picture.
    RosMap,
}

regatta_base::named!(Format, "a format");

impl Format {
    /// Whether files of the format are YAML.
    pub(crate) fn is_yaml(self) -> bool {
        matches!(self, Self::Regatta | Self::OpenRmf | Self::OpenRmfBuilding | Self::RosMap)
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A graph as the text of another format.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Written {
    /// The content of the file.
    pub text: String,
    /// The parts of the graph that the format can't express, one line each.
    pub losses: Vec<String>,
}
