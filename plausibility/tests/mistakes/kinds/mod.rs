//! What people do wrong with wires, columns and units: a line each.

mod columns;
mod findings;
mod mistake;
mod rows;
mod stated;
mod wires;

pub use mistake::{Mistake, made, recognised};

/// All of them, in an order that recordings are drawn by: a new one goes to the end.
pub fn all() -> Vec<&'static Mistake> {
    let lists = [wires::KINDS, stated::KINDS, columns::KINDS];
    lists.into_iter().flatten().collect()
}
