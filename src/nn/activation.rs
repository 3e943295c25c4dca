//! Activation functions, written so that the compiler can vectorise them.

/// Beyond this, the quotient below equals 1 in f32.
const SATURATED: f32 = 7.905_311;

/// The hyperbolic tangent as a quotient of polynomials. The error is below 4e-7 everywhere,
/// which a test checks. The standard library's `tanh` is a call per number and takes longer
/// than the matrix products around it.
///
/// Coefficients: Eigen, `generic_fast_tanh_float` (MathFunctionsImpl.h).
#[inline(always)]
pub(crate) fn tanh(x: f32) -> f32 {
    let x = x.clamp(-SATURATED, SATURATED);
    let square = x * x;
    let mut odd = -2.760_768_5e-16;
    for coefficient in [
        2.000_188e-13,
        -8.604_672e-11,
        5.122_297e-8,
        1.485_722_4e-5,
        6.372_619e-4,
        4.893_524_6e-3,
    ] {
        odd = odd * square + coefficient;
    }
    let mut even = 1.198_258_4e-6;
    for coefficient in [1.185_347_1e-4, 2.268_434_6e-3, 4.893_525e-3] {
        even = even * square + coefficient;
    }
    x * odd / even
}

/// The activation between two layers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Activation {
    /// The hyperbolic tangent, the default of Stable-Baselines3.
    Tanh,
    /// `max(x, 0)`.
    Relu,
}

impl Activation {
    /// Applies the activation in place.
    pub fn apply(self, values: &mut [f32]) {
        match self {
            Self::Tanh => values.iter_mut().for_each(|v| *v = tanh(*v)),
            Self::Relu => values.iter_mut().for_each(|v| *v = v.max(0.0)),
        }
    }

    /// Multiplies `gradient` by the derivative, given the output of [`Activation::apply`].
    pub(crate) fn backward(self, output: &[f32], gradient: &mut [f32]) {
        let pairs = gradient.iter_mut().zip(output);
        match self {
            Self::Tanh => pairs.for_each(|(g, y)| *g *= 1.0 - y * y),
            Self::Relu => pairs.for_each(|(g, y)| *g = if *y > 0.0 { *g } else { 0.0 }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tanh_is_as_close_as_it_says() {
        let mut worst = 0.0f64;
        for i in -1_200_000..=1_200_000 {
            let x = i as f32 * 1e-5;
            worst = worst.max((f64::from(tanh(x)) - f64::from(x).tanh()).abs());
        }
        assert!(worst < 4e-7, "{worst:e}");
        for x in [1e-30f32, 1e-6, 20.0, 1e30, f32::INFINITY] {
            assert!(
                (f64::from(tanh(x)) - f64::from(x).tanh()).abs() < 4e-7,
                "{x}"
            );
            assert_eq!(tanh(-x), -tanh(x));
        }
    }
}
