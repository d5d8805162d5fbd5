//! Numbers of the messages to one robot.

/// Next `seq` of each topic to one robot, in this boot of the supervisor.
#[derive(Debug, Default)]
pub(crate) struct Seqs {
    receipt: u64,
    setpoint: u64,
    request: u64,
    estimate: u64,
    maintenance: u64,
}

impl Seqs {
    pub(crate) fn next_receipt(&mut self) -> u64 {
        next(&mut self.receipt)
    }

    pub(crate) fn next_setpoint(&mut self) -> u64 {
        next(&mut self.setpoint)
    }

    pub(crate) fn next_request(&mut self) -> u64 {
        next(&mut self.request)
    }

    /// Also the version: a boot of the supervisor has one epoch.
    pub(crate) fn next_estimate(&mut self) -> u64 {
        next(&mut self.estimate)
    }

    pub(crate) fn next_maintenance(&mut self) -> u64 {
        next(&mut self.maintenance)
    }
}

fn next(seq: &mut u64) -> u64 {
    let now = *seq;
    *seq += 1;
    now
}
