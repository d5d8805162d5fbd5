//! Limits and times of touch tests.

use vibrissa_core::robot::params::TouchTestParams;
use vibrissa_core::units::Micros;

use super::keys::Key;
use super::reader::Reader;

/// Reads every key before it gives up, so that all problems are reported.
pub(super) fn touch_tests(reader: &mut Reader) -> Option<TouchTestParams> {
    let per_hour = reader.whole(Key::TouchTestsPerHour).and_then(|number| u16::try_from(number).ok());
    let in_a_row = reader.whole(Key::TouchTestsInARow).and_then(|number| u8::try_from(number).ok());
    let retry_after_s = reader.number(Key::TouchTestsRetryAfterS);
    let contact_time_s = reader.number(Key::TouchTestsContactTimeS);
    let contacts_between_false_alarms = reader.number(Key::TouchTestsContactsBetweenSuspicions);
    let after_pause_s = reader.number(Key::TouchTestsAfterPauseS);
    let every_s = reader.number(Key::TouchTestsEveryS);
    let every_without_place_s = reader.number(Key::TouchTestsEveryWithoutPlaceS);
    let zero_sd_mm = reader.number(Key::TouchTestsZeroSdMm);
    Some(TouchTestParams {
        per_hour: per_hour?,
        contacts_between_false_alarms: contacts_between_false_alarms?,
        contact_time: Micros::from_s(contact_time_s?),
        pause: Micros::from_s(retry_after_s?),
        in_a_row: in_a_row?,
        after_pause: Micros::from_s(after_pause_s?),
        every: Micros::from_s(every_s?),
        every_without_place: Micros::from_s(every_without_place_s?),
        zero_sd_mm: zero_sd_mm?,
    })
}
