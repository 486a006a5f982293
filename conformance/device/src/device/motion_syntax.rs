//! Motions as a user types them, such as the `~MOTION` of a simulated device.
//!
//! ```text
//! still  still=STEPS          at rest, at that physical position
//! rpm=N                       N revolutions per minute; negative is backwards
//! mm/s=N                      N millimetres per second, of a linear sensor
//! sine=AMPLITUDE,PERIOD       to and fro: revolutions or millimetres to both sides, seconds
//! ramp=RPM,SECONDS            from rest to that speed in that time, then steady
//! csv=FILE                    through the points of a file: seconds and revolutions or millimetres
//! ```

use super::motion::Motion;
use canvass_traces::Duration;
use std::fmt;
use std::str::FromStr;

/// A motion as typed. If it names a file, the points are still missing.
#[derive(Clone, PartialEq, Debug)]
pub enum MotionSpec {
    /// A complete motion.
    Known(Motion),
    /// `csv=FILE`: the caller reads the file and gives its text to [`MotionSpec::from_csv`].
    File(String),
}

/// Why a text is no motion.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum MotionError {
    /// The text has none of the forms.
    #[error(
        "expected a motion such as still, still=1000, rpm=60, mm/s=250, sine=2,10 (revolutions, seconds), ramp=3000,5 \
         (rpm, seconds) or csv=FILE, found \"{0}\""
    )]
    Form(String),
    /// A number is missing or outside its range.
    #[error("{motion}: expected {expected}, found \"{found}\"")]
    Number {
        /// The motion as typed.
        motion: String,
        /// The expected number, with its range.
        expected: &'static str,
        /// The text found.
        found: String,
    },
    /// A line without a valid point.
    #[error("line {line}: expected seconds and revolutions or millimetres, such as 1.5,0.25, found \"{found}\"")]
    Point {
        /// The line, from 1.
        line: usize,
        /// The text found.
        found: String,
    },
    /// A point that is not later than the previous point.
    #[error("line {line}: expected a time after the {before} s of the point before, found {found} s")]
    Order {
        /// The line, from 1.
        line: usize,
        /// The time of the point before.
        before: String,
        /// The time of this point.
        found: String,
    },
    /// The file has no points.
    #[error("expected points, one in a line: seconds and revolutions or millimetres, such as 1.5,0.25; found none")]
    Empty,
}

/// Maximum speed and amplitude that can be typed.
const MOST: f64 = 1e6;
/// Maximum time that can be typed, in seconds: a day.
const LONGEST: f64 = 86_400.0;

impl MotionSpec {
    /// The file to read, if there is one.
    pub fn file(&self) -> Option<&str> {
        match self {
            Self::File(path) => Some(path),
            Self::Known(_) => None,
        }
    }

    /// The motion through the points of a file. A line holds seconds and revolutions (or millimetres), separated by a
    /// comma, a semicolon or white space. Empty lines, lines that begin with `#` and a heading are skipped.
    ///
    /// # Errors
    /// [`MotionError`] with the line of the first invalid point.
    pub fn from_csv(text: &str) -> Result<Motion, MotionError> {
        let mut points: Vec<(f64, f64)> = Vec::new();
        for (n, line) in text.lines().enumerate() {
            let content = line.trim().trim_start_matches('\u{FEFF}');
            if content.is_empty() || content.starts_with('#') {
                continue;
            }
            let Some((time, units)) = point(content) else {
                let is_heading = points.is_empty() && !content.starts_with(|c: char| c.is_ascii_digit() || c == '-');
                if is_heading {
                    continue;
                }
                return Err(MotionError::Point { line: n + 1, found: content.to_owned() });
            };
            if let Some(&(before, _)) = points.last()
                && time <= before
            {
                return Err(MotionError::Order { line: n + 1, before: before.to_string(), found: time.to_string() });
            }
            points.push((time, units));
        }
        if points.is_empty() { Err(MotionError::Empty) } else { Ok(Motion::through(0, &points).millimetres()) }
    }
}

fn point(line: &str) -> Option<(f64, f64)> {
    let mut fields = line.split([',', ';', '\t', ' ']).map(str::trim).filter(|field| !field.is_empty());
    let (time, units): (f64, f64) = (fields.next()?.parse().ok()?, fields.next()?.parse().ok()?);
    let fits = time.is_finite() && time >= 0.0 && units.is_finite() && units.abs() <= MOST && fields.next().is_none();
    fits.then_some((time, units))
}

impl FromStr for MotionSpec {
    type Err = MotionError;

