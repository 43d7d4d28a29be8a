//! Colours: the two themes, and the colouring of robots by their data. The hues are Okabe and
//! Ito's, which are distinguishable with any colour vision; ramps also increase in lightness.

use core::fmt;
use core::str::FromStr;

use glam::Vec3;
use regatta_plugin::ColumnName;
use regatta_plugin::activity::{Activity, Ground};
use regatta_plugin::column::{ACTIVITY, COLLISION};
use regatta_plugin::frame::RobotState;

/// The number of colours of a ramp, and the most colours of a set of categories.
pub const COLOURS: usize = 16;

/// An sRGB colour, 0xRRGGBB.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rgb(pub u32);

/// Closed edges, in both themes; the same as in closures.wgsl.
pub const CLOSED: Rgb = Rgb(0xd8232f);

/// A colour theme.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Theme {
    /// Light objects on a dark floor.
    #[default]
    Dark,
    /// Dark objects on a light floor.
    Light,
}

/// The colours of everything except robots.
#[derive(Clone, Copy, Debug)]
pub struct ThemeColours {
    /// The sky.
    pub sky: Rgb,
    /// The floor.
    pub floor: Rgb,
    /// The floor's grid.
    pub grid: Rgb,
    /// Walls, and the outlines of floors.
    pub wall: Rgb,
    /// Racks.
    pub rack: Rgb,
    /// Edges that are driven one way.
    pub edge: Rgb,
    /// Edges that are driven both ways.
    pub two_way: Rgb,
    /// Nodes.
    pub node: Rgb,
    /// The ring around selected objects.
    pub selection: Rgb,
    /// Routes and goals.
    pub route: Rgb,
    /// Arrows to robots that are waited for.
    pub waiting: Rgb,
    /// Arrows of rings of robots that wait for each other.
    pub ring: Rgb,
    /// Robots without a value.
    pub unknown: Rgb,
}

/// The data that robots are coloured by.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Colouring {
    /// The robot's state.
    #[default]
    State,
    /// The robot's speed.
    Speed,
    /// The robot's type.
    Type,
    /// The robot's value in a column that a plugin publishes.
    Column(ColumnName),
}

/// The mapping from values to colours.
#[derive(Clone, Debug, PartialEq)]
pub enum Scale {
    /// The value is an index into named colours.
    Categories(Vec<(String, Rgb)>),
    /// The value is interpolated between two ends.
    Ramp {
        /// The value of the ramp's first colour.
        low: f32,
        /// The value of the ramp's last colour.
        high: f32,
        /// The unit of the values.
        unit: &'static str,
    },
}

/// The meaning of the robots' colours.
#[derive(Clone, Debug, PartialEq)]
pub struct Legend {
    /// Name of the data: `collision`, `speed` …
    pub title: String,
    /// The mapping from values to colours.
    pub scale: Scale,
}

impl Legend {
    /// Returns the legend of a column that has no publisher.
    #[must_use]
    pub fn without_data(self, theme: Theme) -> Self {
        let reason = if self.title == COLLISION.name() { "not checked" } else { "not published" };
        Self {
            scale: Scale::Categories(vec![(reason.to_owned(), theme.colours().unknown)]),
            ..self
        }
    }
}

const SKY_BLUE: Rgb = Rgb(0x56b4e9);
const BLUE: Rgb = Rgb(0x0072b2);
const ORANGE: Rgb = Rgb(0xe69f00);
const GREEN: Rgb = Rgb(0x009e73);
const YELLOW: Rgb = Rgb(0xf0e442);
const VERMILLION: Rgb = Rgb(0xd55e00);
const PURPLE: Rgb = Rgb(0xcc79a7);

/// The colour map viridis in sixteen steps.
const RAMP: [u32; COLOURS] = [
    0x440154, 0x481a6c, 0x472f7d, 0x414487, 0x39568c, 0x31688e, 0x2a788e, 0x23888e, 0x1f988b,
    0x22a884, 0x35b779, 0x54c568, 0x7ad151, 0xa5db36, 0xd2e21b, 0xfde725,
];

