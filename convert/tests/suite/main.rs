//! Logs become recordings: in every dialect of a table, in other units and by other wires; what looks wrong is told, and nothing makes it
//! panic.

mod dialects;
mod log;
mod programs;
mod recordings;
mod refusals;
mod units;
mod warnings;
