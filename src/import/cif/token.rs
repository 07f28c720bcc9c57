//! CIF text as tokens: slices of the file, with line numbers.
//!
//! Specification: Hall, Allen and Brown, Acta Cryst. A 1991, 47, 655; version 1.1:
//! <https://www.iucr.org/resources/cif/spec/version1.1/cifsyntax>; version 2.0: Bernstein et al., J. Appl. Cryst. 2016,
//! 49, 277. Of version 2.0 the triple quotes are read where the file says that it is one.
//!
//! Accepted beyond them: control characters count as blanks; a quote that is not closed on its line is part of an
//! unquoted value.

use crate::import::text::LOOK_EVERY;
use crate::stop::Stop;
use memchr::{memchr, memchr_iter, memmem};

/// A value without its quotes; `None` for `.` and `?`.
pub(super) type Value<'a> = Option<&'a [u8]>;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Token<'a> {
    /// `data_NAME`.
    Data(&'a [u8]),
    /// `save_NAME`, or `save_` alone, which ends the frame.
    Save(&'a [u8]),
    Loop,
    /// `stop_` or `global_`, words of STAR that CIF does not use.
    Reserved,
    /// `_name`.
    Name(&'a [u8]),
    Value(Value<'a>),
    /// A text field that begins on this token's line and is not closed.
    Unclosed,
    End,
}

/// Where a reader of tokens stands; copies are bookmarks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tokens<'a> {
    pub(super) text: &'a [u8],
    pub(super) at: usize,
    /// 1-based line of `at`.
    pub(super) line: u64,
    /// The line on which the last token began.
    pub(super) token_line: u64,
    triple_quotes: bool,
    pub(super) stop: &'a Stop,
}

/// Blanks, line ends and control characters.
#[inline]
pub(super) fn is_blank(byte: u8) -> bool {
    byte <= b' '
}

/// A value that is not quoted.
#[inline]
pub(super) fn unquoted(word: &[u8]) -> Value<'_> {
    if matches!(word, b"." | b"?") { None } else { Some(word) }
}

impl<'a> Tokens<'a> {
    /// Those of a text, which ends when reading is given up.
    pub(super) fn new(text: &'a [u8], stop: &'a Stop) -> Tokens<'a> {
        Tokens { text, at: 0, line: 1, token_line: 1, triple_quotes: text.starts_with(b"#\\#CIF_2.0"), stop }
    }

    fn peek(&self, ahead: usize) -> Option<u8> {
        self.text.get(self.at + ahead).copied()
    }

    /// Past blanks and comments.
    pub(super) fn skip_blanks(&mut self) {
        while let Some(byte) = self.peek(0) {
            match byte {
                b'\n' => {
                    self.line += 1;
                    self.at += 1;
                }
                b'#' => self.at += memchr(b'\n', &self.text[self.at..]).unwrap_or(self.text.len() - self.at),
                _ if is_blank(byte) => self.at += 1,
                _ => return,
            }
        }
    }

    pub(super) fn next(&mut self) -> Token<'a> {
        self.skip_blanks();
        self.token_line = self.line;
        let Some(first) = self.peek(0) else { return Token::End };
        // It stays there: what comes is the end, however often it is asked for.
        if self.line.is_multiple_of(LOOK_EVERY) && self.stop.is_set() {
            return Token::End;
        }
        match first {
            b';' if self.at == 0 || self.text[self.at - 1] == b'\n' => return self.text_field(),
            b'\'' | b'"' => {
                if let Some(value) = self.quoted(first) {
                    return Token::Value(Some(value));
                }
            }
            _ => {}
        }
        let rest = &self.text[self.at..];
        let word = &rest[..rest.iter().position(|&byte| is_blank(byte)).unwrap_or(rest.len())];
        self.at += word.len();
        match first {
            b'_' => Token::Name(word),
            b'd' | b'D' | b'l' | b'L' | b's' | b'S' | b'g' | b'G' => keyword(word).unwrap_or(Token::Value(Some(word))),
            _ => Token::Value(unquoted(word)),
        }
    }

    /// From `;` at the beginning of a line to the next one there.
    fn text_field(&mut self) -> Token<'a> {
        let rest = &self.text[self.at + 1..];
        let Some(end) = memmem::find(rest, b"\n;") else {
            self.at = self.text.len();
            return Token::Unclosed;
        };
        self.at += end + 3;
        let field = &rest[..end];
        self.line += memchr_iter(b'\n', field).count() as u64 + 1;
        Token::Value(Some(field.strip_suffix(b"\r").unwrap_or(field)))
    }

    /// A quoted value on one line (triple quotes: on many); `None` if it is not closed.
    fn quoted(&mut self, quote: u8) -> Option<&'a [u8]> {
        if self.triple_quotes && self.peek(1) == Some(quote) && self.peek(2) == Some(quote) {
            let rest = &self.text[self.at + 3..];
            let end = memmem::find(rest, &[quote; 3])?;
            self.line += memchr_iter(b'\n', &rest[..end]).count() as u64;
            self.at += end + 6;
            return Some(&rest[..end]);
        }
        let rest = &self.text[self.at + 1..];
        let line = &rest[..memchr(b'\n', rest).unwrap_or(rest.len())];
        let end = closing_quote(line, quote)?;
        self.at += end + 2;
        Some(&line[..end])
    }

    /// Past blanks and, if there is nothing else on the line, its end.
    pub(super) fn skip_line_end(&mut self) {
        while let Some(byte) = self.peek(0).filter(|&byte| is_blank(byte)) {
            self.at += 1;
            if byte == b'\n' {
                self.line += 1;
                return;
            }
        }
    }

    /// To the end of the loop whose values begin here, which nobody wants.
    pub(super) fn skip_values(&mut self) {
        loop {
            // Words of the language and names all have an underscore; a line without one has only values.
            while self.at < self.text.len() && (self.at == 0 || self.text[self.at - 1] == b'\n') {
                let rest = &self.text[self.at..];
                let end = memchr(b'\n', rest).unwrap_or(rest.len());
                if rest[0] == b';' || memchr(b'_', &rest[..end]).is_some() || end == rest.len() {
                    break;
                }
                self.at += end + 1;
                self.line += 1;
            }
            let before = *self;
            match self.next() {
                Token::Value(_) => self.skip_line_end(),
                _ => {
                    *self = before;
                    return;
                }
            }
        }
    }
}

