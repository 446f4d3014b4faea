//! Guided capture: what a recording tells already, what it does not, and which motion to make next.
//!
//! All of it is values in, values out. [`choice::Outlook`] takes what was recorded and a question and tells what is determined,
//! with its predicted deviation; [`choice::Outlook::next`] takes what is not and the motions that may follow, and chooses that of most expected
//! information a second (D-optimal, greedy: Fedorov 1972, Theory of Optimal Experiments). Columns and their products are the
//! diagnosis' own, so what counts as told is what the diagnosis would call told. [`triangle`] is the algebra by which
//! `courier isolability` says the same of a calibration before anything moves.

pub mod choice;
pub mod cover;
mod given;
pub mod hand;
pub mod known;
pub mod motion;
mod products;
pub mod question;
pub mod triangle;