impl Rgb {
    /// Returns a colour between this one and another one, in equal steps for `part` from 0 to 1.
    #[must_use]
    pub fn mix(self, other: Self, part: f32) -> Self {
        let mut mixed = 0;
        for shift in [16, 8, 0] {
            let [from, to] = [self.0, other.0].map(|colour| ((colour >> shift) & 0xff) as f32);
            mixed |= ((from + (to - from) * part).round() as u32) << shift;
        }
        Self(mixed)
    }

    /// Linear red, green and blue, 0 to 1.
    pub fn linear(self) -> Vec3 {
        Vec3::from([16, 8, 0].map(|shift| {
            let value = ((self.0 >> shift) & 0xff) as f32 / 255.0;
            if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
        }))
    }
}

impl Theme {
    /// The colours of everything except robots.
    pub fn colours(self) -> ThemeColours {
        match self {
            Self::Dark => ThemeColours {
                sky: Rgb(0x0b0f14),
                floor: Rgb(0x151b22),
                grid: Rgb(0x2c3742),
                wall: Rgb(0x87919b),
                rack: Rgb(0x5f5443),
                edge: Rgb(0x6d8196),
                two_way: Rgb(0x8a7fb0),
                node: Rgb(0x93a5b5),
                selection: Rgb(0xffffff),
                route: Rgb(0x24c79b),
                waiting: Rgb(0xffb000),
                ring: Rgb(0xff2d3a),
                unknown: Rgb(0xa8adb2),
            },
            Self::Light => ThemeColours {
                sky: Rgb(0xdfe5ea),
                floor: Rgb(0xf4f6f8),
                grid: Rgb(0xd3dae0),
                wall: Rgb(0x737c85),
                rack: Rgb(0xc9b794),
                edge: Rgb(0x8f9dab),
                two_way: Rgb(0xa497c6),
                node: Rgb(0x6d7b88),
                selection: Rgb(0x111111),
                route: GREEN,
                waiting: Rgb(0xc77d00),
                ring: Rgb(0xc40018),
                unknown: Rgb(0x767c82),
            },
        }
    }
}

impl Theme {
    /// The ground on which its colours are seen.
    pub fn ground(self) -> Ground {
        match self {
            Self::Dark => Ground::Dark,
            Self::Light => Ground::Light,
        }
    }

    /// The colour of a robot's activity, also outside of the picture.
    pub fn activity_colour(self, activity: Activity) -> Rgb {
        Rgb(activity.colour(self.ground()))
    }

    /// The colour of a robot's state: that of its activity.
    pub fn state_colour(self, state: RobotState) -> Rgb {
        Activity::of_state(state).map_or(Rgb(0x999999), |activity| self.activity_colour(activity))
    }
}

impl Colouring {
    /// By what each robot is doing, as a fleet manager publishes it.
    pub fn activity() -> Self {
        Self::Column(ACTIVITY.name().parse().expect("a name"))
    }

    /// By the collisions that a collision checker finds.
    pub fn collision() -> Self {
        Self::Column(COLLISION.name().parse().expect("a name"))
    }

    /// Returns the legend. `robot_types` are the names of the robot types, `range` the range of the
    /// values seen so far.
    pub fn legend(
        &self,
        theme: Theme,
        robot_types: &[String],
        range: Option<(f32, f32)>,
    ) -> Legend {
        let scale = match self {
            Self::State => states(theme),
            Self::Type => {
                let hues =
                    [SKY_BLUE, ORANGE, GREEN, PURPLE, BLUE, YELLOW, VERMILLION, Rgb(0x999999)];
                Scale::Categories(
                    robot_types
                        .iter()
                        .cloned()
                        .zip(hues.into_iter().cycle())
                        .take(COLOURS)
                        .collect(),
                )
            }
            Self::Speed => {
                let (low, high) = range.unwrap_or((0.0, 1.5));
                Scale::Ramp { low, high, unit: "m/s" }
            }
            Self::Column(name) if name.as_str() == COLLISION.name() => collisions(theme),
            Self::Column(name) if name.as_str() == ACTIVITY.name() => activities(theme),
            Self::Column(_) => {
                let (low, high) = range.unwrap_or((0.0, 1.0));
                Scale::Ramp { low, high, unit: "" }
            }
        };
        Legend { title: self.to_string(), scale }
    }
}

