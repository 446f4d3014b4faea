//! The tests of this package, in one program.

mod crashes;
mod program_error;