/// Where a quote followed by a blank (or nothing) is.
#[inline]
pub(super) fn closing_quote(line: &[u8], quote: u8) -> Option<usize> {
    memchr_iter(quote, line).find(|&at| line.get(at + 1).is_none_or(|&byte| is_blank(byte)))
}

fn keyword(word: &[u8]) -> Option<Token<'_>> {
    let is = |keyword: &[u8]| word.len() >= keyword.len() && word[..keyword.len()].eq_ignore_ascii_case(keyword);
    match () {
        () if is(b"data_") => Some(Token::Data(&word[5..])),
        () if is(b"save_") => Some(Token::Save(&word[5..])),
        () if word.len() == 5 && is(b"loop_") => Some(Token::Loop),
        () if (word.len() == 5 && is(b"stop_")) || (word.len() == 7 && is(b"global_")) => Some(Token::Reserved),
        () => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tokens(text: &str) -> Vec<String> {
        let stop = Stop::never();
        let mut tokens = Tokens::new(text.as_bytes(), &stop);
        let mut found = Vec::new();
        loop {
            let show = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
            let (kind, word) = match tokens.next() {
                Token::Data(name) => ("data ", show(name)),
                Token::Save(name) => ("save ", show(name)),
                Token::Loop => ("loop", String::new()),
                Token::Reserved => ("reserved", String::new()),
                Token::Name(name) => ("", show(name)),
                Token::Value(Some(value)) => ("=", show(value)),
                Token::Value(None) => ("null", String::new()),
                Token::Unclosed => ("unclosed", String::new()),
                Token::End => return found,
            };
            found.push(format!("{}:{kind}{word}", tokens.token_line));
        }
    }

    #[test]
    fn every_kind_of_token_is_told() {
        let text = "data_x # comment 'a\n_a \"it's O5' x\" _b \"#1\"\r\nloop_\n\t_c.d\n. ? '.' \"?\"\nSAVE_f save_ Global_ stop_";
        let want = [
            "1:data x",
            "2:_a",
            "2:=it's O5' x",
            "2:_b",
            "2:=#1",
            "3:loop",
            "4:_c.d",
            "5:null",
            "5:null",
            "5:=.",
            "5:=?",
            "6:save f",
            "6:save ",
            "6:reserved",
            "6:reserved",
        ];
        assert_eq!(tokens(text), want);
    }

    #[test]
    fn text_fields_go_over_lines_and_count_them() {
        assert_eq!(tokens("_a\n;one\n two;\n;\n_b 1 ;2"), ["1:_a", "2:=one\n two;", "5:_b", "5:=1", "5:=;2"]);
        assert_eq!(tokens("_a\r\n;one\r\n;\r\nx"), ["1:_a", "2:=one", "4:=x"]);
        assert_eq!(tokens("x\n;one\ntwo"), ["1:=x", "2:unclosed"]);
    }

    #[test]
    fn quotes_end_only_before_blanks() {
        assert_eq!(tokens("'a'b' \"O5'\" 'a"), ["1:=a'b", "1:=O5'", "1:='a"]);
        assert_eq!(tokens("O5'' C1'"), ["1:=O5''", "1:=C1'"]);
        let triple = "#\\#CIF_2.0\n'''a'\n''' b";
        assert_eq!(tokens(triple), ["2:=a'\n", "3:=b"]);
    }

    #[test]
    fn words_that_only_begin_like_the_languages_own_are_values() {
        assert_eq!(
            tokens("loop_a stop global d data s g l"),
            ["1:=loop_a", "1:=stop", "1:=global", "1:=d", "1:=data", "1:=s", "1:=g", "1:=l"]
        );
    }

    #[test]
    fn values_nobody_wants_are_passed_over() {
        for (text, next) in [
            ("1 2\n3 4\n_a", Token::Name(b"_a")),
            ("1 2\n;text\n_no\n;\n3\n;loop_\n; 4\nloop_", Token::Loop),
            ("1_555 'x _y'\n# comment_\n2 data_z", Token::Data(b"z")),
            ("1", Token::End),
            ("1\n;x", Token::Unclosed),
        ] {
            let stop = Stop::never();
            let mut tokens = Tokens::new(text.as_bytes(), &stop);
            tokens.skip_values();
            assert_eq!(tokens.next(), next, "{text}");
        }
    }
}
