//! An axis with round marks.

/// A range of values.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Axis {
    pub low: f64,
    pub high: f64,
    /// The distance of two marks: 1, 2 or 5 times a power of ten.
    step: f64,
}

/// Number of marks that an axis should have, about.
const MARKS: f64 = 5.0;

impl Axis {
    /// An axis that contains both values and ends at marks.
    pub fn new(low: f64, high: f64) -> Self {
        let (low, high) = if low < high { (low, high) } else { (low - half(low), high + half(high)) };
        let step = step(high - low);
        Self { low: (low / step).floor() * step, high: (high / step).ceil() * step, step }
    }

    /// An axis that ends at the values.
    pub fn exact(low: f64, high: f64) -> Self {
        let high = if low < high { high } else { low + 1.0 };
        Self { low, high, step: step(high - low) }
    }

    /// The position of a value between the low end, 0, and the high one, 1.
    pub fn along(self, value: f64) -> f64 {
        ((value - self.low) / (self.high - self.low)).clamp(0.0, 1.0)
    }

    /// The marks, each with its text.
    pub fn marks(self) -> impl Iterator<Item = (f64, String)> {
        let first = (self.low / self.step).ceil();
        let last = (self.high / self.step).floor();
        // A range so far from zero that its width is lost in rounding has its ends only.
        let count = if last - first < 50.0 { (last - first).max(0.0) as u32 } else { 0 };
        (0..=count).map(move |n| {
            let value = (first + f64::from(n)) * self.step;
            (value, self.text(value))
        })
    }

    /// A value with the decimals that tell two marks apart.
    pub fn text(self, value: f64) -> String {
        let magnitude = self.low.abs().max(self.high.abs());
        if magnitude >= 1e15 || self.step < 1e-9 {
            return format!("{value:e}");
        }
        let decimals = (-self.step.log10().floor()).clamp(0.0, 9.0) as usize;
        // No mark is called "-0".
        format!("{:.decimals$}", if value == 0.0 { 0.0 } else { value })
    }
}

/// Half of the range around a value that does not change.
fn half(value: f64) -> f64 {
    if value == 0.0 { 1.0 } else { value.abs() * 0.1 }
}

fn step(width: f64) -> f64 {
    let rough = width / MARKS;
    let power = 10_f64.powf(rough.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power);
    steps.into_iter().find(|step| rough <= *step * 1.001).unwrap_or(power)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn texts(axis: Axis) -> Vec<String> {
        axis.marks().map(|(_, text)| text).collect()
    }

    #[test]
    fn marks_are_round() {
        assert_eq!(texts(Axis::new(3.0, 97.0)), ["0", "20", "40", "60", "80", "100"]);
        assert_eq!(texts(Axis::new(-0.3, 0.24)), ["-0.4", "-0.2", "0.0", "0.2", "0.4"]);
        assert_eq!(texts(Axis::new(7.0, 7.0)), ["6.0", "6.5", "7.0", "7.5", "8.0"]);
        assert_eq!(texts(Axis::exact(0.0, 2.5)), ["0.0", "0.5", "1.0", "1.5", "2.0", "2.5"]);
    }

    proptest! {
        #[test]
        fn both_ends_are_on_the_axis(low in -1e18_f64..1e18, width in 0.0_f64..1e18) {
            let axis = Axis::new(low, low + width);
            prop_assert!(axis.low <= low && low + width <= axis.high, "{axis:?}");
            prop_assert!(axis.marks().count() <= 51);
            prop_assert!((0.0..=1.0).contains(&axis.along(low)));
        }
    }
}
