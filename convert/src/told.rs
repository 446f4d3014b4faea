//! What a conversion tells of itself.

/// Something that looks wrong, and the option that would mend it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// What was found.
    pub what: String,
    /// The option, or what else to do.
    pub mend: String,
}

/// Something that was not stated, and the option that states it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Assumed {
    /// What was taken, and how it came about.
    pub what: String,
    /// The option that says otherwise.
    pub option: String,
}

/// One column of the recording.
#[derive(Clone, Debug, PartialEq)]
pub struct ToldColumn {
    /// Its name in the recording.
    pub name: &'static str,
    /// Where it comes from, in words.
    pub from: String,
    /// Values, without those that were not measured.
    pub values: usize,
    /// Lowest and highest, in the recording's unit.
    pub range: [f64; 2],
}

/// One run.
#[derive(Clone, Debug, PartialEq)]
pub struct ToldRun {
    /// Its name.
    pub name: String,
    /// Its samples.
    pub samples: usize,
    /// First and last time, s.
    pub times_s: [f64; 2],
}

/// How a pair's counts came from the log's values: `counts = (value - centre) * scale`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToldPair {
    /// Segment, 0 to 3.
    pub segment: usize,
    /// Of sine and cosine, in the log's unit after its arithmetic.
    pub centre: [f64; 2],
    /// Counts per unit.
    pub scale: f64,
}

/// All that was done.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Told {
    /// How the log is written.
    pub dialect: String,
    /// Rows of the log.
    pub rows: usize,
    /// Samples a second, from the usual interval.
    pub rate_hz: f64,
    /// From the first sample to the last, s.
    pub duration_s: f64,
    /// Columns of the recording in their order.
    pub columns: Vec<ToldColumn>,
    /// Pairs of sine and cosine.
    pub pairs: Vec<ToldPair>,
    /// Columns of the log that were left aside.
    pub left_aside: Vec<String>,
    /// What separates the runs.
    pub runs_by: String,
    /// Runs in order of appearance.
    pub runs: Vec<ToldRun>,
    /// What was done, one sentence each.
    pub done: Vec<String>,
    /// What was measured or assumed.
    pub assumed: Vec<Assumed>,
    /// What looks wrong.
    pub warnings: Vec<Warning>,
}

impl Told {
    /// Notes something that was done.
    pub(crate) fn did(&mut self, what: impl Into<String>) {
        self.done.push(what.into());
    }

    /// Notes something that was not stated.
    pub(crate) fn assume(&mut self, what: impl Into<String>, option: impl Into<String>) {
        self.assumed.push(Assumed {
            what: what.into(),
            option: option.into(),
        });
    }

    /// Notes something that looks wrong.
    pub(crate) fn warn(&mut self, what: impl Into<String>, mend: impl Into<String>) {
        self.warnings.push(Warning {
            what: what.into(),
            mend: mend.into(),
        });
    }
}

/// A number with four figures, without a needless exponent.
#[must_use]
pub fn figures(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    if !(1.0e-4..1.0e6).contains(&size) {
        return format!("{value:.3e}");
    }
    let digits = (3 - size.log10().floor() as i32).max(0) as usize;
    let text = format!("{value:.digits$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::figures;

    #[test]
    fn four_figures() {
        for (value, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (-12.3456, "-12.35"),
            (20_012.4, "20012"),
            (2.0e-9, "2.000e-9"),
            (0.001, "0.001"),
        ] {
            assert_eq!(figures(value), text);
        }
    }
}
