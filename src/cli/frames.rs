//! Which frames of a trajectory a film shows: `--frames`.

use std::str::FromStr;

/// From the first to the last, counted from 1, in steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameRange {
    /// The first one.
    pub first: u32,
    /// The last one; `None` for the last that there is.
    pub last: Option<u32>,
    /// How many frames further the next one is.
    pub step: u32,
}

impl FrameRange {
    /// Every frame.
    pub const ALL: FrameRange = FrameRange { first: 1, last: None, step: 1 };

    /// The numbers, from 0, of the frames of a file that has so many.
    ///
    /// # Errors
    /// If it does not have the first or the last one.
    pub fn of(self, count: usize) -> Result<Vec<usize>, String> {
        let there = u32::try_from(count).unwrap_or(u32::MAX);
        let last = self.last.unwrap_or(there);
        if last > there || self.first > there {
            return Err(format!("--frames {self}: there are only {count} frames"));
        }
        Ok((self.first..=last).step_by(self.step as usize).map(|frame| frame as usize - 1).collect())
    }
}

impl std::fmt::Display for FrameRange {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (*self, self.last) {
            (FrameRange::ALL, _) => return f.write_str("all"),
            (_, Some(last)) => write!(f, "{}-{last}", self.first)?,
            (_, None) => write!(f, "{}-", self.first)?,
        }
        if self.step == 1 { Ok(()) } else { write!(f, ":{}", self.step) }
    }
}

impl FromStr for FrameRange {
    type Err = String;

    fn from_str(text: &str) -> Result<FrameRange, String> {
        let wrong = || "expected FIRST-LAST or FIRST-LAST:STEP, counted from 1, such as 1-100:2, 50- or all".to_owned();
        let number = |text: &str| text.trim().parse().ok().filter(|&n: &u32| n > 0);
        let (range, step) = match text.split_once(':') {
            Some((range, step)) => (range.trim(), number(step).ok_or_else(wrong)?),
            None => (text.trim(), 1),
        };
        let (first, last) = match range.split_once('-') {
            _ if range.eq_ignore_ascii_case("all") || range.is_empty() && step > 1 => (1, None),
            Some((first, "")) => (number(first).ok_or_else(wrong)?, None),
            Some((first, last)) => (number(first).ok_or_else(wrong)?, Some(number(last).ok_or_else(wrong)?)),
            None => return Err(wrong()),
        };
        if last.is_some_and(|last| last < first) {
            return Err(wrong());
        }
        Ok(FrameRange { first, last, step })
    }
}

#[cfg(test)]
mod tests {
    use super::super::values::tests::check;
    use super::*;

    #[test]
    fn ranges_of_frames() {
        let range = |first, last, step| FrameRange { first, last, step };
        check(
            &[
                ("all", FrameRange::ALL),
                ("1-100:2", range(1, Some(100), 2)),
                ("5-5", range(5, Some(5), 1)),
                ("50-", range(50, None, 1)),
                (":10", range(1, None, 10)),
                ("ALL:3", range(1, None, 3)),
            ],
            &["", "5", "0-3", "3-1", "1-2:0", "a-b", "-5", "1-2-3", ":", "1:2", "5000000000-"],
        );
        assert_eq!(range(1, Some(10), 4).of(10).unwrap(), [0, 4, 8]);
        assert_eq!(range(9, None, 1).of(10).unwrap(), [8, 9]);
        assert!(range(1, Some(11), 1).of(10).unwrap_err().contains("only 10 frames"));
        assert!(range(11, None, 1).of(10).is_err());
    }
}
