//! Cubic B-splines over the nodes, in whole numbers: a multiplication costs the processor one cycle and waits for nothing, so that
//! the sixteen nodes about a place take half of what they take in f32. Places to 1/32768 of a cell, sums to 0.01 nm.

use crate::frame::Coordinate;

/// Bits of a place in its cell. Derived from 16-bit multiplications: a weight below one has 15 bits and a sign.
const FINE_BITS: u32 = 15;
/// 1 in that scale.
const ONE: i32 = 1 << FINE_BITS;
/// Fractions of a tooth count beyond this many pitches are no place. A prior: phase and count of one reading differ by less than
/// a pitch; an f32 that is no place is anything.
const REACH_TURNS: f32 = 64.0;
/// Bits of the weights across that are given up. Derived from the 32 bits of a line's sum: a weight of 6 · 2^15 has 18, a node
/// 16.
const ASIDE_SHIFT: u32 = 2;
/// Bits of the sum of lines that are given up. Derived from its 32 bits: a line's sum has 32, a weight along 18.
const SUM_SHIFT: u32 = 24;
/// Units of [`sum`] in a nanometre: weights are six times those of the spline. Derived from both shifts: 6 · 6 is 36.
pub(super) const UNITS: f32 = (36_u64 << (2 * FINE_BITS - ASIDE_SHIFT - SUM_SHIFT)) as f32;

/// First of the four nodes about a place, and six times their weights; `None` outside.
#[inline(always)]
pub(super) fn spline(place: Coordinate, first_teeth: i32, nodes: u8) -> Option<(usize, [i32; 4])> {
    // NaN is outside.
    if !(place.fraction_turns.abs() < REACH_TURNS) {
        return None;
    }
    let fine = ((place.fraction_turns + REACH_TURNS) * ONE as f32) as i32;
    let cell = place
        .teeth
        .wrapping_sub(first_teeth)
        .wrapping_sub(REACH_TURNS as i32);
    // The first node's cell begins at the second node.
    let first = cell.wrapping_add((fine >> FINE_BITS) - 1) as u32;
    if first >= u32::from(nodes).saturating_sub(3) {
        return None;
    }
    let t = fine & (ONE - 1);
    let t2 = (t * t) >> FINE_BITS;
    let t3 = (t2 * t) >> FINE_BITS;
    let begin = ONE + 3 * (t2 - t) - t3;
    let second = 4 * ONE + 3 * t3 - 6 * t2;
    // Together they are one.
    let third = 6 * ONE - begin - second - t3;
    Some((first as usize, [begin, second, third, t3]))
}

/// Nodes times weights, in [`UNITS`]; `nodes_nm` from the first node on, `row` to the next line.
#[inline(always)]
pub(super) fn sum(nodes_nm: &[i16], row: usize, along: [i32; 4], aside: [i32; 4]) -> Option<i32> {
    let [a, b, _, d] = aside.map(|weight| weight >> ASIDE_SHIFT);
    // Together they are one.
    let c = ((6 * ONE) >> ASIDE_SHIFT) - a - b - d;
    let (first, second) = (four(nodes_nm, 0)?, four(nodes_nm, row)?);
    let (third, fourth) = (four(nodes_nm, 2 * row)?, four(nodes_nm, 3 * row)?);
    // One by one: a loop would keep its weights in memory.
    let [w, x, y, z] = along;
    let sum = product(line(first, [a, b, c, d]), w)
        + product(line(second, [a, b, c, d]), x)
        + product(line(third, [a, b, c, d]), y)
        + product(line(fourth, [a, b, c, d]), z);
    Some((sum >> SUM_SHIFT) as i32)
}

#[inline(always)]
fn four(nodes_nm: &[i16], first: usize) -> Option<&[i16; 4]> {
    nodes_nm.get(first..)?.first_chunk()
}

#[inline(always)]
fn line(nodes_nm: &[i16; 4], [a, b, c, d]: [i32; 4]) -> i32 {
    let [p, q, r, s] = nodes_nm.map(i32::from);
    p * a + q * b + r * c + s * d
}

#[inline(always)]
fn product(line: i32, weight: i32) -> i64 {
    i64::from(line) * i64::from(weight)
}
