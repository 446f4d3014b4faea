//! Ways in which sine and cosine can have been mixed up beside tooth counts that are right.
//!
//! Where a board counts teeth from what it is wired to, a pair with sine and cosine exchanged runs backwards and is whole otherwise:
//! that is a wiring of [`crate::wiring`]. Where columns of a file were mixed up, the tooth counts still belong to the true phase, and the
//! output jumps within every tooth.

use recording::Samples;
use std::f64::consts::TAU;

/// How the sine and cosine columns of one segment are read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Reading {
    /// As they are.
    Stated,
    /// Of one segment otherwise.
    Turned {
        /// Index of the segment.
        segment: usize,
        /// What was done to its columns.
        mix: Mix,
    },
    /// Sine and cosine of two segments exchanged, their tooth counts not.
    Exchanged(usize, usize),
}

/// What can be done to a sine and a cosine: sign of the sine, sign of the cosine, then exchanged or not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Mix {
    /// The columns are exchanged.
    pub exchanged: bool,
    /// The column `s` has the wrong sign.
    pub sine: bool,
    /// The column `c` has the wrong sign.
    pub cosine: bool,
}

impl Reading {
    /// Every way but the stated one.
    pub fn others(has: impl Fn(usize) -> bool) -> Vec<Self> {
        let mut list = Vec::new();
        for segment in (0..4).filter(|s| has(*s)) {
            for k in 1..8 {
                let mix = Mix {
                    exchanged: k & 1 != 0,
                    sine: k & 2 != 0,
                    cosine: k & 4 != 0,
                };
                list.push(Self::Turned { segment, mix });
            }
            list.extend(
                (segment + 1..4)
                    .filter(|s| has(*s))
                    .map(|s| Self::Exchanged(segment, s)),
            );
        }
        list
    }

    /// Output of a segment, m; NaN where it was not measured.
    pub fn output_m(self, samples: &Samples, segment: usize, index: usize, pitch_m: f64) -> f64 {
        let from = match self {
            Self::Exchanged(a, b) if segment == a => b,
            Self::Exchanged(a, b) if segment == b => a,
            _ => segment,
        };
        let (Some([mut s, mut c]), Some(teeth)) = (
            samples.quadrature_counts(from, index),
            samples.teeth(segment, index),
        ) else {
            let logged = samples.unmodified_m(segment, index, pitch_m);
            return logged.unwrap_or(f64::NAN);
        };
        if let Self::Turned { segment: of, mix } = self
            && of == segment
        {
            if mix.sine {
                s = -s;
            }
            if mix.cosine {
                c = -c;
            }
            if mix.exchanged {
                (s, c) = (c, s);
            }
        }
        (f64::from(teeth) + s.atan2(c) / TAU) * pitch_m
    }
}
