//! Whether a finding is the one that a mistake calls for.

use plausibility::{Finding, Kind};

pub fn exchanged(finding: &Finding, segments: &[usize]) -> bool {
    finding.kind == Kind::SegmentsExchanged && finding.segments == segments
}

pub fn reversed(finding: &Finding, segments: &[usize]) -> bool {
    finding.kind == Kind::SegmentReversed && finding.segments == segments
}

pub fn quadrature(finding: &Finding, segments: &[usize]) -> bool {
    finding.kind == Kind::Quadrature && finding.segments == segments
}

pub fn value(finding: &Finding, kind: Kind, wanted: f64, share: f64) -> bool {
    finding.kind == kind
        && finding
            .found
            .is_some_and(|f| (f / wanted - 1.0).abs() < share)
}
