//! Attacks on the real program: one robot with its own password, or anyone who reaches a port, tries to stop or mislead a fleet.
