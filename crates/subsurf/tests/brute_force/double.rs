//! Double-double numbers: about 31 digits (Dekker 1971).

use std::ops::{Add, Div, Mul, Sub};

/// The unevaluated sum of two `f64`, the second below half a unit in the last place of the first.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Double(f64, f64);

fn two_sum(a: f64, b: f64) -> Double {
    let s = a + b;
    let c = s - a;
    Double(s, (a - (s - c)) + (b - c))
}

fn quick_two_sum(a: f64, b: f64) -> Double {
    let s = a + b;
    Double(s, b - (s - a))
}

impl Double {
    pub const ZERO: Self = Self(0.0, 0.0);

    pub fn ratio(a: f64, b: f64) -> Self {
        Self::from(a) / Self::from(b)
    }

    pub fn to_f64(self) -> f64 {
        self.0
    }
}

impl From<f64> for Double {
    fn from(x: f64) -> Self {
        Self(x, 0.0)
    }
}

impl Add for Double {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        let s = two_sum(self.0, b.0);
        let t = two_sum(self.1, b.1);
        let s = quick_two_sum(s.0, s.1 + t.0);
        quick_two_sum(s.0, s.1 + t.1)
    }
}

impl Sub for Double {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        self + Self(-b.0, -b.1)
    }
}

impl Mul for Double {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        let p = self.0 * b.0;
        let e = self.0.mul_add(b.0, -p);
        quick_two_sum(p, e + (self.0 * b.1 + self.1 * b.0))
    }
}

impl Div for Double {
    type Output = Self;
    fn div(self, b: Self) -> Self {
        let q = self.0 / b.0;
        let r = self - b * Self::from(q);
        let q2 = r.0 / b.0;
        let r = r - b * Self::from(q2);
        quick_two_sum(q, q2) + Self::from(r.0 / b.0)
    }
}

#[test]
fn a_third_has_31_digits() {
    let third = Double::ratio(1.0, 3.0);
    let rest = third * Double::from(3.0) - Double::from(1.0);
    assert!(rest.0.abs() < 1e-31, "{rest:?}");
}
