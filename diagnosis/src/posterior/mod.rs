//! One posterior over sets of effects: how probable each set is, given the recording, and what follows for the verdict.
//!
//! The equations stand in `docs/formulation.md`, each with the function that computes it. The modules stand in the order of the work:
//! [`problem`] is what is asked; [`reduced`] eliminates the baseline from the normal equations; [`scale`] integrates over a size that is known by its order of
//! magnitude; [`evidence`] is the probability of the data under a set; [`noise_scale`] integrates over the noise; [`least_size`] asks
//! that an effect be worth naming; [`nameless`] adds shapes that no effect owns; [`weighed`] is a set with its weight, [`walk`] goes through the sets at one noise, and [`sets`] finds the noise;
//! [`alias`] finds those that predict the same; [`decision`] makes the verdict; [`explained`] tells the likeliest sets; [`prior`] and
//! [`weighing`] join all that to the catalogue and a design, and [`diagnosed`] to a recording, of whose effects [`fuller`] tells more.

pub mod alias;
pub mod decision;
pub mod diagnosed;
pub mod evidence;
pub mod explained;
pub mod fuller;
pub mod least_size;
pub mod nameless;
pub mod noise_scale;
pub mod prior;
pub mod problem;
pub mod reduced;
pub mod scale;
pub mod sets;
pub mod walk;
pub mod weighed;
pub mod weighing;

#[cfg(test)]
mod tests;
