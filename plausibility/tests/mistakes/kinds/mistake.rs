//! A mistake: what it does to a recording, and what has to be told of it.

use crate::draw::Needs;
use plausibility::Finding;
use recording::{Meta, Recording, Row};

/// A mistake.
pub struct Mistake {
    /// Its name.
    pub name: &'static str,
    /// What a recording must hold for it to be seen.
    pub needs: Needs,
    /// Made in the stated values.
    pub meta: fn(&mut Meta),
    /// Made in a row.
    pub row: fn(&mut Row, &Meta),
    /// The finding that names it.
    pub right: fn(&Finding, &Meta) -> bool,
}

pub const NOTHING: Needs = Needs {
    beacon: false,
    reference: false,
    positions: false,
    single: false,
    long_lever: false,
};
pub const BEACON: Needs = Needs {
    beacon: true,
    ..NOTHING
};
pub const LONG_LEVER: Needs = Needs {
    long_lever: true,
    ..BEACON
};
pub const REFERENCE: Needs = Needs {
    reference: true,
    ..NOTHING
};
pub const POSITIONS: Needs = Needs {
    positions: true,
    ..BEACON
};
pub const SINGLE: Needs = Needs {
    single: true,
    ..REFERENCE
};

/// A mistake in the rows alone.
pub const fn rows(
    name: &'static str,
    needs: Needs,
    row: fn(&mut Row, &Meta),
    right: fn(&Finding, &Meta) -> bool,
) -> Mistake {
    Mistake {
        name,
        needs,
        meta: |_| {},
        row,
        right,
    }
}

/// A mistake in the stated values alone.
pub const fn stated(
    name: &'static str,
    needs: Needs,
    meta: fn(&mut Meta),
    right: fn(&Finding, &Meta) -> bool,
) -> Mistake {
    Mistake {
        name,
        needs,
        meta,
        row: |_, _| {},
        right,
    }
}

/// The recording with the mistake made.
pub fn made(mistake: &Mistake, right: &Recording) -> Recording {
    let mut wrong = right.with_rows(|_, row| {
        (mistake.row)(row, &right.meta);
        true
    });
    (mistake.meta)(&mut wrong.meta);
    wrong
}

/// True if a finding names the mistake, alone or as one of what explains the readings equally well.
pub fn recognised(mistake: &Mistake, findings: &[Finding], meta: &Meta) -> bool {
    let named = |f: &Finding| (mistake.right)(f, meta);
    let instead = findings
        .iter()
        .flat_map(|f| &f.or)
        .any(|or| or.iter().any(named));
    findings.iter().any(named) || instead
}
