//! Commands of the program that need no broker and no database.

mod mechanics;
mod program;
mod recording;
mod stopping;
