//! One posterior over sets of effects: how probable each set is, given the recording, and what follows for the verdict.
//!
//! The equations stand in `docs/formulation.md`, each with the function that computes it. The modules, in the order of the work:
//!
//! - [`problem`]: what is asked. [`reduced`]: normal equations without the baseline, [`own_axes`]: with each block in its own axes. [`prior`]:
//!   what is supposed of an effect. [`eliminated`]: a set's equations solved, [`beside`]: what is left of others.
//! - [`scale`]: the integral over a size that is known by its order of magnitude, [`size_likelihood`]: what is integrated. [`evidence`]: the probability of the data under a set.
//!   [`noise_scale`]: the integral over the noise, `quieter_noise`: how loud it is at most where it is stated too loud. [`discrepancy`]: what the effects' forms lack. [`least_size`]: what makes an effect worth a name. [`nameless`]: shapes that no effect
//!   owns.
//! - [`weighed`]: a set with its weight. [`walk`]: the way through the sets at one noise. [`sets`]: the noise, and all sets.
//! - [`alias`]: sets that predict the same. `telling`: what may be told of a set. [`hypotheses`]: what sets say of a gap. [`decision`]: the verdict. [`explained`]: the likeliest sets, told.
//! - [`held_out`]: what pieces that were not fitted say of a set. [`weighing`]: all that of a design. `look`: the same with its fits, `trial`: among few blocks.
//! - [`diagnosed`]: all that of a recording. [`fuller`] tells more of its effects, `by_noise` tries another noise, `field` looks for displaced teeth, and [`unlogged`] names
//!   causes whose quantity was not logged. [`form_error`] measures how far an effect's form is from a recording of it alone.

pub mod alias;
pub mod beside;
mod by_noise;
pub mod decision;
pub mod diagnosed;
pub mod discrepancy;
pub mod eliminated;
pub mod evidence;
pub mod explained;
mod field;
pub mod form_error;
pub mod fuller;
pub mod held_out;
pub mod hypotheses;
pub mod least_size;
pub(crate) mod look;
pub mod nameless;
pub mod noise_scale;
pub mod own_axes;
pub mod prior;
pub mod problem;
mod quieter_noise;
pub mod reduced;
pub mod scale;
pub mod sets;
pub mod size_likelihood;
mod telling;
mod trial;
pub mod unlogged;
pub mod walk;
pub mod weighed;
pub mod weighing;

#[cfg(test)]
mod tests;
