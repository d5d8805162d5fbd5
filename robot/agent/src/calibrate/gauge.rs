//! The steps at a gauge and its slide.

use super::finding::{Finding, Verdict};
use super::measure::{Rest, Touch};
use super::session::{Ended, Seen, Session, say};
use super::{Bench, decimals};

/// Time in which a line of the gauge must come, and in which rest is measured. s.
const FIRST_S: f64 = 5.0;
const REST_S: f64 = 3.0;
/// Longest wait for a touch, and the number of attempts.
const TOUCH_S: f64 = 60.0;
const ATTEMPTS: usize = 3;
/// Rates of the segmenter, Hz: below the first it finds nothing, and below the second only touches of 0.4 s.
const RATES_HZ: (f64, f64) = (9.0, 50.0);
/// Noise beyond which touches of less than a millimetre are lost: 10 % of a weak touch, 0.0046 strain a millimetre.
const NOISY: f64 = 5e-4;
/// Part of the segmenter's limit that the zero may take.
const ZERO_PART: f64 = 0.5;
/// Time in which lines that were on their way arrive. s.
const NEWEST_S: f64 = 0.3;
/// Shortest travel of a slide, mm.
const TRAVEL_MM: f64 = 1.0;

const NO_STRAIN: &str = "no driver sends strain of this whisker";

/// Listens at rest, so that later steps have a zero; the findings about it.
pub(super) async fn rest(session: &mut Session<'_>, bench: &mut Bench) -> Result<Vec<Finding>, Ended> {
    session.clear();
    if !session.wait(FIRST_S, |seen| !seen.strains.is_empty()).await? {
        return Ok(vec![Finding::skipped("gauge at rest", NO_STRAIN)]);
    }
    session.ask("Leave the whisker alone, so that nothing touches it, and press Enter.").await?;
    session.clear();
    session.wait(REST_S, |_| false).await?;
    let Some(rest) = Rest::of(&session.seen().strains) else {
        return Ok(vec![Finding::new(
            "rate of the strain",
            String::new(),
            Verdict::Bad,
            format!("fewer than 10 samples in {REST_S} s: send at least 10 a second"),
        )]);
    };
    bench.rest = Some(rest);
    Ok(at_rest(&rest, bench.strain_limit))
}

fn at_rest(rest: &Rest, limit: f64) -> Vec<Finding> {
    let zero = format!("{} m/m", decimals(rest.zero, 6));
    let zero = if rest.zero.abs() > ZERO_PART * limit {
        let text = "it takes much of segmenter.strain_limit: balance the bridge, or subtract an offset in the driver";
        Finding::new("gauge's zero", zero, Verdict::Check, text)
    } else {
        Finding::new("gauge's zero", zero, Verdict::Good, "any offset is allowed")
    };
    let sd = format!("{:.1e} m/m (standard deviation)", rest.sd);
    let noise = if rest.sd > NOISY {
        let text = "weak touches are lost: check the wires, the shield and the supply of the converter";
        Finding::new("gauge's noise", sd, Verdict::Check, text)
    } else {
        Finding::new("gauge's noise", sd, Verdict::Good, "")
    };
    let rate = format!("{:.1} Hz", rest.rate_hz);
    let rate = if rest.rate_hz < RATES_HZ.0 {
        Finding::new("rate of the strain", rate, Verdict::Bad, "too slow to find contacts: send at least 10 a second")
    } else if rest.rate_hz < RATES_HZ.1 {
        let text = "touches shorter than 0.4 s may be lost: 50 samples a second find them";
        Finding::new("rate of the strain", rate, Verdict::Check, text)
    } else {
        Finding::new("rate of the strain", rate, Verdict::Good, "")
    };
    vec![zero, noise, rate]
}

/// A touch that the person makes; `None` if none came.
async fn touch(session: &mut Session<'_>, rest: Rest, request: &str) -> Result<Option<Touch>, Ended> {
    for attempt in 1..=ATTEMPTS {
        session.ask(request).await?;
        session.clear();
        let (mut touch, mut at) = (Touch::new(rest), 0);
        let is_over = |seen: &Seen| {
            let mut new = seen.strains[at..].iter();
            at = seen.strains.len();
            new.any(|sample| touch.push(sample))
        };
        let is_over = session.wait(TOUCH_S, is_over).await?;
        if is_over {
            return Ok(Some(touch));
        }
        let what = if touch.is_real() { "the touch did not end" } else { "no touch was seen" };
        say(&format!("In {TOUCH_S:.0} s {what} (attempt {attempt} of {ATTEMPTS})."));
    }
    Ok(None)
}

/// Directions in which a touch moves strain and slide.
pub(super) async fn sign(session: &mut Session<'_>, bench: &mut Bench) -> Result<Vec<Finding>, Ended> {
    let Some(rest) = bench.rest else { return Ok(vec![Finding::skipped("sign", NO_STRAIN)]) };
    let request = "Press Enter. Then touch the whisker at its tip, from the side from which the robot touches: press it \
                   for a second, and let it go.";
    let Some(touch) = touch(session, rest, request).await? else {
        let text = "no touch changed the strain: check the gauge, its wires and its amplifier";
        return Ok(vec![Finding::new("sign", String::new(), Verdict::Bad, text)]);
    };
    let mut findings = vec![sign_of(&touch)];
    findings.extend(touch.way_mm().and_then(direction));
    Ok(findings)
}

