//! A row of a table: a node or an edge.

use ::csv::StringRecord;
use glam::DVec2;
use regatta_base::Decimal;

use super::columns::{Columns, Field, Unit};
use super::{Place, Reader};
use crate::check::angles::SUSPICIOUS_ANGLE;
use crate::model::tags::{Role, Tags};
use crate::model::value::shorten;
use crate::read::layout::{LayoutEdge, LayoutNode};

/// A row, with the columns of its table.
#[derive(Clone, Copy)]
pub(super) struct Row<'a> {
    pub columns: &'a Columns,
    pub cells: &'a StringRecord,
    pub place: Place,
    /// Whether numbers may be written as `1,5`.
    pub has_decimal_comma: bool,
}

/// An edge before its nodes are known.
pub(super) struct EdgeRow {
    /// The edge, without ends and shape.
    pub edge: LayoutEdge,
    pub from: String,
    pub to: String,
    /// Inner control points in metres: none, one or two.
    pub control_points: Vec<DVec2>,
    pub is_bidirectional: bool,
}

impl<'a> Row<'a> {
    pub fn node(self, reader: &mut Reader<'_, '_>) -> Option<LayoutNode> {
        let id = self.text(Field::Id);
        if id.is_none() {
            reader.error(self.place, "a node has no id: give one");
        }
        let [x, y] = [Field::X, Field::Y].map(|field| self.length(field, reader));
        if !self.has_all([Field::X, Field::Y]) {
            let id = shorten(id.unwrap_or("?"));
            reader.error(self.place, &format!("node `{id}` has no x or no y: give both"));
        }
        let heading = self.heading(reader);
        let mut tags = self.tags();
        let role = self.text(Field::Role).map_or(Role::None, |text| {
            text.parse().unwrap_or_else(|error: regatta_base::name::UnknownName| {
                reader.warning(self.place, &format!("{error}: it is kept as a property"));
                tags.set("role", text);
                Role::None
            })
        });
        Some(LayoutNode {
            at: reader.at(self.place),
            id: id?.to_owned(),
            position: x.zip(y).map(DVec2::from),
            heading,
            role,
            tags,
        })
    }

    pub fn edge(self, reader: &mut Reader<'_, '_>) -> Option<EdgeRow> {
        let has_ids = self.columns.list.iter().any(|column| column.field == Field::Id);
        let counted = (!has_ids).then(|| (reader.edges.len() + 1).to_string());
        let id = counted.or_else(|| self.text(Field::Id).map(str::to_owned));
        if id.is_none() {
            reader.error(self.place, "an edge has no id: give one, or remove the column");
        }
        let ends = self.text(Field::From).zip(self.text(Field::To));
        if ends.is_none() {
            reader.error(self.place, "an edge has no ends: give the ids of nodes in both columns");
        }
        let [speed, reverse] =
            [Field::Speed, Field::ReverseSpeed].map(|field| self.converted(field, 1.0, reader));
        let mut tags = self.tags();
        if let Some(heading) = self.text(Field::Theta) {
            tags.set("heading", heading);
        }
        let is_bidirectional = self.truth(Field::Bidirectional, reader);
        let control_points = self.control_points(reader);
        let (from, to) = ends?;
        let edge = LayoutEdge {
            at: reader.at(self.place),
            id: id?,
            speed,
            reverse_speed: reverse.filter(|speed| *speed != 0.0),
            tags,
            ..LayoutEdge::default()
        };
        Some(EdgeRow {
            edge,
            from: from.to_owned(),
            to: to.to_owned(),
            control_points,
            is_bidirectional,
        })
    }

    fn control_points(self, reader: &mut Reader<'_, '_>) -> Vec<DVec2> {
        let [x1, y1, x2, y2] =
            [Field::X1, Field::Y1, Field::X2, Field::Y2].map(|field| self.length(field, reader));
        let given = [Field::X1, Field::Y1, Field::X2, Field::Y2];
        match given.map(|field| self.text(field).is_some()) {
            [false, false, false, false]
            | [true, true, false, false]
            | [true, true, true, true] => {}
            _ => reader.error(
                self.place,
                "a control point is incomplete: give x1 and y1, or these and x2 and y2",
            ),
        }
        let points = [x1.zip(y1), x2.zip(y2)];
        points.into_iter().map_while(|point| Some(DVec2::from(point?))).collect()
    }

