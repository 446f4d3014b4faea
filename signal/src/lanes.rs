//! Two of the same computation side by side, operation by operation.
//!
//! A result of the Cortex-M4F's floating-point unit that the very next instruction needs costs a stall. Both segments of
//! a pair are therefore computed in lockstep: the other lane's operation comes between. Plain f32 operations in a fixed
//! order, so the same bits as one lane at a time.

use core::array::from_fn;
use core::ops::{Add, Mul, Sub};

/// What the polynomials of [`crate::math`] need of a number: one f32 or two.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Add<f32, Output = Self>
    + Sub<f32, Output = Self>
    + Mul<f32, Output = Self>
{
    /// The number of which the bits are a function of this one's.
    fn map_bits(self, f: impl Fn(u32) -> u32) -> Self;
}

impl Real for f32 {
    #[inline(always)]
    fn map_bits(self, f: impl Fn(u32) -> u32) -> Self {
        Self::from_bits(f(self.to_bits()))
    }
}

impl Real for Lanes {
    #[inline(always)]
    fn map_bits(self, f: impl Fn(u32) -> u32) -> Self {
        Self::from_bits(self.bits().map(f))
    }
}

/// One value of each lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lanes(pub [f32; 2]);

/// The same as raw bits.
pub type Bits = [u32; 2];

impl Lanes {
    /// From a function of the lane, 0 or 1.
    #[inline(always)]
    pub fn new(f: impl FnMut(usize) -> f32) -> Self {
        Self(from_fn(f))
    }

    /// Both lanes' bits.
    #[inline(always)]
    pub fn bits(self) -> Bits {
        self.0.map(f32::to_bits)
    }

    /// From bits.
    #[inline(always)]
    pub fn from_bits(bits: Bits) -> Self {
        Self(bits.map(f32::from_bits))
    }
}

impl Add for Lanes {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self([self.0[0] + other.0[0], self.0[1] + other.0[1]])
    }
}

impl Sub for Lanes {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self([self.0[0] - other.0[0], self.0[1] - other.0[1]])
    }
}

impl Mul for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self([self.0[0] * other.0[0], self.0[1] * other.0[1]])
    }
}

impl Add<f32> for Lanes {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: f32) -> Self {
        Self([self.0[0] + other, self.0[1] + other])
    }
}

impl Sub<f32> for Lanes {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: f32) -> Self {
        Self([self.0[0] - other, self.0[1] - other])
    }
}

impl Mul<f32> for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: f32) -> Self {
        Self([self.0[0] * other, self.0[1] * other])
    }
}
