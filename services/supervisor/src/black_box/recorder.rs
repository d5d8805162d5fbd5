//! The recorder of one robot: what stays on its tape, and when a box begins and ends.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use vibrissa_core::robot::Robot;
use vibrissa_core::units::Micros;
use vibrissa_edge::black_box::StateBytes;
use vibrissa_protocol::{Name, RobotTopic};

use super::job::{BoxToWrite, Job};
use super::reel::Reel;
use super::tape::EntryKind;
use super::{FleetBoxes, Inner};

/// A box with several events ends at the latest this many spans after the first.
const SPANS_MAX: u64 = 4;
/// Shortest interval between two writes of a box that is not finished.
const WRITE_PAUSE: Micros = Micros(5_000_000);
/// How long a finished box waits for a writer before it is given up.
const PATIENCE: Micros = Micros(60_000_000);

/// The robot whose box is written.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Whose<'a> {
    pub(crate) robot_id: i64,
    pub(crate) name: &'a Name,
}

/// Recorder of a robot.
#[derive(Debug)]
pub(crate) struct Recorder {
    inner: Arc<Inner>,
    boxes: FleetBoxes,
    reel: Reel,
    open: Option<Open>,
}

/// A box that is being recorded.
#[derive(Debug)]
struct Open {
    cause: &'static str,
    whisker_id: i64,
    event: Micros,
    ends: Micros,
    left_out: u64,
    /// The row in the database is older than the newest event.
    is_due: bool,
    written: Micros,
}

impl FleetBoxes {
    /// A recorder for a robot that is heard from `now` on; `None` if no boxes are wanted.
    pub(crate) fn recorder(&self, robot_id: i64, now: Micros) -> Option<Box<Recorder>> {
        let inner = self.inner.clone()?;
        inner.robots.fetch_add(1, Ordering::Relaxed);
        // States of different robots are not due at the same time.
        let phase = robot_id.unsigned_abs().wrapping_mul(0x9E37_79B9_7F4A_7C15) % inner.span.0.max(1);
        let reel = Reel::new(now, Micros(now.0.saturating_sub(phase)));
        Some(Box::new(Recorder { inner, boxes: self.clone(), reel, open: None }))
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        self.inner.robots.fetch_sub(1, Ordering::Relaxed);
    }
}

impl Recorder {
    /// Records a message from or to the robot, which the robot's state does not contain yet. A due state is put on the tape
    /// before it: ticks alone come too late for that when the supervisor has much to do.
    pub(crate) fn message(&mut self, robot: &Robot, topic: RobotTopic, at: Micros, payload: &[u8]) {
        self.put_due_state(robot, at);
        self.push(at, EntryKind::Message(topic), payload);
    }

    /// Puts the robot's state on the tape, if it is due.
    fn put_due_state(&mut self, robot: &Robot, now: Micros) {
        let limits = self.inner.limits();
        if !self.reel.is_state_due(now, limits) {
            return;
        }
        let state = StateBytes::within(robot, limits.state_max());
        let bytes = state.as_ref().map_or(usize::MAX, StateBytes::bytes);
        if self.reel.takes_state(now, bytes, limits)
            && let Some(StateBytes { head, whiskers }) = state
            && let Ok(bytes) = borsh::to_vec(&(head, whiskers))
        {
            self.push(now, EntryKind::State, &bytes);
        }
    }

    fn push(&mut self, at: Micros, kind: EntryKind, payload: &[u8]) {
        let limits = self.inner.limits();
        let Some(open) = &mut self.open else { return self.reel.push(at, kind, payload, limits) };
        let fits = self.reel.push_after_event(at, kind, payload, limits);
        if !fits && kind != EntryKind::State && at <= open.ends {
            open.left_out += 1;
        }
    }

    /// A trim, a fault or an alarm: opens a box, or extends the open one.
    pub(crate) fn event(&mut self, cause: &'static str, whisker_id: i64, at: Micros, whose: Whose<'_>) {
        let span = self.inner.span;
        if self.open.as_ref().is_some_and(|open| at > open.ends) {
            self.write(whose, at, true);
            self.close();
        }
        match &mut self.open {
            Some(open) => {
                let latest = open.event.after(Micros(SPANS_MAX * span.0));
                let ends = at.after(span).min(latest);
                open.is_due |= ends > open.ends;
                open.ends = open.ends.max(ends);
            }
            open => {
                self.reel.begin_box();
                *open = Some(Open {
                    cause,
                    whisker_id,
                    event: at,
                    ends: at.after(span),
                    left_out: 0,
                    is_due: true,
                    written: Micros::default(),
                });
                self.write(whose, at, false);
            }
        }
    }

    /// Puts the robot's state on the tape, if it is due, and writes the open box if that is due.
    pub(crate) fn tick(&mut self, robot: &Robot, whose: Whose<'_>, now: Micros) {
        self.put_due_state(robot, now);
        let Some(open) = &self.open else { return };
        if now > open.ends {
            if self.write(whose, now, true) || now > open_end(&self.open).after(PATIENCE) {
                self.close();
                self.reel.forget_old(now, self.inner.limits());
            }
        } else if open.is_due && now >= open.written.after(WRITE_PAUSE) {
            self.write(whose, now, false);
        }
    }

    /// Ends the open box before its time.
    pub(crate) fn end(&mut self, whose: Whose<'_>, now: Micros) {
        if self.open.is_some() {
            self.write(whose, now, true);
            self.close();
        }
    }

    /// Closes the open box, and counts it as lost if the writer did not take its end.
    fn close(&mut self) {
        if self.open.take().is_some_and(|open| open.is_due) {
            self.boxes.lost.inc();
        }
    }

    /// Hands a copy of the tape to the writer; returns false if it is too busy.
    fn write(&mut self, whose: Whose<'_>, now: Micros, is_end: bool) -> bool {
        let Some(open) = &mut self.open else { return true };
        let Ok(place) = self.inner.jobs.try_reserve() else {
            open.is_due = true;
            return false;
        };
        (open.is_due, open.written) = (false, now);
        let has_begin = self.reel.from() <= Micros(open.event.0.saturating_sub(self.inner.span.0));
        let state = match (is_end, has_begin && open.left_out == 0 && now >= open.ends) {
            (false, _) => "RECORDING",
            (true, true) => "COMPLETE",
            (true, false) => "PARTIAL",
        };
        place.send(Job::Write(Box::new(BoxToWrite {
            lease: self.boxes.lease.clone(),
            lost: self.boxes.lost.clone(),
            robot_id: whose.robot_id,
            robot: whose.name.clone(),
            whisker_id: open.whisker_id,
            cause: open.cause,
            event: open.event,
            from: self.reel.from(),
            ends: open.ends,
            left_out: open.left_out,
            state,
            base: self.reel.base().clone(),
            tape: self.reel.copy(),
        })));
        true
    }
}

fn open_end(open: &Option<Open>) -> Micros {
    open.as_ref().map_or(Micros::default(), |open| open.ends)
}
