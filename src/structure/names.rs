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

    /// Bytes set aside, about.
    pub(super) fn memory(&self) -> usize {
        let texts: usize = self.texts.iter().map(|text| text.len() + size_of::<Box<str>>()).sum();
        let long: usize = self.long.keys().map(|text| text.len()).sum();
        texts + long + self.short.capacity() * 17 + self.long.capacity() * 25
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

/// The names met last, in front of [`Names`]: looking one up here costs a multiplication.
#[derive(Debug, Clone, Default)]
pub(super) struct RecentNames {
    /// Key and id, by the key's hash; empty until the first name comes.
    slots: Vec<(u64, NameId)>,
}

impl RecentNames {
    const BITS: u32 = 7;

    /// The id of a name, which is added to `names` if need be. What is no UTF-8 in it becomes U+FFFD.
    #[inline]
    pub(super) fn intern(&mut self, names: &mut Names, text: &[u8]) -> NameId {
        // Up to seven bytes and their number, so that none is 0, which an empty slot has.
        let length = text.len();
        if !(1..=7).contains(&length) {
            return names.intern(&String::from_utf8_lossy(text));
        }
        let key = text.iter().rev().fold(length as u64, |key, &byte| (key << 8) | u64::from(byte));
        let slot = (key.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> (64 - Self::BITS)) as usize;
        if let Some(&(found, id)) = self.slots.get(slot)
            && found == key
        {
            return id;
        }
        self.slots.resize(1 << Self::BITS, (0, NameId::default()));
        let id = names.intern(&String::from_utf8_lossy(text));
        self.slots[slot] = (key, id);
        id
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
    fn recent_names_are_the_names() {
        let (mut names, mut recent) = (Names::default(), RecentNames::default());
        let texts: Vec<String> = (0..500).map(|n| format!("{}", n * 37 % 251)).collect();
        for text in texts.iter().map(String::as_str).chain(["", "\0", "\0\0", "longer than seven", "é"]) {
            let id = recent.intern(&mut names, text.as_bytes());
            assert_eq!(recent.intern(&mut names, text.as_bytes()), id);
            assert_eq!(names.get(id), text);
        }
        assert_eq!(names.texts().count(), 251 + 5);
        let id = recent.intern(&mut names, b"\xff");
        assert_eq!(names.get(id), "\u{fffd}");
    }

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
