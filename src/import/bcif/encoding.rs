//! The encodings of BinaryCIF columns: what they say, and how they are undone.
//!
//! A column's bytes went through a list of encodings; they are undone from the last to the first. Between two steps
//! the values are raw bytes of a stated type, 32-bit integers, or floating-point numbers, and each step takes only
//! what it can have given. Integers that fixed-point numbers were turned into stay integers ([`Values::Fixed`]), so that
//! 1234 at a factor of 1000 becomes the f64 that the text `1.234` is.

use super::msgpack::{Cursor, Malformed, Token};
use crate::stop::Stop;
use std::sync::atomic::{AtomicU64, Ordering};

/// The types of the specification by their numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Int8,
    Int16,
    Int32,
    Uint8,
    Uint16,
    Uint32,
    Float32,
    Float64,
}

impl Kind {
    fn from_number(number: i64) -> Option<Kind> {
        Some(match number {
            1 => Kind::Int8,
            2 => Kind::Int16,
            3 => Kind::Int32,
            4 => Kind::Uint8,
            5 => Kind::Uint16,
            6 => Kind::Uint32,
            32 => Kind::Float32,
            33 => Kind::Float64,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Kind::Int8 | Kind::Uint8 => 1,
            Kind::Int16 | Kind::Uint16 => 2,
            Kind::Int32 | Kind::Uint32 | Kind::Float32 => 4,
            Kind::Float64 => 8,
        }
    }
}

/// One step.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Encoding<'a> {
    ByteArray(Kind),
    FixedPoint { factor: f64 },
    IntervalQuantization { min: f64, max: f64, steps: i64 },
    RunLength { kind: Kind, size: usize },
    Delta { kind: Kind, origin: i64 },
    IntegerPacking { byte_count: i64, size: usize, unsigned: bool },
    StringArray(Box<StringArray<'a>>),
}

/// Texts, each once, and where they begin.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct StringArray<'a> {
    pub(super) text: &'a [u8],
    pub(super) offsets: Data<'a>,
    /// How the indices into the texts are encoded.
    pub(super) index_encodings: Vec<Encoding<'a>>,
}

/// Bytes and what was done to them.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Data<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) encodings: Vec<Encoding<'a>>,
}

/// Steps that one column may have gone through; encoders use four.
const MAX_STEPS: u32 = 16;

impl<'a> Data<'a> {
    /// Reads `{data, encoding}`; `None` for `nil`, a mask that is not there.
    pub(super) fn read(cursor: &mut Cursor<'a>) -> Result<Option<Data<'a>>, Malformed> {
        let mut ahead = cursor.clone();
        if ahead.token()? == Token::Nil {
            *cursor = ahead;
            return Ok(None);
        }
        let mut data = Data::default();
        for _ in 0..cursor.map("the data of a column")? {
            match cursor.text("a key")? {
                b"data" => data.bytes = cursor.bytes("the bytes of a column")?,
                b"encoding" => data.encodings = read_encodings(cursor, true)?,
                _ => cursor.skip()?,
            }
        }
        Ok(Some(data))
    }
}

fn read_encodings<'a>(cursor: &mut Cursor<'a>, with_texts: bool) -> Result<Vec<Encoding<'a>>, Malformed> {
    let count = cursor.array("a list of encodings")?;
    let here = cursor.position();
    if count > MAX_STEPS {
        return Err(Malformed::Unexpected(here, "at most 16 encodings"));
    }
    (0..count).map(|_| read_encoding(cursor, with_texts)).collect()
}

/// Everything that an encoding may state.
#[derive(Default)]
struct Fields<'a> {
    name: &'a [u8],
    numbers: [Option<f64>; 10],
    text: Option<&'a [u8]>,
    offsets: Option<&'a [u8]>,
    data_encodings: Vec<Encoding<'a>>,
    offset_encodings: Vec<Encoding<'a>>,
}

const NUMBERS: [&[u8]; 10] =
    [b"type", b"factor", b"srcType", b"min", b"max", b"numSteps", b"srcSize", b"origin", b"byteCount", b"isUnsigned"];

impl Fields<'_> {
    fn number(&self, name: &str) -> Option<f64> {
        let index = NUMBERS.iter().position(|other| *other == name.as_bytes())?;
        self.numbers[index]
    }

    /// A whole number.
    fn whole(&self, name: &str) -> Option<i64> {
        self.number(name).filter(|value| value.fract() == 0.0 && value.abs() < 2f64.powi(53)).map(|value| value as i64)
    }

    fn size(&self) -> Option<usize> {
        self.whole("srcSize").and_then(|size| usize::try_from(size).ok())
    }

    /// The source's type; 32-bit integers where it is not stated.
    fn source(&self) -> Kind {
        self.whole("srcType").and_then(Kind::from_number).unwrap_or(Kind::Int32)
    }
}

