//! An agent with two drivers: one has the gauge and the chamber, and another one moves the whisker.

use std::process::{Child, Command, Stdio};

use crate::driver::{Bench, Driver, Role};

/// Touches until a contact must have been found.
const TOUCHES: usize = 12;

/// An agent that ends with the test.
struct Agent(Child);

impl Drop for Agent {
    fn drop(&mut self) {
        let _ = self.0.kill().and_then(|()| self.0.wait());
    }
}

#[test]
fn strain_of_a_board_and_motion_of_a_stage_become_contacts_of_the_agent() {
    let folder = std::env::temp_dir().join(format!("vibrissa-several-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let board = Driver::start(Role::Gauge, Bench { per_mm: 0.004, ..Bench::new() });
    let stage = board.beside(Role::Stage);
    let text = format!(
        "fleet = \"lab\"\nrobot = \"bench\"\n[broker]\nurl = \"mqtt://127.0.0.1:1\"\n[outbox]\nfile = \"outbox\"\n\
         [[driver]]\nname = \"board\"\ntcp = \"{}\"\n[[driver]]\nname = \"stage\"\ntcp = \"{}\"\n\
         [[arrays]]\narray = \"left\"\ntype = \"TYPE_2\"\n\
         whiskers = [{{ whisker = 0, length_mm = 70.0, pressure_mpa = 0.0, pressure_max_mpa = 0.2, place = \"UNKNOWN\" }}]\n",
        board.address, stage.address
    );
    let path = folder.join("agent.toml");
    std::fs::write(&path, text).unwrap();
    let program = || Command::new(env!("CARGO_BIN_EXE_vibrissa-robot"));
    let log = std::fs::File::create(folder.join("log")).unwrap();
    let agent = program().arg("--config").arg(&path).stdout(log.try_clone().unwrap()).stderr(log).spawn().unwrap();
    let agent = Agent(agent);
    let monitor = || {
        let output =
            program().args(["monitor", "--once", "--config"]).arg(&path).stderr(Stdio::null()).output().unwrap();
        String::from_utf8(output.stdout).unwrap()
    };
    let mut seen = String::new();
    for touch in 0..TOUCHES {
        // A way through the air shows which strain is rest.
        board.change(|bench| bench.base_mm = if touch % 2 == 0 { 5.0 } else { 8.0 });
        board.change(|bench| bench.touch(2.0));
        board.until(|bench| bench.is_free());
        seen = monitor();
        if seen.contains(", contact ") {
            break;
        }
    }
    let log = std::fs::read_to_string(folder.join("log")).unwrap();
    assert!(seen.contains("driver board: there") && seen.contains("driver stage: there"), "{seen}{log}");
    assert!(seen.contains(", contact ") && seen.contains(" s ago, 0 refused"), "{seen}{log}");
    drop(agent);
    std::fs::remove_dir_all(&folder).unwrap();
}
