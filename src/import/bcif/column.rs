//! Decoded columns: numbers or texts, and which of them are there.

use super::super::number::{parse_f64, parse_i64};
use super::encoding::{Budget, Data, Encoding, Problem, StringArray, Values, decode};
use crate::structure::Positions;
use std::borrow::Cow;

/// The values of a column, one a row.
#[derive(Debug)]
pub(super) struct Column<'a> {
    content: Content<'a>,
    /// 0 present, 1 not applicable (`.`), 2 unknown (`?`); `None` if all are present.
    mask: Option<Vec<u8>>,
}

#[derive(Debug)]
enum Content<'a> {
    /// Numbers and the decimals that write them.
    Numbers(Values, u8),
    /// Texts, each once, and which one a row has; below 0 for none.
    Texts(Vec<&'a str>, Vec<i32>),
}

impl<'a> Column<'a> {
    /// Decodes a column of a table of so many rows.
    pub(super) fn decode(
        data: &Data<'a>,
        mask: Option<&Data<'a>>,
        rows: usize,
        budget: &Budget,
    ) -> Result<Column<'a>, Problem> {
        let content = match data.encodings.first() {
            Some(Encoding::StringArray(array)) => {
                if data.encodings.len() > 1 {
                    return Err(Problem::wrong("StringArray goes with no other encoding"));
                }
                decode_texts(data.bytes, array, budget)?
            }
            _ => {
                let values = decode(data.bytes, &data.encodings, budget)?;
                let decimals = decimals_of(&values);
                Content::Numbers(values, decimals)
            }
        };
        let length = match &content {
            Content::Numbers(values, _) => values.len(),
            Content::Texts(_, indices) => indices.len(),
        };
        if length != rows {
            return Err(Problem::wrong(format!("{length} values in a table of {rows} rows")));
        }
        let mask = match mask {
            Some(mask) => decode_mask(mask, rows, budget)?,
            None => None,
        };
        Ok(Column { content, mask }.with_mask_in_texts())
    }

    /// Texts say themselves which of them are absent, which saves a look at the mask.
    fn with_mask_in_texts(mut self) -> Column<'a> {
        if let Content::Texts(_, indices) = &mut self.content
            && let Some(mask) = self.mask.take()
        {
            for (index, masked) in indices.iter_mut().zip(mask) {
                if masked != 0 {
                    *index = -1;
                }
            }
        }
        self
    }

    /// Whether no row has a value.
    pub(super) fn is_void(&self) -> bool {
        match (&self.content, &self.mask) {
            (Content::Texts(_, indices), _) => indices.iter().all(|&index| index < 0),
            (_, Some(mask)) => mask.iter().all(|&masked| masked != 0),
            _ => false,
        }
    }

    #[inline]
    fn is_absent(&self, row: usize) -> bool {
        self.mask.as_ref().is_some_and(|mask| mask.get(row) != Some(&0))
    }

    /// The value as a number and its decimals.
    #[inline]
    pub(super) fn number(&self, row: usize) -> Option<(f64, u8)> {
        if self.is_absent(row) {
            return None;
        }
        match &self.content {
            Content::Numbers(values, decimals) => Some((number_at(values, row, *decimals)?, *decimals)),
            Content::Texts(texts, indices) => number_of(text_at(texts, indices, row)?),
        }
    }

    /// The value as a whole number.
    #[inline]
    pub(super) fn integer(&self, row: usize) -> Option<i64> {
        if self.is_absent(row) {
            return None;
        }
        match &self.content {
            Content::Numbers(Values::Integers { values, unsigned }, _) => {
                values.get(row).map(|&value| if *unsigned { i64::from(value as u32) } else { i64::from(value) })
            }
            Content::Numbers(values, decimals) => {
                let value = number_at(values, row, *decimals)?;
                (value.fract() == 0.0 && value.abs() < 2f64.powi(53)).then_some(value as i64)
            }
            Content::Texts(texts, indices) => parse_i64(text_at(texts, indices, row)?.as_bytes()),
        }
    }

    /// The value as text.
    #[inline]
    pub(super) fn text(&self, row: usize) -> Option<Cow<'_, str>> {
        if self.is_absent(row) {
            return None;
        }
        match &self.content {
            Content::Texts(texts, indices) => text_at(texts, indices, row).map(Cow::Borrowed),
            Content::Numbers(Values::Integers { values, unsigned: false }, _) => {
                values.get(row).map(|value| Cow::Owned(value.to_string()))
            }
            Content::Numbers(values, decimals) => {
                let value = number_at(values, row, *decimals)?;
                let digits = usize::from(*decimals);
                Some(Cow::Owned(if *decimals < Positions::MAX_DECIMALS {
                    format!("{value:.digits$}")
                } else {
                    value.to_string()
                }))
            }
        }
    }
}