fn sign_of(touch: &Touch) -> Finding {
    let change = format!("{} m/m", decimals(touch.strain(), 6));
    match touch.sign() {
        Some(sign) => {
            let word = if sign > 0.0 { "RISES" } else { "FALLS" };
            let text = format!("a touch changes the strain by {change}");
            Finding::new("sign", word.to_owned(), Verdict::Good, text).writes("segmenter.sign", format!("\"{word}\""))
        }
        None => {
            let text = format!("the strain went to both sides, by up to {change}: segmenter.sign stays as it is");
            Finding::new("sign", "both".to_owned(), Verdict::Check, text)
        }
    }
}

/// A base that moved against the object must have a larger deflection then. One that stood says nothing.
fn direction(way_mm: f64) -> Option<Finding> {
    let value = format!("{} mm", decimals(way_mm, 2));
    match way_mm {
        0.3.. => Some(Finding::new(
            "way of the base in the touch",
            value,
            Verdict::Good,
            "it grows as the whisker is pressed",
        )),
        ..-0.3 => {
            let text =
                "it must grow as the whisker is pressed: exchange the ends of the potentiometer, or change the sign";
            Some(Finding::new("way of the base in the touch", value, Verdict::Bad, text))
        }
        _ => None,
    }
}

/// Whether the converter ends below the largest deflection.
pub(super) async fn scale(session: &mut Session<'_>, bench: &mut Bench) -> Result<Vec<Finding>, Ended> {
    let Some(rest) = bench.rest else { return Ok(vec![Finding::skipped("largest strain", NO_STRAIN)]) };
    let request = "Press Enter. Then deflect the whisker slowly as far as the robot ever will, hold it for two seconds, \
                   and let it go.";
    match touch(session, rest, request).await? {
        Some(touch) => Ok(vec![scale_of(&touch, &rest, bench.strain_limit, bench.strain_max)]),
        None => Ok(vec![Finding::new("largest strain", String::new(), Verdict::Bad, "no touch changed the strain")]),
    }
}

pub(super) fn scale_of(touch: &Touch, rest: &Rest, limit: f64, strain_max: Option<f64>) -> Finding {
    let what = "largest strain";
    let value = format!("{} m/m", decimals(touch.strain(), 6));
    if let Some(end) = touch.end() {
        let range = decimals((end - rest.zero).abs(), 6);
        let text = "the converter or the amplifier ends there, while the whisker is deflected further: amplify less, or deflect \
                    less. Contacts there are not used";
        return Finding::new(what, value, Verdict::Bad, text).writes("strain_max", range);
    }
    if rest.zero.abs() + touch.strain() >= limit {
        let text = "it is beyond segmenter.strain_limit: raise that limit if the gauge still measures there";
        return Finding::new(what, value, Verdict::Check, text);
    }
    if touch.is_coarse() {
        let text = "whether the converter ends there is not known: its steps are coarse, and no line has deflection_mm";
        return Finding::new(what, value, Verdict::Check, text);
    }
    // Of an earlier calibration, with another amplifier. A larger one may be true: nobody has deflected the whisker so far.
    if strain_max.is_some_and(|max| max < touch.strain()) {
        let text = "the converter goes on beyond it: strain_max of agent.toml is too small";
        return Finding::new(what, value, Verdict::Good, text).removes("strain_max");
    }
    Finding::new(what, value, Verdict::Good, "the converter goes on beyond it")
}

/// The travel of the slide.
pub(super) async fn slide(session: &mut Session<'_>, bench: &mut Bench) -> Result<Vec<Finding>, Ended> {
    let what = "travel of the base";
    if !session.wait(FIRST_S, |seen| seen.deflection_mm.is_some()).await? {
        let text = "no driver sends deflection_mm: contacts of the strain need it, so set SLIDE_MM, or let another driver \
                    send the motion";
        return Ok(vec![Finding::skipped(what, text)]);
    }
    session.ask("Move the base to one end of its way, where nothing touches, and press Enter.").await?;
    session.wait(NEWEST_S, |_| false).await?;
    let from_mm = session.seen().deflection_mm;
    session.clear();
    session.ask("Move it to the other end, without a touch, and press Enter.").await?;
    session.wait(NEWEST_S, |_| false).await?;
    let travel_mm = session.seen().deflection_mm.zip(from_mm).map_or(0.0, |(to_mm, from_mm)| (to_mm - from_mm).abs());
    let mut touch = bench.rest.map(Touch::new);
    let touched = touch.as_mut().is_some_and(|touch| {
        session.seen().strains.iter().any(|sample| {
            touch.push(sample);
            touch.is_real()
        })
    });
    Ok(vec![travel(what, travel_mm, touched)])
}

fn travel(what: &str, travel_mm: f64, touched: bool) -> Finding {
    let value = format!("{} mm", decimals(travel_mm, 2));
    if travel_mm < TRAVEL_MM {
        let text = "it does not move: check the potentiometer's middle wire, and SLIDE_MM";
        return Finding::new(what, value, Verdict::Bad, text);
    }
    let text = if touched {
        "something touched the whisker on the way: it must be free at both ends. Compare the travel with a ruler"
    } else {
        "compare it with a ruler: if they differ, correct SLIDE_MM"
    };
    Finding::new(what, value, if touched { Verdict::Check } else { Verdict::Good }, text)
}