/// The states of robots that are there, in the order of their numbers.
const STATES: [RobotState; RobotState::COUNT] = [
    RobotState::Idle,
    RobotState::Driving,
    RobotState::Waiting,
    RobotState::Held,
    RobotState::Faulted,
    RobotState::Turning,
    RobotState::Stalled,
    RobotState::Broken,
];

fn states(theme: Theme) -> Scale {
    Scale::Categories(
        STATES.map(|state| (state.name().to_owned(), theme.state_colour(state))).to_vec(),
    )
}

fn activities(theme: Theme) -> Scale {
    Scale::Categories(
        Activity::ALL
            .map(|activity| (activity.name().to_owned(), theme.activity_colour(activity)))
            .to_vec(),
    )
}

fn collisions(theme: Theme) -> Scale {
    let (clear, possible) =
        if theme == Theme::Dark { (SKY_BLUE, YELLOW) } else { (Rgb(0x3b7fb5), Rgb(0xf0ac00)) };
    let levels = [("clear", clear), ("possible", possible), ("touching", VERMILLION)];
    Scale::Categories(levels.map(|(name, colour)| (name.to_owned(), colour)).to_vec())
}

impl Scale {
    /// Returns the colours by index. Beyond the end of categories, the last colour is repeated.
    pub fn colours(&self, theme: Theme) -> [Rgb; COLOURS] {
        match self {
            Self::Categories(categories) => std::array::from_fn(|i| {
                categories.get(i).or(categories.last()).map_or(Rgb(0x999999), |(_, colour)| *colour)
            }),
            // The end of the ramp that is close to the floor's colour is left out.
            Self::Ramp { .. } => std::array::from_fn(|i| {
                let (first, last) =
                    if theme == Theme::Dark { (4, COLOURS - 1) } else { (0, COLOURS - 3) };
                Rgb(RAMP[first + i * (last - first) / (COLOURS - 1)])
            }),
        }
    }
}

impl fmt::Display for Colouring {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::State => f.write_str("state"),
            Self::Speed => f.write_str("speed"),
            Self::Type => f.write_str("type"),
            Self::Column(name) => write!(f, "{name}"),
        }
    }
}

impl FromStr for Colouring {
    type Err = regatta_plugin::NameError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(match text {
            "state" => Self::State,
            "speed" => Self::Speed,
            "type" => Self::Type,
            column => Self::Column(column.parse()?),
        })
    }
}

// The ramps of the heat map were computed in OKLab (Björn Ottosson, 2020): lightness changes in one
// direction, hue goes from purple by red to yellow, and the sixteen colours are at equal distances on
// a way that keeps away from the colours of activities, seen with any colour vision.
// Much is what differs most from the floor: bright on a dark floor, dark on a light one.
const DARK_HEAT: [u32; COLOURS] = [
    0x59005d, 0x6d0b67, 0x83116e, 0x9b0c72, 0xb30777, 0xca1184, 0xda348a, 0xe64e89, 0xef6586,
    0xf07d86, 0xf19386, 0xf6a680, 0xfeb97f, 0xfecd7f, 0xfde28a, 0xf5f7a7,
];
const LIGHT_HEAT: [u32; COLOURS] = [
    0xf5e26d, 0xfacd4f, 0xfdb83f, 0xfda330, 0xfc8e22, 0xf17a11, 0xe76501, 0xda5214, 0xc94429,
    0xb63a34, 0xa13136, 0x8c2d3d, 0x752b3e, 0x5e2c41, 0x4b2440, 0x391b3d,
];

/// Returns the colours of the heat map, from cold to hot: equal steps of a value are equal
/// steps of colour.
pub fn heat_ramp(theme: Theme) -> [Rgb; COLOURS] {
    if theme == Theme::Dark { DARK_HEAT.map(Rgb) } else { LIGHT_HEAT.map(Rgb) }
}

#[cfg(test)]
mod tests;
