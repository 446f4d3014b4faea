//! A change of a comparison (another point, more told of an effect), tried among those blocks alone that count in it.

use super::look::{Look, compared, look};
use crate::data::prepare::Prepared;
use crate::design::assembly::{DesignOptions, Options};
use crate::linearization::point::LinearizationPoint;
use crate::trace::log;
use effects::sensor::BasisInputs;

/// Samples of a trial. A bound on the work: a change that these do not show to be the likelier is not compared by all.
pub(super) const SAMPLES: usize = 4000;

/// A comparison among those blocks alone that count in a whole one, and what is changed in it by way of trial. All columns together are most of
/// the work: only what makes it likelier among these is then compared with all others.
pub(super) struct Trial<'s, 'a> {
    prepared: &'a Prepared,
    options: &'s Options,
    names: Vec<String>,
    inputs: &'s BasisInputs,
    here: Look<'a>,
}

impl<'s, 'a> Trial<'s, 'a> {
    /// Of a whole comparison about a point.
    pub(super) fn of(
        prepared: &'a Prepared,
        options: &'s Options,
        point: &LinearizationPoint,
        whole: &'s Look<'a>,
    ) -> Self {
        let inputs = &whole.design.linearized.inputs;
        let names: Vec<String> = whole.weighing.counting().into_iter().collect();
        let told = DesignOptions {
            previous_inputs: Some(inputs),
            like: Some(&whole.design.linearized),
            field: has_knots(inputs),
            only: Some(&names),
            samples: Some(SAMPLES),
            ..DesignOptions::default()
        };
        let here = look(prepared, options, point, told);
        Self {
            prepared,
            options,
            names,
            inputs,
            here,
        }
    }

    /// True if it becomes likelier about another point, or with more told, by some measure of both.
    pub(super) fn is_likelier(
        &self,
        point: &LinearizationPoint,
        told: DesignOptions<'_, 'a>,
        log_evidence: impl Fn(&Look<'a>) -> f64,
    ) -> bool {
        log_evidence(&self.with(point, told)) > log_evidence(&self.here)
    }

    /// Logarithm of the evidence about the point that it is about.
    pub(super) fn log_evidence_here(&self) -> f64 {
        self.here.log_evidence()
    }

    /// The same about another point, with more told.
    pub(super) fn log_evidence(
        &self,
        point: &LinearizationPoint,
        told: DesignOptions<'_, 'a>,
    ) -> f64 {
        self.with(point, told).log_evidence()
    }

    /// True if it is preferred with more told of the effects.
    pub(super) fn is_preferred(
        &self,
        point: &LinearizationPoint,
        told: DesignOptions<'_, 'a>,
    ) -> bool {
        self.with(point, told).is_preferred_to(&self.here)
    }

    /// The comparison among the same blocks about a point, with more told.
    fn with(&self, point: &LinearizationPoint, told: DesignOptions<'_, 'a>) -> Look<'a> {
        let told = DesignOptions {
            previous_inputs: Some(told.previous_inputs.unwrap_or(self.inputs)),
            like: Some(&self.here.design.linearized),
            only: Some(&self.names),
            samples: Some(SAMPLES),
            ..told
        };
        let with = look(self.prepared, self.options, point, told);
        log(&format!("by way of trial {}", compared(&self.here, &with)));
        with
    }
}

/// True where a field over the platen is laid.
pub(super) fn has_knots(inputs: &BasisInputs) -> bool {
    inputs.knots.iter().any(|k| !k.is_empty())
}
