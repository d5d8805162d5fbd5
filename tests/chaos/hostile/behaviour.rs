//! The behaviours of hostile robots, by name.

use clap::ValueEnum;

/// Something a hostile robot does for some seconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum Behaviour {
    /// Factsheets with control characters, unknown models and extreme layouts; they are retained.
    OddFactsheets,
    /// Contacts at the limits of the contract's ranges.
    ExtremeContacts,
    /// Contacts outside the contract's ranges.
    BadContacts,
    /// Contacts and statuses with times years in the future or past.
    WrongClocks,
    /// A hundred births in a second, each with a new boot.
    ManyBoots,
    /// Messages for other robots, for made-up robots, and in the supervisor's name.
    OthersTopics,
    /// New contents with sequence numbers that were sent before.
    KnownNumbers,
    /// Answers to setpoints that nobody sent, and contradictory answers to real setpoints.
    ForgedAnswers,
    /// 2,000 messages in a second, for two seconds.
    Flood,
    /// Messages that are larger than the contract allows, up to 8 MiB.
    HugeMessages,
    /// Bytes that are not messages.
    Garbage,
    /// Connections under the supervisor's client ids, guessed from the boot id in receipts.
    Takeover,
    /// Cuts that need setpoints, without answers to any setpoint.
    Deaf,
    /// Cuts that need setpoints, with false answers to the setpoints.
    Lies,
}

impl Behaviour {
    /// Name of the behaviour in options and reports.
    #[must_use]
    pub fn name(self) -> String {
        self.to_possible_value().expect("no behaviour is hidden").get_name().to_owned()
    }

    /// Selects behaviours: those in `only`, or all if `only` is empty; without those in `left_out`.
    #[must_use]
    pub fn chosen(only: &[Self], left_out: &[Self]) -> Vec<Self> {
        let is_asked = |one: &Self| only.is_empty() || only.contains(one);
        Self::value_variants().iter().copied().filter(|one| is_asked(one) && !left_out.contains(one)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn behaviours_are_chosen_by_name_and_left_out_by_name() {
        let count = Behaviour::value_variants().len();
        assert_eq!(Behaviour::chosen(&[], &[]).len(), count);
        assert_eq!(Behaviour::chosen(&[Behaviour::Flood], &[]), [Behaviour::Flood]);
        let left = Behaviour::chosen(&[], &[Behaviour::Flood]);
        assert!(left.len() == count - 1 && !left.contains(&Behaviour::Flood));
        assert_eq!(Behaviour::OddFactsheets.name(), "odd-factsheets");
    }
}
