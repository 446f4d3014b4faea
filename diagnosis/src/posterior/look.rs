//! A design with its sets weighed: what is found in it, the fit of that, and how likely the whole comparison is.

use super::prior;
use super::weighing::Weighing;
use crate::data::prepare::Prepared;
use crate::design::assembly::{Design, DesignOptions, Options, assemble};
use crate::figures::limits::VISIBLE_GAP_RATIO;
use crate::figures::measured::{Measured, measured};
use crate::inference::residuals::Residuals;
use crate::linearization::point::LinearizationPoint;
use crate::linearization::relinearized::RelinearizedFit;
use effects::Detection;
use effects::sensor::READINGS;

/// Single effects that are fitted about themselves where the best set leaves a gap: to first order the cause is among the first.
/// A bound on the work: a cause that is not among them is looked for about the best set alone.
const ALONE: usize = 3;

/// A design with its sets weighed.
pub(super) struct Look<'a> {
    /// The design.
    pub(super) design: Design<'a>,
    /// Its sets.
    pub(super) weighing: Weighing,
    /// The best set, fitted about itself, where that was asked for.
    pub(super) fitted: Option<RelinearizedFit<'a>>,
}

/// Where all is compared next, and what the fit that leads there leaves.
pub(super) struct NextPoint {
    /// The point.
    pub(super) point: LinearizationPoint,
    /// Held-out residuals.
    pub(super) residuals: Residuals,
}

impl NextPoint {
    fn of(fit: &RelinearizedFit) -> Self {
        Self {
            point: fit.point.clone(),
            residuals: fit.residuals().clone(),
        }
    }
}

/// Weighs the sets of a design about a point.
pub(super) fn look<'a>(
    prepared: &'a Prepared,
    options: &Options,
    point: &LinearizationPoint,
    design_options: DesignOptions<'_, 'a>,
) -> Look<'a> {
    Look::of(design(prepared, options, point, design_options))
}

/// A design in which causes that are in no catalogue compete as well.
pub(super) fn design<'a>(
    prepared: &'a Prepared,
    options: &Options,
    point: &LinearizationPoint,
    design_options: DesignOptions<'_, 'a>,
) -> Design<'a> {
    let with_unlisted = DesignOptions {
        unlisted: true,
        ..design_options
    };
    assemble(prepared, options, point, with_unlisted)
}

impl<'a> Look<'a> {
    /// Weighs the sets of a design.
    pub(super) fn of(design: Design<'a>) -> Self {
        let weighing = Weighing::of(&design);
        Self {
            design,
            weighing,
            fitted: None,
        }
    }

    /// Noise of each reading over the stated one, where it was found to be another.
    pub(super) fn noise(&self) -> Option<[f64; READINGS]> {
        self.design.measured_noise()
    }

    /// True where the noise was found to be above the stated one.
    pub(super) fn is_louder(&self) -> bool {
        self.noise()
            .is_some_and(|noise| noise.iter().any(|n| *n > 1.0))
    }

    /// Logarithm of the evidence of the whole comparison, of the residuals in metres: designs of other noise are whitened in another way.
    pub(super) fn log_evidence(&self) -> f64 {
        self.in_metres(self.weighing.decide(true).log_evidence)
    }

    /// The same if the forms of all effects lack nothing: what one form lacks, and a fuller one of the same effect tells, is forgiven to none.
    pub(super) fn log_evidence_of_forms(&self) -> f64 {
        self.in_metres(self.weighing.log_evidence_of_forms())
    }

    /// True if it is preferred to one in which less is told of the effects: it is the likelier if no form lacks anything, or does the same with
    /// fewer effects, or without nameless shapes.
    pub(super) fn is_preferred_to(&self, other: &Self) -> bool {
        let likelier = self.log_evidence_of_forms() > other.log_evidence_of_forms();
        let weighing = &self.weighing;
        likelier
            || weighing.does_with_fewer(&other.weighing)
            || weighing.does_without_shapes(&other.weighing)
    }

    /// Logarithm of a density of the whitened residuals, made one of those in metres.
    fn in_metres(&self, white: f64) -> f64 {
        let odds = if self.noise().is_some() {
            prior::log_odds()
        } else {
            0.0
        };
        white + self.design.linearized.log_whitening() + odds
    }

