//! Where the demonstration is, told before the progress bar: `step 3 of 9: …`.

use indicatif::ProgressBar;

/// A step; all of them, in their order, are [`Step::ALL`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// The paper's synthetic problems, by both methods.
    Synthetic,
    /// Platen calibration.
    Platen,
    /// The fly-by that both calibrations are compared with.
    FlybyBefore,
    /// Joint calibration.
    Joint,
    /// The fly-by by the joint calibration alone.
    FlybyJoint,
    /// Further poses for the tooth map.
    MapPoses,
    /// The map's estimate.
    Map,
    /// The fly-by with the map.
    FlybyMap,
    /// Poses, fit and fly-bys of the paper's method.
    PaperMethod,
}

impl Step {
    /// In their order.
    pub(super) const ALL: [Self; 9] = [
        Self::Synthetic,
        Self::Platen,
        Self::FlybyBefore,
        Self::Joint,
        Self::FlybyJoint,
        Self::MapPoses,
        Self::Map,
        Self::FlybyMap,
        Self::PaperMethod,
    ];

    /// Its place in the order.
    fn prefix(self) -> String {
        format!("step {} of {}: ", self as usize + 1, Self::ALL.len())
    }

    /// Shows that it begins, and what it does.
    pub(super) fn begin(self, bar: &ProgressBar, what: &'static str) {
        bar.set_prefix(self.prefix());
        bar.set_message(what);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_counted_in_their_order() {
        for (number, step) in (1..).zip(Step::ALL) {
            assert_eq!(step.prefix(), format!("step {number} of 9: "));
        }
    }

    #[test]
    fn a_step_is_shown_before_what_it_does() {
        let bar = ProgressBar::hidden();
        Step::FlybyBefore.begin(&bar, "flying by");
        assert_eq!(bar.prefix() + &bar.message(), "step 3 of 9: flying by");
    }
}