fn read_encoding<'a>(cursor: &mut Cursor<'a>, with_texts: bool) -> Result<Encoding<'a>, Malformed> {
    let at = cursor.position();
    let mut fields = Fields::default();
    for _ in 0..cursor.map("an encoding")? {
        match cursor.text("a key")? {
            b"kind" => fields.name = cursor.text("the name of an encoding")?,
            b"stringData" => fields.text = Some(cursor.bytes("text")?),
            b"offsets" => fields.offsets = Some(cursor.bytes("offsets")?),
            // Texts within texts make no sense; so one level is all that can nest.
            b"dataEncoding" if with_texts => fields.data_encodings = read_encodings(cursor, false)?,
            b"offsetEncoding" if with_texts => fields.offset_encodings = read_encodings(cursor, false)?,
            key => match NUMBERS.iter().position(|name| *name == key) {
                Some(index) => match cursor.token()? {
                    Token::Integer(value) => fields.numbers[index] = Some(value as f64),
                    Token::Float(value) => fields.numbers[index] = Some(value),
                    Token::Bool(value) => fields.numbers[index] = Some(f64::from(u8::from(value))),
                    Token::Nil => {}
                    _ => return Err(Malformed::Unexpected(at, "numbers as the parameters of an encoding")),
                },
                None => cursor.skip()?,
            },
        }
    }
    encoding_of(fields).ok_or(Malformed::Unexpected(at, "an encoding of the specification with all its parameters"))
}

fn encoding_of(fields: Fields<'_>) -> Option<Encoding<'_>> {
    Some(match fields.name {
        b"ByteArray" => Encoding::ByteArray(Kind::from_number(fields.whole("type")?)?),
        b"FixedPoint" => {
            Encoding::FixedPoint { factor: fields.number("factor").filter(|f| f.is_normal() && *f > 0.0)? }
        }
        b"IntervalQuantization" => Encoding::IntervalQuantization {
            min: fields.number("min").filter(|min| min.is_finite())?,
            max: fields.number("max").filter(|max| max.is_finite())?,
            steps: fields.whole("numSteps").filter(|&steps| steps > 0)?,
        },
        b"RunLength" => Encoding::RunLength { kind: fields.source(), size: fields.size()? },
        b"Delta" => Encoding::Delta { kind: fields.source(), origin: fields.whole("origin")? },
        b"IntegerPacking" => Encoding::IntegerPacking {
            byte_count: fields.whole("byteCount")?,
            size: fields.size()?,
            unsigned: fields.number("isUnsigned").is_some_and(|value| value != 0.0),
        },
        b"StringArray" => Encoding::StringArray(Box::new(StringArray {
            text: fields.text?,
            offsets: Data { bytes: fields.offsets?, encodings: fields.offset_encodings },
            index_encodings: fields.data_encodings,
        })),
        _ => return None,
    })
}

/// Decoded values.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Values {
    /// Whole numbers; `unsigned` says that they are to be taken as u32.
    Integers { values: Vec<i32>, unsigned: bool },
    /// Whole numbers to be divided by a factor.
    Fixed { values: Vec<i32>, factor: f64 },
    /// Whole numbers that count steps of `step` from `min`.
    Interval { values: Vec<i32>, min: f64, step: f64 },
    /// Single-precision numbers.
    Singles(Vec<f32>),
    /// Double-precision numbers.
    Doubles(Vec<f64>),
}

impl Values {
    pub(super) fn len(&self) -> usize {
        match self {
            Values::Integers { values, .. } | Values::Fixed { values, .. } | Values::Interval { values, .. } => {
                values.len()
            }
            Values::Singles(values) => values.len(),
            Values::Doubles(values) => values.len(),
        }
    }

    /// The integers; an error if they are something else.
    pub(super) fn integers(self) -> Result<Vec<i32>, Problem> {
        match self {
            Values::Integers { values, .. } => Ok(values),
            _ => Err(Problem::wrong("whole numbers are needed, found others")),
        }
    }
}

/// Why a column cannot be decoded.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Problem {
    /// The data contradicts itself.
    Wrong(String),
    /// Decoding would take more memory than the size of the file warrants.
    TooLarge,
}

impl Problem {
    pub(super) fn wrong(message: impl Into<String>) -> Problem {
        Problem::Wrong(message.into())
    }
}