    /// Whether no cell of some columns is missing or empty.
    fn has_all<const N: usize>(self, fields: [Field; N]) -> bool {
        fields.into_iter().all(|field| self.text(field).is_some())
    }

    fn tags(self) -> Tags {
        let [name, level, zone] =
            [Field::Name, Field::Level, Field::Zone].map(|field| self.text(field).map(Box::from));
        let mut tags = Tags { name, level, zone, ..Tags::default() };
        for (index, column) in self.columns.properties() {
            tags.set(&column.name, self.cells.get(index).unwrap_or_default());
        }
        tags
    }

    /// Returns the cell of a column; `None` if there is none, or if it is empty.
    fn text(self, field: Field) -> Option<&'a str> {
        let index = self.columns.list.iter().position(|column| column.field == field)?;
        self.cells.get(index).filter(|cell| !cell.is_empty())
    }

    /// Returns the number of a column with its unit. A text that isn't a number is an error.
    fn number(self, field: Field, reader: &mut Reader<'_, '_>) -> Option<(f64, Option<Unit>)> {
        let text = self.text(field)?;
        let column = self.columns.list.iter().find(|column| column.field == field)?;
        let number: Option<f64> = match self.has_decimal_comma {
            true => Decimal::parse(text).map(|number| {
                reader.points.add(reader.at(self.place), &column.name, text, number);
                number.number()
            }),
            false => text.parse().ok(),
        };
        let number = number.filter(|number| number.is_finite());
        if number.is_none() {
            reader.error(
                self.place,
                &format!("`{}` is `{}`: give a number", shorten(&column.name), shorten(text)),
            );
        }
        number.map(|number| (number, column.unit))
    }

    /// Returns a number in the unit of its column, or else times a scale.
    fn converted(self, field: Field, scale: f64, reader: &mut Reader<'_, '_>) -> Option<f64> {
        let (number, unit) = self.number(field, reader)?;
        Some(unit.map_or(number * scale, |unit| unit.convert(number)))
    }

    /// Returns a heading in radians, and warns of one without a unit that is probably in degrees.
    fn heading(self, reader: &mut Reader<'_, '_>) -> Option<f64> {
        let (number, unit) = self.number(Field::Theta, reader)?;
        if unit.is_none() {
            reader.has_doubtful_angles = true;
            if number.abs() > SUSPICIOUS_ANGLE {
                reader.warning(
                    self.place,
                    "a heading without a unit is more than a full turn in radians: if all are \
                     degrees, name the column `theta [deg]`, or let `graph check --fix` convert \
                     them",
                );
            }
        }
        Some(unit.map_or(number, |unit| unit.convert(number)))
    }

    /// Returns a number in metres.
    fn length(self, field: Field, reader: &mut Reader<'_, '_>) -> Option<f64> {
        self.converted(field, reader.scale, reader)
    }

    fn truth(self, field: Field, reader: &mut Reader<'_, '_>) -> bool {
        match self.text(field).map(str::to_lowercase).as_deref() {
            Some("true" | "yes" | "y" | "1" | "x" | "ja" | "wahr") => true,
            Some("false" | "no" | "n" | "0" | "nein" | "falsch") | None => false,
            Some(other) => {
                let message = format!(
                    "bidirectional is `{}`: it is read as no; use yes or no",
                    shorten(other)
                );
                reader.warning(self.place, &message);
                false
            }
        }
    }
}

/// Whether a number has one to three digits, a point and three digits: thousands, or decimals.
pub(super) fn is_grouped(number: &str) -> bool {
    let digits = number.trim_start_matches('-');
    digits.split_once('.').is_some_and(|(whole, group)| {
        (1..=3).contains(&whole.len()) && !whole.starts_with('0') && group.len() == 3
    })
}
