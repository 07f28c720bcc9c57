//! Interned names: atom, residue and chain names are few and repeat often.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// An interned name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct NameId(u32);

impl NameId {
    /// Its place in the table.
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }
}

/// The texts behind [`NameId`]s. Id 0 is the empty name.
#[derive(Debug, Clone, Default)]
pub struct Names {
    texts: Vec<Box<str>>,
    /// Names of up to eight bytes, by those bytes.
    short: HashMap<u64, u32, BuildHasherDefault<ShortHasher>>,
    long: HashMap<Box<str>, u32>,
}

impl PartialEq for Names {
    fn eq(&self, other: &Names) -> bool {
        self.texts == other.texts
    }
}

impl Names {
    /// The text of a name; empty for an id that is not of this table.
    #[must_use]
    pub fn get(&self, id: NameId) -> &str {
        self.texts.get(id.0 as usize).map_or("", |text| text)
    }

    /// All texts, by their ids.
    pub(crate) fn texts(&self) -> impl Iterator<Item = &str> {
        self.texts.iter().map(|text| &**text)
    }

    /// The id of a name, if it has one.
    #[must_use]
    pub fn find(&self, text: &str) -> Option<NameId> {
        if text.is_empty() {
            return Some(NameId(0));
        }
        match short_key(text) {
            Some(key) => self.short.get(&key).copied().map(NameId),
            None => self.long.get(text).copied().map(NameId),
        }
    }

    /// The id of a name, which is added if need be.
    pub fn intern(&mut self, text: &str) -> NameId {
        if let Some(id) = self.find(text) {
            if self.texts.is_empty() {
                self.texts.push("".into());
            }
            return id;
        }
        if self.texts.is_empty() {
            self.texts.push("".into());
        }
        let id = u32::try_from(self.texts.len()).unwrap_or(u32::MAX);
        self.texts.push(text.into());
        match short_key(text) {
            Some(key) => {
                self.short.insert(key, id);
            }
            None => {
                self.long.insert(text.into(), id);
            }
        }
        NameId(id)
    }
}

/// The bytes of a name as a number, if they fit and none is zero (so that different names differ).
#[inline]
fn short_key(text: &str) -> Option<u64> {
    let bytes = text.as_bytes();
    if bytes.len() > 8 {
        return None;
    }
    let mut key = 0;
    for &byte in bytes {
        if byte == 0 {
            return None;
        }
        key = key << 8 | u64::from(byte);
    }
    Some(key)
}

/// One multiplication: the keys are short ASCII texts, and a table from a hostile file has at most as many
/// entries as the file has atoms.
#[derive(Default, Clone)]
struct ShortHasher(u64);

impl Hasher for ShortHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.write_u64(u64::from(byte));
        }
    }

    fn write_u64(&mut self, key: u64) {
        // 2^64 / golden ratio (Fibonacci hashing, Knuth, The Art of Computer Programming 3, 6.4).
        let mixed = (self.0 ^ key).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        self.0 = mixed ^ (mixed >> 32);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_interned_once_and_read_back() {
        let mut names = Names::default();
        let texts = ["", "CA", "CB", "a name longer than eight bytes", "\0", "12345678", "CA"];
        let ids: Vec<_> = texts.iter().map(|text| names.intern(text)).collect();
        for (text, &id) in texts.iter().zip(&ids) {
            assert_eq!(names.get(id), *text);
            assert_eq!(names.find(text), Some(id));
        }
        assert_eq!(ids[1], ids[6]);
        assert_eq!(names.find("CG"), None);
    }
}
