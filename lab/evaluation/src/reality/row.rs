//! The rows of the evaluation: one nuisance at one strength each.

/// A departure of real whiskers and robots from the ideal world.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Nuisance {
    /// None: independent noise as configured, contacts all over the whisker, constant temperature.
    Ideal,
    /// Contacts stay at ratios of 0.8 to 0.9, then of 0.5 to 0.6, and back; their ratios have errors of 0.01.
    Habits,
    /// 0.3 to 1 % per K of either sign, in a room whose temperature swings by 10 K a day.
    Temperature,
    /// All whiskers read 3 % more or less from one contact to the next, and later as before.
    Step,
    /// Random walk of a whisker's gain: 3 % in 5,000 contacts.
    Walk,
    /// 5 % more or less in 10,000 contacts, and 3 % in the first 50.
    Ageing,
    /// Correlated noise of 2 %, with a correlation of 0.5 to 0.9 from contact to contact.
    Ar1,
    /// Creep and recovery of the rubber: a Prony series of 1 s and 30 s with 2 % each.
    Creep,
    /// A hysteresis loop of 4 % of the full range (Prandtl-Ishlinskii).
    Loop,
    /// Sensitivity falls by 1.5 % per mm of deflection, and the deflections' range changes.
    Curvature,
    /// Two contacts in a hundred have ten times the noise.
    Outliers,
    /// On/off valves with a dead band of 1.5 to 3 kPa, and a pressure sensor with steps of 1.22 kPa.
    Valves,
    /// A chamber leaks 0.1 to 3 % per second, and its valves refill it.
    Leak,
    /// Four of six whiskers are cut at once.
    Scrape,
    /// The cut comes at contact 100, while the whisker is learned.
    Learning,
    /// A cut of 0.5 mm, and one of 8 mm while the first is suspected.
    SecondCut,
    /// 10 mm wear off, 0.002 mm with each contact.
    Erosion,
    /// The gain of a compensated cut whisker drops by 3 %.
    GainDrop,
    /// The gain drops by as much as a cut raises it, and then the cut comes.
    LossCut,
    /// A tenth of the messages come up to a minute late.
    Late,
    /// All distances of the robot's touch tests are 1 mm short or long.
    Zero,
    /// The factory length of a whisker is wrong by 5 mm.
    Factory,
    /// Contacts turn by up to 20 degrees out of the plane of the gauge, and back.
    Turn,
    /// The rubber has a modulus of 0.5 to 2.5 MPa, and the model that of the paper.
    Modulus,
    /// The cables of two whiskers are exchanged.
    Exchange,
    /// The camera moves, at once or slowly, so that all contact ratios of a robot are off by 0.02.
    Camera,
    /// On/off valves whose regulator hunts around its target by 2 kPa.
    Hunting,
    /// Whiskers bend as an elastica does, and not as the core's mechanics say.
    Elastica,
    /// The same, and the chamber's wall keeps its volume under pressure. By the paper it gets 1.7 times as much thinner.
    Wall,
    /// An elastica with a coefficient of friction of 0.3 between objects and whiskers, which turns on the way out.
    Friction,
    /// `habits` to `valves` together, at the strength of real whiskers: no leaks, and single cuts.
    Mix,
}

impl Nuisance {
    /// All, in the order of the table.
    pub const ALL: [Self; 31] = [
        Self::Ideal,
        Self::Habits,
        Self::Temperature,
        Self::Step,
        Self::Walk,
        Self::Ageing,
        Self::Ar1,
        Self::Creep,
        Self::Loop,
        Self::Curvature,
        Self::Outliers,
        Self::Valves,
        Self::Leak,
        Self::Scrape,
        Self::Learning,
        Self::SecondCut,
        Self::Erosion,
        Self::GainDrop,
        Self::LossCut,
        Self::Late,
        Self::Zero,
        Self::Factory,
        Self::Turn,
        Self::Modulus,
        Self::Exchange,
        Self::Camera,
        Self::Hunting,
        Self::Elastica,
        Self::Wall,
        Self::Friction,
        Self::Mix,
    ];

