//! Most likely starts of the change hypotheses. The state error per unit of a change depends on its start and not
//! on its size, so all steps that began with the same contact share one start.
//!
//! There is room for [`STEPS`] starts of steps at a time. Five of them are in use at one contact in a thousand of an intact
//! whisker, and all while a small change is suspected for long. A step that finds no room begins with a later contact.
//! Gradual changes hardly ever restart, so each has a start of its own.

use borsh::io::{Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};

use super::hypothesis::{COUNT, GRADUAL_FROM, OF_LENGTH};
use crate::encoding;
use crate::estimation::filter::{BASELINE, LENGTH, STATES};

/// Number of starts that all steps share.
pub const STEPS: usize = 8;
/// Number of starts: those of the steps, then one for each gradual change, in their order.
pub const STARTS: usize = STEPS + COUNT - GRADUAL_FROM;
/// Index of the first start of a baseline change.
const BASELINES_FROM: usize = STEPS + OF_LENGTH - GRADUAL_FROM;
/// Place of a step without a start: it would begin with this contact.
const NOW: usize = STARTS;
/// Length of the place arrays, a power of two, so that the compiler can drop bounds checks.
const PLACES: usize = 16;
/// Contacts are counted up to this number.
pub const CONTACTS_MAX: u32 = u16::MAX as u32;
const _: () = assert!(NOW < PLACES);

/// Expected innovation per unit of a change that began at each place, in standard deviations.
pub type Signatures = [f32; PLACES];

/// Starts of all hypotheses.
#[derive(Debug, Clone, PartialEq)]
pub struct Starts {
    /// State error per unit of the change since the start; 0 where there is no start.
    lacking: [[f32; STARTS]; STATES],
    /// Contacts since the start, at most [`CONTACTS_MAX`]; 0 where there is no start.
    contacts: [u16; STARTS],
    /// Place of each step's start, or `NOW`.
    of_steps: [u8; GRADUAL_FROM],
}

impl Default for Starts {
    fn default() -> Self {
        Self { lacking: Default::default(), contacts: [0; STARTS], of_steps: [NOW as u8; GRADUAL_FROM] }
    }
}

impl Starts {
    /// Place of a hypothesis's start.
    pub fn place(&self, index: usize) -> usize {
        match self.of_steps.get(index) {
            Some(&place) => usize::from(place) % PLACES,
            None => index - GRADUAL_FROM + STEPS,
        }
    }

    /// Contacts since a hypothesis's start; 0 if it has not begun.
    pub fn contacts(&self, index: usize) -> u32 {
        self.contacts.get(self.place(index)).map_or(0, |&contacts| contacts.into())
    }

    /// State error per unit of a hypothesis's change.
    pub fn lacking(&self, index: usize) -> [f64; STATES] {
        let place = self.place(index);
        std::array::from_fn(|state| self.lacking[state].get(place).map_or(0.0, |&lacks| lacks.into()))
    }

    /// Advances the gradual changes by one contact and returns the expected innovation per unit of each change.
    /// `row` is the observation row of the contact divided by the standard deviation of its innovation.
    pub fn expect(&mut self, row: &[f32; STATES]) -> Signatures {
        self.lacking[LENGTH][STEPS..BASELINES_FROM].iter_mut().for_each(|lacks| *lacks += 1.0);
        self.lacking[BASELINE][BASELINES_FROM..].iter_mut().for_each(|lacks| *lacks += 1.0);
        let mut expected = [0.0; PLACES];
        for (one, row) in self.lacking.iter().zip(row) {
            for (expected, lacks) in expected.iter_mut().zip(one) {
                *expected += row * lacks;
            }
        }
        expected[NOW] = row[LENGTH];
        expected
    }

    /// Copies the signatures by place into an array indexed by hypothesis.
    pub fn by_change(&self, expected: &Signatures, signature: &mut [f32]) {
        for (signature, &place) in signature.iter_mut().zip(&self.of_steps) {
            *signature = expected[usize::from(place) % PLACES];
        }
        signature[GRADUAL_FROM..COUNT].copy_from_slice(&expected[STEPS..STARTS]);
    }

    /// Discards the start of a step.
    pub fn forget(&mut self, step: usize) {
        self.of_steps[step] = NOW as u8;
    }

    /// Follows the filter's update. Hypotheses that do not continue lose their starts. Steps that continue without
    /// a start begin with this contact if a place is free; otherwise their entry in `goes_on` is cleared.
    pub fn follow(&mut self, gain: &[f32; STATES], expected: &Signatures, goes_on: &mut [bool; COUNT]) {
        for (one, gain) in self.lacking.iter_mut().zip(gain) {
            for (lacks, expected) in one.iter_mut().zip(expected) {
                *lacks -= gain * expected;
            }
        }
        let (mut used, mut begins) = (0_u32, false);
        for (place, goes_on) in self.of_steps.iter_mut().zip(&*goes_on) {
            if !goes_on {
                *place = NOW as u8;
            }
            used |= u32::from(*goes_on) << *place;
            begins |= *goes_on && usize::from(*place) == NOW;
        }
        let begun = if begins { (!used).trailing_zeros() as usize } else { NOW };
        for place in 0..STARTS {
            let lasts = if place < STEPS { used & 1 << place != 0 } else { goes_on[place + GRADUAL_FROM - STEPS] };
            self.contacts[place] = if lasts { self.contacts[place].saturating_add(1) } else { 0 };
            for one in &mut self.lacking {
                one[place] = if lasts { one[place] } else { 0.0 };
            }
        }
        if begins {
            self.begin(begun, gain, expected, goes_on);
        }
    }

