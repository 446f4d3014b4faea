//! How few poses a session may have.

use crate::frame::SEGMENTS;

/// Rows beyond the unknowns that a fit must have. Derived from the degrees of freedom: the noise is then known to 18 %.
const REDUNDANCY: u32 = 16;
/// Unknowns of equation (3). By definition two coefficients of four orders for each segment, and one offset.
const EQUATION_3_UNKNOWNS: u32 = 2 * 4 * SEGMENTS as u32 + 1;
/// Fewest poses of a session that fits equation (3); one that fits more says so when it is ordered.
pub const LEAST_POSES: u32 = least_poses(EQUATION_3_UNKNOWNS);

/// Fewest poses that determine so many unknowns and show whether they do.
pub(super) const fn least_poses(unknowns: u32) -> u32 {
    unknowns + REDUNDANCY
}