/// Of whole columns, for [`super::sites`]. `None` where a value is anything else than what is asked for.
impl<'a> Column<'a> {
    /// The texts, each once, and which one a row has; below 0 for none.
    pub(super) fn texts(self) -> Option<(Vec<&'a str>, Vec<i32>)> {
        match self.content {
            Content::Texts(texts, indices) => Some((texts, indices)),
            Content::Numbers(..) => None,
        }
    }

    /// What the texts mean.
    pub(super) fn meanings<T: Copy>(self, absent: T, meaning: impl Fn(&str) -> Option<T>) -> Option<Vec<T>> {
        let (texts, indices) = self.texts()?;
        let meanings: Vec<Option<T>> = texts.into_iter().map(meaning).collect();
        // Texts without a meaning may be there, as long as no row has one.
        let is_odd = |&index: &i32| meaning_at(&meanings, index).is_some_and(|meaning| meaning.is_none());
        if meanings.iter().any(Option::is_none) && indices.iter().any(is_odd) {
            return None;
        }
        let meanings: Vec<T> = meanings.into_iter().map(|meaning| meaning.unwrap_or(absent)).collect();
        Some(indices.into_iter().map(|index| meaning_at(&meanings, index).unwrap_or(absent)).collect())
    }

    /// Whole numbers, [`ABSENT_NUMBER`] where there is none.
    pub(super) fn whole_numbers(self) -> Option<Vec<i32>> {
        let number = |text: &str| parse_i64(text.as_bytes()).and_then(|number| i32::try_from(number).ok());
        let Column { content: Content::Numbers(Values::Integers { mut values, unsigned }, _), mask } = self else {
            return self.meanings(ABSENT_NUMBER, |text| number(text).filter(|&number| number != ABSENT_NUMBER));
        };
        if let Some(mask) = &mask {
            for (value, masked) in values.iter_mut().zip(mask) {
                *value = match masked {
                    0 if unsigned && *value < 0 || *value == ABSENT_NUMBER => return None,
                    0 => *value,
                    _ => ABSENT_NUMBER,
                };
            }
        } else if values.iter().any(|&value| unsigned && value < 0 || value == ABSENT_NUMBER) {
            return None;
        }
        Some(values)
    }

    /// Numbers in single precision; `default` where there is none, or an absurd one.
    pub(super) fn singles(self, default: f32) -> Option<Vec<f32>> {
        let sound = |value: f64| if value.abs() < 1e30 { value as f32 } else { default };
        let Content::Numbers(values, decimals) = &self.content else {
            return self.meanings(default, |text| Some(number_of(text).map_or(default, |(value, _)| sound(value))));
        };
        let mut singles = Vec::with_capacity(values.len());
        let mut some = [0.0; 256];
        for first in (0..values.len()).step_by(some.len()) {
            let some = &mut some[..(values.len() - first).min(256)];
            numbers_at(values, first, *decimals, some)?;
            singles.extend(some.iter().map(|&value| sound(value)));
        }
        if let Some(mask) = &self.mask {
            singles.iter_mut().zip(mask).filter(|(_, masked)| **masked != 0).for_each(|(value, _)| *value = default);
        }
        Some(singles)
    }