/// The bytes that decoded columns may still take.
#[derive(Debug)]
pub(super) struct Budget {
    left: AtomicU64,
    stop: Stop,
}

impl Budget {
    pub(super) fn new(bytes: u64) -> Budget {
        Budget { left: AtomicU64::new(bytes), stop: Stop::never() }
    }

    /// The same, with nothing left once reading is given up.
    pub(super) fn until(self, stop: &Stop) -> Budget {
        Budget { stop: stop.clone(), ..self }
    }

    /// Another one of as many bytes as are left here.
    pub(super) fn again(&self) -> Budget {
        Budget::new(self.left.load(Ordering::Relaxed)).until(&self.stop)
    }

    /// Takes room for so many values; everything is paid before it is allocated.
    pub(super) fn spend(&self, count: usize, size: usize) -> Result<(), Problem> {
        let bytes = (count as u64).saturating_mul(size as u64);
        if self.stop.is_set() {
            return Err(Problem::TooLarge);
        }
        let paid = self.left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(bytes));
        paid.map(drop).map_err(|_| Problem::TooLarge)
    }
}

/// Between two steps.
enum State<'a> {
    Raw(&'a [u8], Kind),
    Done(Values),
}

/// Undoes the encodings of numbers.
pub(super) fn decode(bytes: &[u8], encodings: &[Encoding<'_>], budget: &Budget) -> Result<Values, Problem> {
    // Bytes without a ByteArray are bytes.
    let mut state = State::Raw(bytes, Kind::Uint8);
    for (step, encoding) in encodings.iter().rev().enumerate() {
        state = match encoding {
            Encoding::ByteArray(kind) if step == 0 => {
                if !bytes.len().is_multiple_of(kind.size()) {
                    let (length, size) = (bytes.len(), kind.size());
                    return Err(Problem::wrong(format!("{length} bytes are no whole number of {size}-byte values")));
                }
                State::Raw(bytes, *kind)
            }
            Encoding::IntegerPacking { byte_count, size, unsigned } => {
                State::Done(unpack(state, *byte_count, *size, *unsigned, budget)?)
            }
            Encoding::RunLength { kind, size } => {
                let runs = integers(state, budget)?;
                State::Done(narrowed(expand_runs(&runs, *size, budget)?, *kind))
            }
            Encoding::Delta { kind, origin } => {
                let mut values = integers(state, budget)?;
                // Sums wrap as those of the encoder's 32-bit arrays do.
                let mut sum = *origin as i32;
                for value in &mut values {
                    sum = sum.wrapping_add(*value);
                    *value = sum;
                }
                State::Done(narrowed(values, *kind))
            }
            Encoding::FixedPoint { factor } => {
                State::Done(Values::Fixed { values: integers(state, budget)?, factor: *factor })
            }
            Encoding::IntervalQuantization { min, max, steps } => {
                let step = (max - min) / (steps - 1).max(1) as f64;
                State::Done(Values::Interval { values: integers(state, budget)?, min: *min, step })
            }
            Encoding::ByteArray(_) => return Err(Problem::wrong("ByteArray stands before another encoding")),
            Encoding::StringArray(_) => return Err(Problem::wrong("StringArray stands behind another encoding")),
        };
    }
    match state {
        State::Raw(bytes, kind) => values_of(bytes, kind, budget),
        State::Done(values) => Ok(values),
    }
}

fn integers(state: State<'_>, budget: &Budget) -> Result<Vec<i32>, Problem> {
    match state {
        State::Raw(bytes, kind) => values_of(bytes, kind, budget)?.integers(),
        State::Done(values) => values.integers(),
    }
}

/// Values of so many bytes each.
fn each<const N: usize, T>(bytes: &[u8], value: impl Fn([u8; N]) -> T) -> Vec<T> {
    let (chunks, _) = bytes.as_chunks::<N>();
    chunks.iter().map(|&chunk| value(chunk)).collect()
}

fn values_of(bytes: &[u8], kind: Kind, budget: &Budget) -> Result<Values, Problem> {
    budget.spend(bytes.len() / kind.size(), kind.size().max(4))?;
    let integers = |values| Ok(Values::Integers { values, unsigned: kind == Kind::Uint32 });
    match kind {
        Kind::Int8 => integers(each(bytes, |b: [u8; 1]| i32::from(b[0] as i8))),
        Kind::Uint8 => integers(each(bytes, |b: [u8; 1]| i32::from(b[0]))),
        Kind::Int16 => integers(each(bytes, |b| i32::from(i16::from_le_bytes(b)))),
        Kind::Uint16 => integers(each(bytes, |b| i32::from(u16::from_le_bytes(b)))),
        Kind::Int32 | Kind::Uint32 => integers(each(bytes, i32::from_le_bytes)),
        Kind::Float32 => Ok(Values::Singles(each(bytes, f32::from_le_bytes))),
        Kind::Float64 => Ok(Values::Doubles(each(bytes, f64::from_le_bytes))),
    }
}

/// The values as the source's type holds them: an encoder that works on bytes lets its sums wrap at a byte.
fn narrowed(mut values: Vec<i32>, kind: Kind) -> Values {
    match kind {
        Kind::Int8 => values.iter_mut().for_each(|value| *value = i32::from(*value as i8)),
        Kind::Int16 => values.iter_mut().for_each(|value| *value = i32::from(*value as i16)),
        Kind::Uint8 => values.iter_mut().for_each(|value| *value = i32::from(*value as u8)),
        Kind::Uint16 => values.iter_mut().for_each(|value| *value = i32::from(*value as u16)),
        Kind::Int32 | Kind::Uint32 | Kind::Float32 | Kind::Float64 => {}
    }
    Values::Integers { values, unsigned: kind == Kind::Uint32 }
}

fn expand_runs(runs: &[i32], size: usize, budget: &Budget) -> Result<Vec<i32>, Problem> {
    let (pairs, rest) = runs.as_chunks::<2>();
    let mut total = 0usize;
    for &[_, count] in pairs {
        let count = usize::try_from(count).map_err(|_| Problem::wrong(format!("a run of {count} values")))?;
        total = total.saturating_add(count);
    }
    if total != size || !rest.is_empty() {
        return Err(Problem::wrong(format!("runs of {total} values, where {size} are stated")));
    }
    budget.spend(size, 4)?;
    let mut values = Vec::with_capacity(size);
    for &[value, count] in pairs {
        values.resize(values.len() + usize::try_from(count).unwrap_or(0), value);
    }
    Ok(values)
}

fn unpack(state: State<'_>, byte_count: i64, size: usize, unsigned: bool, budget: &Budget) -> Result<Values, Problem> {
    let (low, high) = match (byte_count, unsigned) {
        (1, true) => (i32::MIN, 0xff),
        (1, false) => (-0x80, 0x7f),
        (2, true) => (i32::MIN, 0xffff),
        (2, false) => (-0x8000, 0x7fff),
        _ => return Err(Problem::wrong(format!("IntegerPacking to {byte_count} bytes, where it can be 1 or 2"))),
    };
    let packed = match &state {
        State::Raw(bytes, kind) => bytes.len() / kind.size(),
        State::Done(values) => values.len(),
    };
    // A value takes at least one packed one.
    if size > packed {
        return Err(Problem::wrong(format!("{packed} packed values for {size}")));
    }
    budget.spend(size, 4)?;
    let mut unpacker = Unpacker { low, high, sum: 0, open: false, values: Vec::with_capacity(size) };
    match state {
        State::Raw(bytes, Kind::Int8) => unpacker.all(bytes.iter().map(|&b| i32::from(b as i8))),
        State::Raw(bytes, Kind::Uint8) => unpacker.all(bytes.iter().map(|&b| i32::from(b))),
        State::Raw(bytes, Kind::Int16) => {
            unpacker.all(bytes.as_chunks().0.iter().map(|&b| i32::from(i16::from_le_bytes(b))));
        }
        State::Raw(bytes, Kind::Uint16) => {
            unpacker.all(bytes.as_chunks().0.iter().map(|&b| i32::from(u16::from_le_bytes(b))));
        }
        state => unpacker.all(integers(state, budget)?.into_iter()),
    }
    let found = unpacker.values.len();
    if found != size || unpacker.open {
        return Err(Problem::wrong(format!("IntegerPacking of {found} values, where {size} are stated")));
    }
    Ok(Values::Integers { values: unpacker.values, unsigned: false })
}

/// Adds up packed values: one at either limit says that more is to come.
struct Unpacker {
    low: i32,
    high: i32,
    sum: i32,
    open: bool,
    values: Vec<i32>,
}

impl Unpacker {
    #[inline]
    fn all(&mut self, packed: impl Iterator<Item = i32>) {
        for part in packed {
            self.sum = self.sum.wrapping_add(part);
            self.open = part == self.high || part == self.low;
            if !self.open {
                self.values.push(self.sum);
                self.sum = 0;
            }
        }
    }
}
