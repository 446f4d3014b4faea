//! The diagnosis on simulated couriers: what is named, what is left unknown, what a claim is worth.
//!
//! One program of many files: each further program would be linked, and its helpers compiled, once more.

mod against_reference;
mod beside;
mod by_posterior;
mod claims;
mod clip;
mod confusion;
mod coordinates;
mod correction;
mod diode;
mod errors_in_variables;
mod field;
mod forms;
mod hypothesis;
mod late;
mod leftout;
mod logged;
mod motion;
mod noise;
mod one_run;
mod phase;
mod rings;
mod shared;
mod slips;
mod stray_field;
mod wander;
mod whole;
mod winding;
mod without_signal;