    /// Decimals of a column of nothing but numbers, one in every row.
    pub(super) fn decimals(&self) -> Option<u8> {
        match (&self.content, &self.mask) {
            (Content::Numbers(_, decimals), None) => Some(*decimals),
            _ => None,
        }
    }

    /// Some numbers of a column that has [`Column::decimals`].
    pub(super) fn numbers(&self, first: usize, some: &mut [f64]) -> Option<()> {
        match &self.content {
            Content::Numbers(values, decimals) => numbers_at(values, first, *decimals, some),
            Content::Texts(..) => None,
        }
    }
}

/// What stands for no number.
pub(super) const ABSENT_NUMBER: i32 = i32::MIN;

/// What a row has; `None` below 0.
#[inline]
pub(super) fn meaning_at<T: Copy>(meanings: &[T], index: i32) -> Option<T> {
    meanings.get(usize::try_from(index).ok()?).copied()
}

/// As [`number_at`], of the rows from `first` on.
#[inline]
fn numbers_at(values: &Values, first: usize, decimals: u8, some: &mut [f64]) -> Option<()> {
    fn each<T: Copy>(values: &[T], first: usize, some: &mut [f64], number: impl Fn(T) -> f64) -> Option<()> {
        let values = values.get(first..first + some.len())?;
        some.iter_mut().zip(values).for_each(|(slot, &value)| *slot = number(value));
        Some(())
    }
    match values {
        Values::Integers { values, unsigned: false } => each(values, first, some, f64::from),
        Values::Integers { values, unsigned: true } => each(values, first, some, |value| f64::from(value as u32)),
        Values::Fixed { values, factor } => each(values, first, some, |value| f64::from(value) / factor),
        Values::Interval { values, min, step } => each(values, first, some, |value| min + f64::from(value) * step),
        Values::Singles(values) => each(values, first, some, |value| from_single(value, decimals)),
        Values::Doubles(values) => each(values, first, some, |value| value),
    }
}

#[inline]
fn text_at<'a>(texts: &[&'a str], indices: &[i32], row: usize) -> Option<&'a str> {
    let index = usize::try_from(*indices.get(row)?).ok()?;
    texts.get(index).copied()
}

/// A number in text, without its standard uncertainty (`1.234(5)`).
fn number_of(text: &str) -> Option<(f64, u8)> {
    let number = text.split_once('(').map_or(text, |(number, _)| number);
    parse_f64(number.as_bytes())
}

#[inline]
fn number_at(values: &Values, row: usize, decimals: u8) -> Option<f64> {
    Some(match values {
        Values::Integers { values, unsigned: false } => f64::from(*values.get(row)?),
        Values::Integers { values, unsigned: true } => f64::from(*values.get(row)? as u32),
        Values::Fixed { values, factor } => f64::from(*values.get(row)?) / factor,
        Values::Interval { values, min, step } => min + f64::from(*values.get(row)?) * step,
        Values::Singles(values) => from_single(*values.get(row)?, decimals),
        Values::Doubles(values) => *values.get(row)?,
    })
}

/// Powers of ten up to the most decimals that single-precision numbers are given.
const TEN: [f64; 10] = [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9];

/// The decimal of so many digits that a single-precision number stands for: 1.1 and not 1.10000002384.
#[inline]
fn from_single(value: f32, decimals: u8) -> f64 {
    let value = f64::from(value);
    match TEN.get(usize::from(decimals)) {
        Some(scale) => (value * scale).round() / scale,
        None => value,
    }
}

