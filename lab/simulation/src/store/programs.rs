//! Two versions of the program. The next one writes the states of robots and whiskers with the next number of their version,
//! as a release does that changes these bytes. The present one must leave such a robot alone.

use vibrissa_store::fault::{self, Fault};

use super::ModelStore;

/// A version of the program.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Program {
    /// The present one.
    #[default]
    Present,
    /// The next one, which reads the states of the present one, too.
    Next,
}

/// The bytes of a state, and the program that has written them.
#[derive(Debug, Clone)]
pub(super) struct State {
    bytes: Vec<u8>,
    program: Program,
}

impl ModelStore {
    /// Tells which program asks from now on.
    pub fn set_program(&mut self, program: Program) {
        self.program = program;
    }

    /// Takes the robots whose state the present program has changed although the next one had written it.
    pub fn take_overwritten(&mut self) -> Vec<i64> {
        std::mem::take(&mut self.overwritten)
    }

    /// A state that the program writes in the place of another one.
    pub(super) fn state(&mut self, robot_id: i64, former: Option<Program>, bytes: &[u8]) -> State {
        let program = self.program;
        if former.is_some_and(|former| former > program) {
            self.overwritten.push(robot_id);
        }
        State { bytes: bytes.to_vec(), program }
    }

    /// A state as the program reads it. The first byte has the lowest bits of the version.
    pub(super) fn read(&self, state: &State) -> Vec<u8> {
        let mut bytes = state.bytes.clone();
        let is_newer = state.program > self.program && !fault::is(Fault::NewerStateRead);
        if let Some(version) = bytes.first_mut().filter(|_| is_newer) {
            *version += 1;
        }
        bytes
    }
}

impl State {
    pub(super) const fn program(&self) -> Program {
        self.program
    }
}
