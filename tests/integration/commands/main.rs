//! Commands of the program that need no broker and no database.

mod bench;
mod mechanics;
mod options;
mod program;
mod recording;
mod stopping;