/// The decimals that write all values of a column.
fn decimals_of(values: &Values) -> u8 {
    // The fewest decimals whose unit is no larger than this.
    let unit_of = |unit: f64| (0..Positions::MAX_DECIMALS).find(|&d| 10f64.powi(-i32::from(d)) <= unit * (1.0 + 1e-9));
    match values {
        Values::Integers { .. } => 0,
        Values::Fixed { factor, .. } => unit_of(1.0 / factor).unwrap_or(Positions::MAX_DECIMALS),
        // Half a step tells each from the next.
        Values::Interval { step, .. } => unit_of(step.abs() * 0.5).unwrap_or(Positions::MAX_DECIMALS),
        Values::Singles(values) => decimals_of_singles(values),
        Values::Doubles(values) => super::super::number::decimals_of(values, 0),
    }
}

fn decimals_of_singles(values: &[f32]) -> u8 {
    let mut decimals = 0;
    for &value in values {
        while from_single(value, decimals) as f32 != value && value.is_finite() {
            decimals += 1;
            if usize::from(decimals) >= TEN.len() {
                return Positions::MAX_DECIMALS;
            }
        }
    }
    decimals
}

fn decode_mask(mask: &Data<'_>, rows: usize, budget: &Budget) -> Result<Option<Vec<u8>>, Problem> {
    let values = decode(mask.bytes, &mask.encodings, budget)?.integers()?;
    if values.len() != rows {
        return Err(Problem::wrong(format!("a mask of {} values in a table of {rows} rows", values.len())));
    }
    if let Some(odd) = values.iter().find(|value| !(0..=2).contains(*value)) {
        return Err(Problem::wrong(format!("a mask of {odd}, where it can be 0, 1 or 2")));
    }
    let all_present = values.iter().all(|&value| value == 0);
    Ok((!all_present).then(|| values.into_iter().map(|value| value as u8).collect()))
}

fn decode_texts<'a>(bytes: &[u8], array: &StringArray<'a>, budget: &Budget) -> Result<Content<'a>, Problem> {
    let text = std::str::from_utf8(array.text).map_err(|_| Problem::wrong("the texts are no UTF-8"))?;
    let offsets = decode(array.offsets.bytes, &array.offsets.encodings, budget)?.integers()?;
    let place = places_in(text, offsets.last().copied());
    budget.spend(offsets.len(), size_of::<&str>())?;
    let mut texts = Vec::with_capacity(offsets.len().saturating_sub(1));
    for pair in offsets.windows(2) {
        let part = place(pair[0]).zip(place(pair[1])).and_then(|(from, to)| text.get(from..to));
        texts.push(part.ok_or_else(|| {
            Problem::wrong(format!("a text from {} to {} of {} bytes of text", pair[0], pair[1], text.len()))
        })?);
    }
    let indices = decode(bytes, &array.index_encodings, budget)?.integers()?;
    if let Some(odd) = indices.iter().find(|&&index| usize::try_from(index).is_ok_and(|index| index >= texts.len())) {
        return Err(Problem::wrong(format!("text {odd} of {}", texts.len())));
    }
    Ok(Content::Texts(texts, indices))
}

/// From offsets to byte offsets. The specification leaves open what offsets count: bytes, characters (Python), or
/// UTF-16 units (JavaScript), which all are the same in ASCII; else the last offset tells.
fn places_in(text: &str, last: Option<i32>) -> impl Fn(i32) -> Option<usize> {
    let last = last.and_then(|last| usize::try_from(last).ok());
    let table: Option<Vec<usize>> = (!text.is_ascii() && last != Some(text.len())).then(|| {
        let by_character = last == Some(text.chars().count());
        let mut places = Vec::with_capacity(text.len() + 1);
        for (at, c) in text.char_indices() {
            let units = if by_character { 1 } else { c.len_utf16() };
            places.resize(places.len() + units, at);
        }
        places.push(text.len());
        places
    });
    move |offset| {
        let offset = usize::try_from(offset).ok()?;
        match &table {
            Some(places) => places.get(offset).copied(),
            None => Some(offset),
        }
    }
}