    /// What it is linearised about.
    pub(super) fn point(&self) -> LinearizationPoint {
        self.design.point()
    }

    /// The best set, fitted about itself.
    pub(super) fn fit(&self) -> RelinearizedFit<'a> {
        self.fit_of(&self.weighing.found())
    }

    /// Some effects, fitted about themselves.
    pub(super) fn fit_of(&self, names: &[String]) -> RelinearizedFit<'a> {
        RelinearizedFit::new(&self.design.linearized, self.point(), names)
    }

    /// The fit about which all is compared next: of those effects of the best set that do more than the others' forms may lack, or of the
    /// largest of them, or of another alone, if these leave less. About wrong places a large effect leaves a part of itself, which others
    /// describe; fitted together with these it may stay at the wrong places, and alone it finds the right ones.
    pub(super) fn next_point(&self) -> NextPoint {
        let names = self.weighing.leading();
        let mut best = match &self.fitted {
            Some(fit) if is_of(fit, &names) => NextPoint::of(fit),
            _ => NextPoint::of(&self.fit_of(&names)),
        };
        let nested = (2..names.len()).rev().map(|count| names[..count].to_vec());
        let alone = self.weighing.largest_alone(ALONE);
        let candidates = nested.chain(alone.map(|name| vec![name.to_owned()]));
        for candidate in candidates.filter(|c| *c != names) {
            let left = best.residuals.white_rms();
            if left <= VISIBLE_GAP_RATIO {
                break;
            }
            let fit = self.fit_of(&candidate);
            if fit.residuals().white_rms() < left {
                best = NextPoint::of(&fit);
            }
        }
        best
    }

    /// What is told of the effects in another comparison like this one.
    pub(super) fn told(&self) -> DesignOptions<'_, 'a> {
        DesignOptions {
            previous_inputs: Some(&self.design.linearized.inputs),
            like: Some(&self.design.linearized),
            field: self.holds_a_field(),
            ..DesignOptions::default()
        }
    }

    /// True where the best set holds a field over the platen.
    pub(super) fn holds_a_field(&self) -> bool {
        let is_field = |name: &String| effects::is(name, Detection::AsField);
        self.weighing.found().iter().any(is_field)
    }

    /// The place of what missing codes make, and its share, where that is most of the gap; none where a single effect explains the gap and leaves
    /// next to nothing over the stated noise. Rounding to the codes that are left looks like louder noise: an effect beside which louder noise is
    /// left does not explain the codes.
    pub(super) fn codes_explain_it<'s>(&self, seen: &'s Measured) -> Option<(&'s String, f64)> {
        seen.codes_explain_it().filter(|_| {
            !self.weighing.one_explains_all() || !seen.nothing_shows || self.is_louder()
        })
    }

    /// With what the best set leaves.
    pub(super) fn measured(
        mut self,
        prepared: &'a Prepared,
        options: &'a Options,
    ) -> (Self, Measured) {
        let found = self.weighing.found();
        let known = self.fitted.take().filter(|fit| is_of(fit, &found));
        let fit = known.unwrap_or_else(|| self.fit());
        let (seen, design, fit) = measured(prepared, options, (self.design, fit));
        let out = Self {
            design,
            weighing: self.weighing,
            fitted: Some(fit),
        };
        (out, seen)
    }
}

/// True if a fit is of some effects, in whatever order.
pub(crate) fn is_of(fit: &RelinearizedFit, names: &[String]) -> bool {
    let fitted = &fit.hypothesis.effects;
    fitted.len() == names.len() && names.iter().all(|name| fitted.contains(name))
}

/// Two whole comparisons in words: what each finds, and the logarithm of its evidence.
pub(super) fn compared(here: &Look, with: &Look) -> String {
    let [here, with] = [here, with].map(|look| {
        let found = look.weighing.found();
        let [whole, of_forms] = [look.log_evidence(), look.log_evidence_of_forms()];
        format!("{found:?} {whole:.1}, by its forms {of_forms:.1}")
    });
    format!("told more {with}, before {here}")
}

/// The one whose whole comparison is the likelier, the first if neither is.
pub(super) fn likelier<'a>(
    one: (Look<'a>, Measured),
    other: (Look<'a>, Measured),
) -> (Look<'a>, Measured) {
    if other.0.log_evidence() > one.0.log_evidence() {
        other
    } else {
        one
    }
}
