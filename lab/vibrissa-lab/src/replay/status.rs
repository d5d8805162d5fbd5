//! Corrects a recorded `status` as if the robot had followed the replay's setpoints.

use vibrissa_core::robot::Robot;
use vibrissa_core::robot::event::WhiskerStatus;
use vibrissa_core::units::Megapascal;

use super::answers::Answers;

/// Tolerance for recognising the recorded setpoint in a status, MPa.
const OF_RECORDED_MPA: f64 = 1e-3;

/// Replaces the recorded pressure by the replay's; the control deviation stays as recorded.
pub(super) fn correct(entry: &mut WhiskerStatus<'_>, robot: &Robot, answers: &Answers) {
    let view = robot.find(entry.array, entry.whisker).and_then(|index| robot.whisker(index));
    let Some(nominal) = view.map(|view| view.sheet.pressure) else { return };
    let Some((recorded, own)) = answers.moved(&(entry.array.to_owned(), entry.whisker), nominal) else { return };
    if (entry.setpoint.mpa() - recorded.mpa()).abs() > OF_RECORDED_MPA {
        return;
    }
    let off_mpa = entry.pressure.mpa() - entry.setpoint.mpa();
    entry.setpoint = own;
    entry.pressure = Megapascal::known((own.mpa() + off_mpa).clamp(0.0, 1.0));
}
