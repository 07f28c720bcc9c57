//! MessagePack (<https://github.com/msgpack/msgpack/blob/master/spec.md>), token by token.
//!
//! Nothing is allocated: texts and bytes are parts of the input, and lengths of arrays and maps are claims that cost
//! their reader nothing. Skipping keeps a count instead of a stack, so that no depth is too deep for it.

/// One value, or the head of an array or map, whose items follow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Token<'a> {
    Nil,
    Bool(bool),
    Integer(i64),
    Float(f64),
    Text(&'a [u8]),
    Bytes(&'a [u8]),
    /// Number of items.
    Array(u32),
    /// Number of pairs.
    Map(u32),
    /// An application's own type.
    Extension,
}

/// What is wrong with the bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Malformed {
    /// They end inside a value.
    End,
    /// Byte 0xc1, which is never used, at this place.
    Never(usize),
    /// Something other than what has to be at this place.
    Unexpected(usize, &'static str),
}

impl std::fmt::Display for Malformed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Malformed::End => f.write_str("the file ends too early"),
            Malformed::Never(at) => write!(f, "byte {at} is no MessagePack"),
            Malformed::Unexpected(at, expected) => write!(f, "expected {expected} at byte {at}"),
        }
    }
}

/// A place in the bytes.
#[derive(Debug, Clone)]
pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Cursor<'a> {
        Cursor { bytes, at: 0 }
    }

    /// How many bytes were read.
    pub(super) fn position(&self) -> usize {
        self.at
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], Malformed> {
        let rest = &self.bytes[self.at..];
        let taken = rest.get(..count).ok_or(Malformed::End)?;
        self.at += count;
        Ok(taken)
    }

    /// A big-endian unsigned number of 1, 2, 4 or 8 bytes.
    fn unsigned(&mut self, size: usize) -> Result<u64, Malformed> {
        Ok(self.take(size)?.iter().fold(0, |value, &byte| (value << 8) | u64::from(byte)))
    }

    fn length(&mut self, size: usize) -> Result<usize, Malformed> {
        Ok(usize::try_from(self.unsigned(size)?).unwrap_or(usize::MAX))
    }

    fn count(&mut self, size: usize) -> Result<u32, Malformed> {
        Ok(u32::try_from(self.unsigned(size)?).unwrap_or(u32::MAX))
    }

    /// The next token.
    pub(super) fn token(&mut self) -> Result<Token<'a>, Malformed> {
        let at = self.at;
        let head = self.take(1)?[0];
        Ok(match head {
            0x00..=0x7f => Token::Integer(i64::from(head)),
            0x80..=0x8f => Token::Map(u32::from(head & 0x0f)),
            0x90..=0x9f => Token::Array(u32::from(head & 0x0f)),
            0xa0..=0xbf => Token::Text(self.take(usize::from(head & 0x1f))?),
            0xc0 => Token::Nil,
            0xc1 => return Err(Malformed::Never(at)),
            0xc2 | 0xc3 => Token::Bool(head == 0xc3),
            0xc4..=0xc6 => {
                let length = self.length(1 << (head - 0xc4))?;
                Token::Bytes(self.take(length)?)
            }
            0xc7..=0xc9 => {
                let length = self.length(1 << (head - 0xc7))?;
                self.take(1)?;
                self.take(length)?;
                Token::Extension
            }
            0xca => Token::Float(f64::from(f32::from_bits(self.unsigned(4)? as u32))),
            0xcb => Token::Float(f64::from_bits(self.unsigned(8)?)),
            0xcc..=0xcf => match self.unsigned(1 << (head - 0xcc))? {
                // No number of BinaryCIF is so large.
                large if large > i64::MAX as u64 => Token::Float(large as f64),
                value => Token::Integer(value as i64),
            },
            0xd0 => Token::Integer(i64::from(self.unsigned(1)? as i8)),
            0xd1 => Token::Integer(i64::from(self.unsigned(2)? as i16)),
            0xd2 => Token::Integer(i64::from(self.unsigned(4)? as i32)),
            0xd3 => Token::Integer(self.unsigned(8)? as i64),
            0xd4..=0xd8 => {
                self.take(1 + (1 << (head - 0xd4)))?;
                Token::Extension
            }
            0xd9..=0xdb => {
                let length = self.length(1 << (head - 0xd9))?;
                Token::Text(self.take(length)?)
            }
            0xdc => Token::Array(self.count(2)?),
            0xdd => Token::Array(self.count(4)?),
            0xde => Token::Map(self.count(2)?),
            0xdf => Token::Map(self.count(4)?),
            0xe0..=0xff => Token::Integer(i64::from(head as i8)),
        })
    }

    /// Passes over one value with all that is in it.
    pub(super) fn skip(&mut self) -> Result<(), Malformed> {
        let mut pending = 1u64;
        while pending > 0 {
            pending -= 1;
            // Each token takes a byte, so that the sum of the claims stays far below 2⁶⁴ before the bytes end.
            match self.token()? {
                Token::Array(count) => pending = pending.saturating_add(u64::from(count)),
                Token::Map(count) => pending = pending.saturating_add(2 * u64::from(count)),
                _ => {}
            }
        }
        Ok(())
    }

    /// The number of pairs of the map that has to come here.
    pub(super) fn map(&mut self, what: &'static str) -> Result<u32, Malformed> {
        let at = self.at;
        match self.token()? {
            Token::Map(count) => Ok(count),
            _ => Err(Malformed::Unexpected(at, what)),
        }
    }

    /// The number of items of the array that has to come here; `nil` is an array of none.
    pub(super) fn array(&mut self, what: &'static str) -> Result<u32, Malformed> {
        let at = self.at;
        match self.token()? {
            Token::Array(count) => Ok(count),
            Token::Nil => Ok(0),
            _ => Err(Malformed::Unexpected(at, what)),
        }
    }

    /// The number, 0 or more, that has to come here.
    pub(super) fn number(&mut self, what: &'static str) -> Result<usize, Malformed> {
        let at = self.at;
        let number = match self.token()? {
            Token::Integer(value) => usize::try_from(value).ok(),
            // JavaScript has no other numbers.
            Token::Float(value) => (value >= 0.0 && value.fract() == 0.0 && value < 1e15).then_some(value as usize),
            _ => None,
        };
        number.ok_or(Malformed::Unexpected(at, what))
    }

    /// The text that has to come here.
    pub(super) fn text(&mut self, what: &'static str) -> Result<&'a [u8], Malformed> {
        let at = self.at;
        match self.token()? {
            Token::Text(text) => Ok(text),
            _ => Err(Malformed::Unexpected(at, what)),
        }
    }

    /// The bytes that have to come here.
    pub(super) fn bytes(&mut self, what: &'static str) -> Result<&'a [u8], Malformed> {
        let at = self.at;
        match self.token()? {
            // Encoders of old versions of MessagePack know text alone.
            Token::Bytes(bytes) | Token::Text(bytes) => Ok(bytes),
            _ => Err(Malformed::Unexpected(at, what)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn one(bytes: &[u8]) -> Result<Token<'_>, Malformed> {
        Cursor::new(bytes).token()
    }

    #[test]
    fn every_head_of_the_specification_is_known() {
        for (bytes, want) in [
            (&[0x05][..], Token::Integer(5)),
            (&[0xff], Token::Integer(-1)),
            (&[0x82], Token::Map(2)),
            (&[0x93], Token::Array(3)),
            (&[0xa2, b'h', b'i'], Token::Text(b"hi")),
            (&[0xc0], Token::Nil),
            (&[0xc2], Token::Bool(false)),
            (&[0xc3], Token::Bool(true)),
            (&[0xc4, 1, 7], Token::Bytes(&[7])),
            (&[0xc5, 0, 1, 7], Token::Bytes(&[7])),
            (&[0xc6, 0, 0, 0, 1, 7], Token::Bytes(&[7])),
            (&[0xc7, 1, 0, 0], Token::Extension),
            (&[0xc8, 0, 0, 0], Token::Extension),
            (&[0xc9, 0, 0, 0, 0, 0], Token::Extension),
            (&[0xca, 0x3f, 0x80, 0, 0], Token::Float(1.0)),
            (&[0xcb, 0xbf, 0xf0, 0, 0, 0, 0, 0, 0], Token::Float(-1.0)),
            (&[0xcc, 200], Token::Integer(200)),
            (&[0xcd, 1, 0], Token::Integer(256)),
            (&[0xce, 0xff, 0, 0, 0], Token::Integer(0xff00_0000)),
            (&[0xcf, 0, 0, 0, 0, 0, 0, 0, 9], Token::Integer(9)),
            (&[0xcf, 0x80, 0, 0, 0, 0, 0, 0, 0], Token::Float(9_223_372_036_854_775_808.0)),
            (&[0xd0, 0x80], Token::Integer(-128)),
            (&[0xd1, 0xff, 0xfe], Token::Integer(-2)),
            (&[0xd2, 0xff, 0xff, 0xff, 0xfd], Token::Integer(-3)),
            (&[0xd3, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xfc], Token::Integer(-4)),
            (&[0xd4, 0, 0], Token::Extension),
            (&[0xd6, 0, 0, 0, 0, 0], Token::Extension),
            (&[0xd9, 1, b'x'], Token::Text(b"x")),
            (&[0xda, 0, 1, b'x'], Token::Text(b"x")),
            (&[0xdb, 0, 0, 0, 1, b'x'], Token::Text(b"x")),
            (&[0xdc, 1, 0], Token::Array(256)),
            (&[0xdd, 0xff, 0xff, 0xff, 0xff], Token::Array(u32::MAX)),
            (&[0xde, 1, 0], Token::Map(256)),
            (&[0xdf, 0, 0, 0, 1], Token::Map(1)),
        ] {
            assert_eq!(one(bytes), Ok(want), "{bytes:x?}");
            let fits = |token| !matches!(token, Token::Array(_) | Token::Map(_));
            if fits(want) {
                assert_eq!(one(&bytes[..bytes.len() - 1]), Err(Malformed::End), "{bytes:x?} cut");
            }
        }
        assert_eq!(one(&[0xc1]), Err(Malformed::Never(0)));
    }

    #[test]
    fn skipping_goes_over_whatever_is_nested() {
        let mut bytes = vec![0x82, 0xa1, b'a', 0x92, 0xc0, 0x81, 0x01, 0x90, 0xa1, b'b', 0xc4, 2, 0, 0];
        bytes.push(0x07);
        let mut cursor = Cursor::new(&bytes);
        cursor.skip().unwrap();
        assert_eq!(cursor.token(), Ok(Token::Integer(7)));
        let deep = vec![0x91; 1 << 20];
        assert_eq!(Cursor::new(&deep).skip(), Err(Malformed::End));
        let many = [0xdd, 0xff, 0xff, 0xff, 0xff].repeat(1000);
        assert_eq!(Cursor::new(&many).skip(), Err(Malformed::End));
    }

    proptest! {
        #[test]
        fn any_bytes_end(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let mut cursor = Cursor::new(&bytes);
            while cursor.skip().is_ok() {}
        }
    }
}
