//! Notes on robots.

use serde::Serialize;
use utoipa::ToSchema;

use super::sorts;
use crate::from_row::from_row;
use crate::list::List;
use crate::time::Time;

from_row! {
    /// A note on a robot.
    #[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
    pub struct Note {
        /// Number of the note.
        #[schema(minimum = 0)]
        pub note_id: i64,
        /// Name of the fleet.
        pub fleet: String,
        /// Name of the robot.
        pub robot: String,
        /// Time at which the note was written, by the supervisor's clock.
        pub written_at: Time,
        /// Person or token that wrote the note.
        pub author: String,
        /// Plain text of the note; lines end with a line feed.
        pub text: String,
    }
}

sorts! {
    /// Sort keys of the list of notes.
    pub enum NoteSort {
        /// By the order in which they were written.
        NoteId = "note_id" Whole Down,
    }
}

/// All notes on robots.
pub static NOTES: List = List {
    what: "list the notes",
    select: "SELECT note_id, action_id, fleet, robot, written_us AS written_at, author, text \
             FROM notes n JOIN robots r ON r.robot_id = n.robot_id",
    details: "",
    keys: &[],
    sorts: NoteSort::SORTS,
    id: "note_id",
};
