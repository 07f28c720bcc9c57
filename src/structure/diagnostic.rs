//! What a reader noticed: warnings and errors with line numbers.

/// How bad it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// The reading went on; what follows from it is said in the message.
    Warning,
    /// Part of the file could not be read.
    Error,
}

impl Severity {
    /// `warning` or `error`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Severity::Warning => "warning",
            Severity::Error => "error",
        }
    }
}

/// One thing a reader noticed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// How bad it is.
    pub severity: Severity,
    /// 1-based line in the (decompressed) file, `None` if it concerns no line.
    pub line: Option<u64>,
    /// What was found, what was expected, what was done about it.
    pub message: String,
}

impl std::fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.line {
            Some(line) => write!(f, "line {line}: {}: {}", self.severity.name(), self.message),
            None => write!(f, "{}: {}", self.severity.name(), self.message),
        }
    }
}

/// Collects diagnostics. A file with a million bad lines gives the first of each kind and a count, not a million.
#[derive(Debug, Clone, Default)]
pub struct Diagnostics {
    list: Vec<Diagnostic>,
    suppressed: u64,
}

impl Diagnostics {
    /// How many are kept; the rest is counted.
    pub const MAX_KEPT: usize = 100;

    /// Adds a warning.
    pub fn warn(&mut self, line: Option<u64>, message: impl Into<String>) {
        self.push(Severity::Warning, line, message);
    }

    /// Adds an error: part of the file is lost, the rest was read.
    pub fn error(&mut self, line: Option<u64>, message: impl Into<String>) {
        self.push(Severity::Error, line, message);
    }

    fn push(&mut self, severity: Severity, line: Option<u64>, message: impl Into<String>) {
        if self.list.len() < Self::MAX_KEPT {
            self.list.push(Diagnostic { severity, line, message: message.into() });
        } else {
            self.suppressed += 1;
        }
    }

    /// Adds those of a part that was read on its own, behind these.
    pub fn append(&mut self, later: Diagnostics) {
        for diagnostic in later.list {
            self.push(diagnostic.severity, diagnostic.line, diagnostic.message);
        }
        self.suppressed += later.suppressed;
    }

    /// Whether there is nothing to say.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// The diagnostics in the order they were noticed, the last one saying how many more there were.
    #[must_use]
    pub fn into_list(mut self) -> Vec<Diagnostic> {
        if self.suppressed > 0 {
            let message = format!("{} more like these", self.suppressed);
            self.list.push(Diagnostic { severity: Severity::Warning, line: None, message });
        }
        self.list
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flood_is_counted_not_kept() {
        let mut diagnostics = Diagnostics::default();
        for line in 0..250 {
            diagnostics.warn(Some(line), "odd");
        }
        let list = diagnostics.into_list();
        assert_eq!(list.len(), Diagnostics::MAX_KEPT + 1);
        assert_eq!(list[100].message, "150 more like these");
        let (mut all, mut parts) = (Diagnostics::default(), Diagnostics::default());
        for part in 0..3 {
            let mut own = Diagnostics::default();
            for line in 0..part * 80 {
                all.warn(Some(line), "odd");
                own.warn(Some(line), "odd");
            }
            parts.append(own);
        }
        assert_eq!(parts.into_list(), all.into_list());
    }
}
