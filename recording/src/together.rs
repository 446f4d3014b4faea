//! Which columns make sense only together, and which no recording is without.

use crate::column::Column;

/// What a header lacks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Lack {
    /// The column that is not there; none where any of several would do.
    pub column: Option<Column>,
    pub found: &'static str,
    pub wanted: &'static str,
}

/// The first thing that a table with these columns lacks.
pub(crate) fn lack(has: impl Fn(Column) -> bool) -> Option<Lack> {
    let missing = |column: Column, wanted: &'static str| {
        Some(Lack {
            column: Some(column),
            found: "none",
            wanted,
        })
    };
    if !has(Column::Time) {
        return missing(Column::Time, "the column of time, s");
    }
    for segment in 0..4 {
        let trio = [
            Column::Sine(segment),
            Column::Cosine(segment),
            Column::Teeth(segment),
        ];
        if let Some(absent) = absent(&trio, &has) {
            return missing(absent, "it beside the segment's other columns of counts");
        }
    }
    let electrodes: [Column; 4] = std::array::from_fn(Column::Electrode);
    if let Some(absent) = absent(&electrodes, &has) {
        return missing(absent, "all four electrodes");
    }
    let is_there = |segment: usize| has(Column::Sine(segment)) || has(Column::Position(segment));
    (!(0..4).any(is_there)).then_some(Lack {
        column: None,
        found: "no segment",
        wanted: "q1s, q1c, n1 or p1_m, or those of segment 2, 3 or 4",
    })
}

/// The first of a group that is not there while another is.
fn absent(group: &[Column], has: &impl Fn(Column) -> bool) -> Option<Column> {
    let any = group.iter().any(|column| has(*column));
    let absent = group.iter().find(|column| !has(**column));
    absent.filter(|_| any).copied()
}

impl Column {
    /// The columns that must be there beside this one, itself among them.
    #[must_use]
    pub fn companions(self) -> Vec<Self> {
        match self {
            Self::Sine(segment) | Self::Cosine(segment) | Self::Teeth(segment) => vec![
                Self::Sine(segment),
                Self::Cosine(segment),
                Self::Teeth(segment),
            ],
            Self::Electrode(_) => (0..4).map(Self::Electrode).collect(),
            alone => vec![alone],
        }
    }
}
