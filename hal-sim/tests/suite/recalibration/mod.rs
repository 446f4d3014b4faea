//! Recalibration while working: what slow changes leave of the position with it and without it, what must never come in force, and the board.

mod board;
mod covariance;
mod early;
mod mode;
mod month;
mod position;
mod tries;