    /// Name of the row in tables, JSON and on the command line.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Ideal => "ideal",
            Self::Habits => "habits",
            Self::Temperature => "temperature",
            Self::Step => "step",
            Self::Walk => "walk",
            Self::Ageing => "ageing",
            Self::Ar1 => "ar1",
            Self::Creep => "creep",
            Self::Loop => "loop",
            Self::Curvature => "curvature",
            Self::Outliers => "outliers",
            Self::Valves => "valves",
            Self::Leak => "leak",
            Self::Scrape => "scrape",
            Self::Learning => "learning",
            Self::SecondCut => "second-cut",
            Self::Erosion => "erosion",
            Self::GainDrop => "gain-drop",
            Self::LossCut => "loss-cut",
            Self::Late => "late",
            Self::Zero => "zero",
            Self::Factory => "factory",
            Self::Turn => "turn",
            Self::Modulus => "modulus",
            Self::Exchange => "exchange",
            Self::Camera => "camera",
            Self::Hunting => "hunting",
            Self::Elastica => "elastica",
            Self::Wall => "wall",
            Self::Friction => "friction",
            Self::Mix => "mix",
        }
    }

    /// The nuisance of a name.
    #[must_use]
    pub fn of_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|one| one.word() == word)
    }

    /// The strengths at which it is evaluated.
    fn strengths(self) -> &'static [f64] {
        match self {
            Self::Ideal | Self::Exchange | Self::Elastica | Self::Wall | Self::Mix => &[1.0],
            _ => &[0.5, 1.0, 2.0],
        }
    }
}

/// One row of the table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// The nuisance that is present.
    pub nuisance: Nuisance,
    /// Strength as a multiple of that of real whiskers, above 0.
    pub strength: f64,
}

/// Incident of a trial, besides the nuisances that last.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Incident {
    /// One whisker is cut.
    Cut,
    /// So many whiskers are cut at once.
    Scrape(usize),
    /// One whisker is cut at this contact, while it is learned.
    Learning(u32),
    /// One whisker is cut by so many mm, and by 8 mm while this is suspected.
    SecondCut(f64),
    /// One whisker wears off at this rate, mm per contact.
    Erosion(f64),
    /// One whisker is cut and compensated, and then loses this share of its gain, in log sensitivity.
    GainDrop(f64),
    /// One whisker loses this share of the sensitivity that a cut adds, and then is cut.
    LossCut(f64),
    /// One whisker is shorter or longer than its factsheet says by so many mm, from its first contact on.
    Factory(f64),
    /// Two whiskers are connected to each other's amplifier.
    Exchange,
}

impl Row {
    /// A row at the strength of real whiskers.
    #[must_use]
    pub fn real(nuisance: Nuisance) -> Self {
        Self { nuisance, strength: 1.0 }
    }

    /// The rows of these nuisances at all their strengths.
    #[must_use]
    pub fn of(nuisances: &[Nuisance]) -> Vec<Self> {
        let each = |&nuisance: &Nuisance| nuisance.strengths().iter().map(move |&strength| Self { nuisance, strength });
        nuisances.iter().flat_map(each).collect()
    }

    /// Incident of the whiskers that are not healthy.
    #[must_use]
    pub fn incident(self) -> Incident {
        let strength = self.strength;
        match self.nuisance {
            // 2, 4 and 5 of 6: at least one tells that it was not the temperature.
            Nuisance::Scrape => Incident::Scrape(((4.0 * strength).round() as usize).clamp(2, 5)),
            Nuisance::Learning => Incident::Learning((100.0 / strength) as u32),
            Nuisance::SecondCut => Incident::SecondCut(0.5 * strength),
            Nuisance::Erosion => Incident::Erosion(0.002 * strength),
            Nuisance::GainDrop => Incident::GainDrop(0.03 * strength),
            Nuisance::LossCut => Incident::LossCut(strength),
            Nuisance::Factory => Incident::Factory(5.0 * strength),
            Nuisance::Exchange => Incident::Exchange,
            _ => Incident::Cut,
        }
    }
}
