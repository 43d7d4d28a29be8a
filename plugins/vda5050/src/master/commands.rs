//! Commands of a fleet's manager to vehicles.

use regatta_plugin::command::{Authority, CommandKind, CommandRecord};
use regatta_plugin::event::{EventKind, EventRecord, Refusal};

use super::Master;
use super::course::{Refused, Step};

impl Master {
    /// Carries out a sample of commands. Each is answered by an event.
    pub(super) fn take_commands(&mut self, records: &[CommandRecord], authority: Authority) {
        let mut rest = records;
        while let [command, after @ ..] = rest {
            let legs =
                after.iter().take_while(|record| record.kind == CommandKind::Leg as u32).count();
            let own = if is_route(command) { legs.min(command.legs as usize) } else { 0 };
            let answer = self.carry_out(command, &after[..own], authority);
            self.events.push(answered(command, answer));
            // Legs without a command are one mistake and get one answer.
            let skipped = if command.kind == CommandKind::Leg as u32 { legs } else { own };
            rest = &after[skipped..];
        }
    }

    fn carry_out(
        &mut self,
        command: &CommandRecord,
        legs: &[CommandRecord],
        authority: Authority,
    ) -> Result<(), Refused> {
        let robot = command.robot;
        let Some(kind) = CommandKind::from_number(command.kind) else {
            return refuse(Refusal::MalformedCommand, robot);
        };
        if kind.moves() && authority == Authority::WithoutMovement {
            return refuse(Refusal::NotOwner, robot);
        }
        match kind {
            CommandKind::CloseEdge | CommandKind::OpenEdge => {
                let edge = self.roads.edge_with_number(command.id);
                let edge = edge.ok_or(Refused { reason: Refusal::UnknownEdge, id: command.id })?;
                self.set_closed(edge, kind == CommandKind::CloseEdge);
                Ok(())
            }
            CommandKind::Assign | CommandKind::Extend => self.extend(command, legs, kind),
            CommandKind::Release => self.release(command),
            CommandKind::Cancel
            | CommandKind::Hold
            | CommandKind::Resume
            | CommandKind::Remove
            | CommandKind::Repair => self.change(kind, robot),
            CommandKind::Leg => refuse(Refusal::MalformedCommand, robot),
            _ => refuse(Refusal::NotSteerable, robot),
        }
    }

    /// Carries out a command that needs no route.
    fn change(&mut self, kind: CommandKind, robot: u32) -> Result<(), Refused> {
        let Some((_, vehicle)) = self.vehicles.get_mut(robot as usize) else {
            return refuse(Refusal::UnknownRobot, robot);
        };
        let is_possible = match kind {
            CommandKind::Remove => vehicle.remove(),
            CommandKind::Repair => vehicle.accept_load(),
            CommandKind::Cancel => {
                vehicle.cancel(&self.roads);
                true
            }
            _ => {
                vehicle.hold(kind == CommandKind::Hold);
                true
            }
        };
        if is_possible { Ok(()) } else { refuse(Refusal::NotSteerable, robot) }
    }

    fn extend(
        &mut self,
        command: &CommandRecord,
        records: &[CommandRecord],
        kind: CommandKind,
    ) -> Result<(), Refused> {
        if records.len() != command.legs as usize {
            return refuse(Refusal::MalformedCommand, command.robot);
        }
        let mut legs = Vec::with_capacity(records.len());
        for record in records {
            let leg = self.roads.leg(record.id, record.reverse != 0);
            let leg = leg.ok_or(Refused { reason: Refusal::UnknownEdge, id: record.id })?;
            if self.is_closed(leg.edge.0) {
                return refuse(Refusal::EdgeClosed, record.id);
            }
            legs.push(Step { leg, released: record.released != 0 });
        }
        let Some((_, vehicle)) = self.vehicles.get_mut(command.robot as usize) else {
            return refuse(Refusal::UnknownRobot, command.robot);
        };
        match vehicle.course_mut() {
            None => refuse(Refusal::NotConnected, command.robot),
            // The base that a vehicle has can't be taken back at once.
            Some(course) if kind == CommandKind::Assign && course.has_base_ahead() => {
                refuse(Refusal::NotSteerable, command.robot)
            }
            Some(course) => course.extend(&legs, &self.roads),
        }
    }

    fn release(&mut self, command: &CommandRecord) -> Result<(), Refused> {
        let leg = self.roads.leg(command.id, command.reverse != 0);
        let leg = leg.ok_or(Refused { reason: Refusal::UnknownEdge, id: command.id })?;
        if command.s.is_nan() || command.s < 0.0 {
            return refuse(Refusal::DistanceOutOfRange, command.id);
        }
        let Some((_, vehicle)) = self.vehicles.get_mut(command.robot as usize) else {
            return refuse(Refusal::UnknownRobot, command.robot);
        };
        match vehicle.course_mut() {
            None => refuse(Refusal::NotConnected, command.robot),
            Some(course) => course.release(leg, f64::from(command.s), &self.roads),
        }
    }
}

fn is_route(command: &CommandRecord) -> bool {
    [CommandKind::Assign as u32, CommandKind::Extend as u32].contains(&command.kind)
}

fn refuse(reason: Refusal, id: u32) -> Result<(), Refused> {
    Err(Refused { reason, id })
}

fn answered(command: &CommandRecord, answer: Result<(), Refused>) -> EventRecord {
    let (kind, id, detail) = match answer {
        Ok(()) => (EventKind::Accepted, 0, 0),
        Err(Refused { reason, id }) => (EventKind::Refused, id, reason as u32),
    };
    EventRecord { token: command.token, kind: kind as u32, robot: command.robot, id, detail }
}
