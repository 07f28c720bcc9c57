//! Writes BinaryCIF for the tests: every encoding of the specification, in any order.

/// MessagePack, as short as it can be said.
#[derive(Default)]
pub(super) struct Packer(pub(super) Vec<u8>);

impl Packer {
    fn head(&mut self, count: usize, short: (u8, usize), medium: u8, long: u8) -> &mut Self {
        if count <= short.1 {
            self.0.push(short.0 | count as u8);
        } else if count <= 0xffff {
            self.0.push(medium);
            self.0.extend((count as u16).to_be_bytes());
        } else {
            self.0.push(long);
            self.0.extend((count as u32).to_be_bytes());
        }
        self
    }

    pub(super) fn map(&mut self, count: usize) -> &mut Self {
        self.head(count, (0x80, 15), 0xde, 0xdf)
    }

    pub(super) fn array(&mut self, count: usize) -> &mut Self {
        self.head(count, (0x90, 15), 0xdc, 0xdd)
    }

    pub(super) fn text(&mut self, text: &str) -> &mut Self {
        self.head(text.len(), (0xa0, 31), 0xda, 0xdb);
        self.0.extend(text.as_bytes());
        self
    }

    pub(super) fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        self.0.push(0xc6);
        self.0.extend((bytes.len() as u32).to_be_bytes());
        self.0.extend(bytes);
        self
    }

    pub(super) fn number(&mut self, value: f64) -> &mut Self {
        if value.fract() == 0.0 && value.abs() < 1e15 {
            self.0.push(0xd3);
            self.0.extend((value as i64).to_be_bytes());
        } else {
            self.0.push(0xcb);
            self.0.extend(value.to_be_bytes());
        }
        self
    }

    pub(super) fn bool(&mut self, value: bool) -> &mut Self {
        self.0.push(0xc2 | u8::from(value));
        self
    }

    pub(super) fn nil(&mut self) -> &mut Self {
        self.0.push(0xc0);
        self
    }

    pub(super) fn append(&mut self, other: &Packer) -> &mut Self {
        self.0.extend(&other.0);
        self
    }
}

/// One encoding to apply.
#[derive(Debug, Clone, Copy)]
pub(super) enum Step {
    ByteArray(i64),
    FixedPoint(f64),
    Interval { min: f64, max: f64, steps: i64 },
    RunLength,
    Delta,
    Packing { bytes: i64, unsigned: bool },
}

/// Values between steps.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Source {
    Integers(Vec<i32>),
    Floats(Vec<f64>),
    Raw(Vec<u8>),
}

impl Source {
    fn integers(&self) -> &[i32] {
        match self {
            Source::Integers(values) => values,
            _ => panic!("the step needs integers"),
        }
    }
}

fn pack(values: &[i32], bytes: i64, unsigned: bool) -> Vec<i32> {
    let (low, high) = match (bytes, unsigned) {
        (1, true) => (i64::MIN, 0xff),
        (1, false) => (-0x80, 0x7f),
        (2, true) => (i64::MIN, 0xffff),
        _ => (-0x8000, 0x7fff),
    };
    let mut packed = Vec::new();
    for &value in values {
        let mut rest = i64::from(value);
        while rest >= high {
            packed.push(high as i32);
            rest -= high;
        }
        while rest <= low {
            packed.push(low as i32);
            rest -= low;
        }
        packed.push(rest as i32);
    }
    packed
}

fn to_bytes(source: &Source, kind: i64) -> Vec<u8> {
    match source {
        Source::Integers(values) => match kind {
            1 | 4 => values.iter().map(|&value| value as u8).collect(),
            2 | 5 => values.iter().flat_map(|&value| (value as u16).to_le_bytes()).collect(),
            _ => values.iter().flat_map(|&value| value.to_le_bytes()).collect(),
        },
        Source::Floats(values) if kind == 32 => values.iter().flat_map(|&v| (v as f32).to_le_bytes()).collect(),
        Source::Floats(values) => values.iter().flat_map(|&value| value.to_le_bytes()).collect(),
        Source::Raw(_) => panic!("bytes twice"),
    }
}