    fn begin(&mut self, begun: usize, gain: &[f32; STATES], expected: &Signatures, goes_on: &mut [bool; COUNT]) {
        let waits = begun >= STEPS;
        for (place, goes_on) in self.of_steps.iter_mut().zip(goes_on).filter(|(place, _)| usize::from(**place) == NOW) {
            *goes_on &= !waits;
            if *goes_on {
                *place = begun as u8;
            }
        }
        if !waits {
            self.contacts[begun] = 1;
            for (state, (one, gain)) in self.lacking.iter_mut().zip(gain).enumerate() {
                let unit = if state == LENGTH { 1.0 } else { 0.0 };
                one[begun] = unit - gain * expected[NOW];
            }
        }
    }

    /// Discards the starts of all steps.
    pub fn forget_steps(&mut self) {
        self.of_steps = [NOW as u8; GRADUAL_FROM];
        self.contacts[..STEPS].fill(0);
        self.lacking.iter_mut().for_each(|one| one[..STEPS].fill(0.0));
    }
}

/// Compact encoding: gradual changes that began with the same contact have equal state errors.
impl Starts {
    /// Whether this start equals the one in the place before it.
    fn is_as_before(&self, place: usize) -> bool {
        let same = |one: &[f32; STARTS]| one[place].to_bits() == one[place - 1].to_bits();
        place > STEPS && self.contacts[place] == self.contacts[place - 1] && self.lacking.iter().all(same)
    }

    fn take_before(&mut self, place: usize) -> Result<()> {
        if place <= STEPS || self.contacts[place - 1] == 0 {
            return Err(encoding::invalid("a start refers to a missing one"));
        }
        self.contacts[place] = self.contacts[place - 1];
        self.lacking.iter_mut().for_each(|one| one[place] = one[place - 1]);
        Ok(())
    }
}

/// Encoding: a bit mask of the used starts, then the places of the steps, two to a byte, then the used starts.
impl BorshSerialize for Starts {
    fn serialize<W: Write>(&self, writer: &mut W) -> Result<()> {
        let bits = encoding::pack_flags(self.contacts.map(|contacts| contacts > 0));
        bits.serialize(writer)?;
        self.of_steps.chunks(2).try_for_each(|pair| (pair[0] | pair[1] << 4).serialize(writer))?;
        for place in (0..STARTS).filter(|&place| self.contacts[place] > 0) {
            if self.is_as_before(place) {
                encoding::write_u32(0, writer)?;
                continue;
            }
            encoding::write_u32(self.contacts[place].into(), writer)?;
            self.lacking.iter().try_for_each(|one| one[place].serialize(writer))?;
        }
        Ok(())
    }
}

/// Sizes of the detector in stored bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stored {
    /// States of the filter. The others were unknown to it, so that it absorbed nothing of a change in them.
    pub states: usize,
    /// Places for the starts of steps.
    pub steps: usize,
}

impl Stored {
    /// Sizes of this version.
    pub const NOW: Self = Self { states: STATES, steps: STEPS };

    /// Present place of a stored one.
    fn place(&self, stored: usize) -> usize {
        if stored < self.steps { stored } else { stored - self.steps + STEPS }
    }
}

impl Starts {
    /// Reads stored bytes.
    pub fn read<R: Read>(stored: &Stored, reader: &mut R) -> Result<Self> {
        let mut read = Self::default();
        let stored_places = stored.steps + STARTS - STEPS;
        let are: [bool; STARTS] = encoding::unpack_flags(u16::deserialize_reader(reader)?)?;
        for pair in read.of_steps.chunks_mut(2) {
            let both = u8::deserialize_reader(reader)?;
            (pair[0], pair[1]) = (both & 0xf, both >> 4);
        }
        for place in &mut read.of_steps {
            let at = usize::from(*place);
            let is_step = at == stored_places || at < stored.steps && are[at];
            if !is_step {
                return Err(encoding::invalid("a step without a start"));
            }
            *place = stored.place(at) as u8;
        }
        for at in (0..stored_places).filter(|&at| are[at]) {
            let place = stored.place(at);
            let contacts = encoding::read_u32(reader)?;
            if contacts == 0 {
                read.take_before(place)?;
                continue;
            }
            read.contacts[place] = contacts.min(CONTACTS_MAX) as u16;
            for one in read.lacking.iter_mut().take(stored.states) {
                one[place] = f32::deserialize_reader(reader)?;
            }
        }
        Ok(read)
    }
}