    fn from_str(text: &str) -> Result<Self, MotionError> {
        let form = || MotionError::Form(text.to_owned());
        let number = |value: &str, most: f64, expected| {
            let parsed = value.trim().parse::<f64>().ok().filter(|number| number.abs() <= most);
            parsed.ok_or_else(|| MotionError::Number { motion: text.to_owned(), expected, found: value.to_owned() })
        };
        let time = |value: &str| {
            let expected = "a time in seconds, above 0 and up to 86400";
            let positive = number(value, LONGEST, expected)?;
            let error = || MotionError::Number { motion: text.to_owned(), expected, found: value.to_owned() };
            let nanos = (positive > 0.0).then_some(Duration::from_nanos((positive * 1e9) as u64));
            nanos.ok_or_else(error)
        };
        let speed = |value: &str| number(value, MOST, "a speed from -1000000 to 1000000");
        let motion = match text.split_once('=') {
            None if text == "still" => Motion::default(),
            Some(("still", steps)) => {
                let expected = "a position in steps";
                let error = |_| MotionError::Number { motion: text.to_owned(), expected, found: steps.to_owned() };
                Motion::still(steps.trim().parse().map_err(error)?)
            }
            Some(("rpm", value)) => Motion::constant(0, (speed(value)? * 1e3).round() as i64),
            Some(("mm/s", value)) => Motion::constant(0, (speed(value)? * 60e3).round() as i64).millimetres(),
            Some(("sine", values)) => {
                let (amplitude, period) = values.split_once(',').ok_or_else(form)?;
                Motion::sine(0, number(amplitude, MOST, "an amplitude of at most 1000000")?, time(period)?)
                    .millimetres()
            }
            Some(("ramp", values)) => {
                let (target, rise) = values.split_once(',').ok_or_else(form)?;
                Motion::ramp(0, speed(target)?, time(rise)?)
            }
            Some(("csv", path)) if !path.is_empty() => return Ok(Self::File(path.to_owned())),
            _ => return Err(form()),
        };
        Ok(Self::Known(motion))
    }
}

/// Describes the motion in short, for help texts: the position at rest, `moving`, or the file.
impl fmt::Display for MotionSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Known(motion) if motion.is_still() => write!(f, "still={}", motion.start),
            Self::Known(_) => f.write_str("moving"),
            Self::File(path) => write!(f, "csv={path}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_traces::Timestamp;

    fn known(text: &str) -> Motion {
        match text.parse() {
            Ok(MotionSpec::Known(motion)) => motion,
            other => panic!("{text}: {other:?}"),
        }
    }

    #[test]
    fn every_form() {
        assert_eq!(known("still"), Motion::still(0));
        assert_eq!(known("still=-5"), Motion::still(-5));
        assert_eq!(known("rpm=-3.5"), Motion::constant(0, -3_500));
        assert_eq!(
            known("mm/s=2"),
            Motion::constant(0, 120_000).millimetres(),
            "thousandths of a millimetre per minute"
        );
        assert_eq!(known("sine=2,10"), Motion::sine(0, 2.0, Duration::from_secs(10)).millimetres());
        assert_eq!(known("ramp=3000,0.5"), Motion::ramp(0, 3000.0, Duration::from_millis(500)));
        assert_eq!("csv=a=b.csv".parse(), Ok(MotionSpec::File("a=b.csv".to_owned())));
    }

    #[test]
    fn errors_say_what_would_be_right() {
        let error = |text: &str| text.parse::<MotionSpec>().unwrap_err().to_string();
        for wrong in ["", "spin", "rpm", "sine=2", "csv=", "still="] {
            assert!(error(wrong).contains("expected"), "{}", error(wrong));
        }
        assert!(error("rpm=fast").contains("from -1000000 to 1000000"));
        assert!(error("rpm=NaN").contains("found \"NaN\"") && error("rpm=inf").contains("found \"inf\""));
        assert!(error("sine=1,0").contains("above 0") && error("ramp=1,-2").contains("above 0"));
    }

    #[test]
    fn points_of_a_file() {
        let motion = MotionSpec::from_csv("# profile\ntime,position\n0,0\n\n1.5;2\r\n3 2\n").unwrap();
        assert_eq!(motion.position(Timestamp(3_000_000_000), 100), 200);
        let error = |text: &str| MotionSpec::from_csv(text).unwrap_err().to_string();
        assert!(error("0,0\n1,x").starts_with("line 2:"));
        assert!(error("0,0\n0,1").contains("after the 0 s"));
        assert!(error("t,x").contains("found none"));
        assert!(error("1,1e300").starts_with("line 1"));
    }
}