/// Applies a step and says what it was.
fn apply(source: &Source, step: Step) -> (Source, Packer) {
    let mut said = Packer::default();
    let result = match step {
        Step::ByteArray(kind) => {
            said.map(2).text("kind").text("ByteArray").text("type").number(kind as f64);
            Source::Raw(to_bytes(source, kind))
        }
        Step::FixedPoint(factor) => {
            said.map(3).text("kind").text("FixedPoint").text("factor").number(factor).text("srcType").number(33.0);
            let Source::Floats(values) = source else { panic!("FixedPoint needs floats") };
            Source::Integers(values.iter().map(|value| (value * factor).round() as i32).collect())
        }
        Step::Interval { min, max, steps } => {
            said.map(5).text("kind").text("IntervalQuantization").text("min").number(min).text("max").number(max);
            said.text("numSteps").number(steps as f64).text("srcType").number(32.0);
            let Source::Floats(values) = source else { panic!("IntervalQuantization needs floats") };
            let delta = (max - min) / (steps - 1) as f64;
            Source::Integers(values.iter().map(|v| ((v.clamp(min, max) - min) / delta).round() as i32).collect())
        }
        Step::RunLength => {
            let values = source.integers();
            said.map(3).text("kind").text("RunLength").text("srcType").number(3.0);
            said.text("srcSize").number(values.len() as f64);
            let runs = values.chunk_by(|a, b| a == b).flat_map(|run| [run[0], run.len() as i32]);
            Source::Integers(runs.collect())
        }
        Step::Delta => {
            let values = source.integers();
            let origin = values.first().copied().unwrap_or(0);
            said.map(3).text("kind").text("Delta").text("srcType").number(3.0).text("origin").number(f64::from(origin));
            let before = std::iter::once(origin).chain(values.iter().copied());
            Source::Integers(values.iter().zip(before).map(|(value, before)| value.wrapping_sub(before)).collect())
        }
        Step::Packing { bytes, unsigned } => {
            let values = source.integers();
            said.map(4).text("kind").text("IntegerPacking").text("byteCount").number(bytes as f64);
            said.text("srcSize").number(values.len() as f64).text("isUnsigned").bool(unsigned);
            Source::Integers(pack(values, bytes, unsigned))
        }
    };
    (result, said)
}

/// The bytes and the list of what was done to them.
fn encode(source: &Source, steps: &[Step]) -> (Vec<u8>, Packer) {
    let mut list = Packer::default();
    list.array(steps.len());
    let mut source = source.clone();
    for &step in steps {
        let (next, said) = apply(&source, step);
        source = next;
        list.append(&said);
    }
    let Source::Raw(bytes) = source else { panic!("the last step gives bytes") };
    (bytes, list)
}

/// `{data, encoding}` of numbers.
pub(super) fn data(source: &Source, steps: &[Step]) -> Packer {
    let (bytes, list) = encode(source, steps);
    let mut packer = Packer::default();
    packer.map(2).text("data").bytes(&bytes).text("encoding").append(&list);
    packer
}

/// What offsets of texts count.
#[derive(Debug, Clone, Copy)]
pub(super) enum Unit {
    Bytes,
    Characters,
    Utf16,
}

/// `{data, encoding}` of texts; `None` is an index of −1.
pub(super) fn texts(values: &[Option<&str>], index_steps: &[Step], offset_steps: &[Step], unit: Unit) -> Packer {
    let mut unique: Vec<&str> = Vec::new();
    let mut indices = Vec::new();
    for value in values {
        indices.push(value.map_or(-1, |value| {
            let at = unique.iter().position(|other| *other == value).unwrap_or_else(|| {
                unique.push(value);
                unique.len() - 1
            });
            at as i32
        }));
    }
    let length = |text: &str| match unit {
        Unit::Bytes => text.len(),
        Unit::Characters => text.chars().count(),
        Unit::Utf16 => text.encode_utf16().count(),
    };
    let mut offsets = vec![0];
    for text in &unique {
        offsets.push(offsets[offsets.len() - 1] + length(text) as i32);
    }
    let (bytes, index_list) = encode(&Source::Integers(indices), index_steps);
    let (offsets, offset_list) = encode(&Source::Integers(offsets), offset_steps);
    let mut packer = Packer::default();
    packer.map(2).text("data").bytes(&bytes).text("encoding").array(1).map(5).text("kind").text("StringArray");
    packer.text("dataEncoding").append(&index_list).text("stringData").text(&unique.concat());
    packer.text("offsetEncoding").append(&offset_list).text("offsets").bytes(&offsets);
    packer
}

/// A column; `mask` as a column of numbers.
pub(super) fn column(name: &str, data: &Packer, mask: Option<&Packer>) -> Packer {
    let mut packer = Packer::default();
    packer.map(3).text("name").text(name).text("data").append(data).text("mask");
    match mask {
        Some(mask) => packer.append(mask),
        None => packer.nil(),
    };
    packer
}

/// A category.
pub(super) fn category(name: &str, rows: usize, columns: &[Packer]) -> Packer {
    let mut packer = Packer::default();
    packer.map(3).text("name").text(name).text("rowCount").number(rows as f64).text("columns").array(columns.len());
    columns.iter().for_each(|column| {
        packer.append(column);
    });
    packer
}

/// A file of one block.
pub(super) fn file(categories: &[Packer]) -> Vec<u8> {
    let mut packer = Packer::default();
    packer.map(3).text("encoder").text("test").text("version").text("0.3.0").text("dataBlocks").array(1);
    packer.map(2).text("header").text("TEST").text("categories").array(categories.len());
    categories.iter().for_each(|category| {
        packer.append(category);
    });
    packer.0
}
