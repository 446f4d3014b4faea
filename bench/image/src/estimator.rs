//! The one large estimator.

use cases::{PACKED, UNKNOWNS};
use courier_sensor::lsq::Estimator;

/// Takes it; afterwards it is gone.
///
/// # Panics
/// On the second call.
pub fn take() -> &'static mut Estimator<UNKNOWNS, PACKED> {
    cortex_m::singleton!(: Estimator<UNKNOWNS, PACKED> = Estimator::new(UNKNOWNS))
        .expect("taken once")
}
