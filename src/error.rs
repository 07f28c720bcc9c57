//! Errors, by whose fault they are. No other error type leaves the library.

use std::path::PathBuf;

/// What can go wrong.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The file is not what it should be.
    #[error("{}", at_line(*line, message))]
    Input {
        /// 1-based line in the (decompressed) file, if there is one to point at.
        line: Option<u64>,
        /// What was expected, what was found, what to do.
        message: String,
    },
    /// Reading on would take more than a limit allows.
    #[error("{}; the limit protects against broken and hostile files", at_line(*line, message))]
    Limit {
        /// 1-based line in the (decompressed) file, if there is one to point at.
        line: Option<u64>,
        /// Which limit, its value, and how to raise it.
        message: String,
    },
    /// Sound, but not something this program does.
    #[error("{0}")]
    Unsupported(String),
    /// The graphics device is missing, lost, or refuses.
    #[error("GPU: {0}")]
    Gpu(String),
    /// The work was given up, as was asked by its [`crate::stop::Stop`]; nothing is wrong.
    #[error("given up")]
    Stopped,
    /// The operating system refused to read or write.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// `read`, `write`, …
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

impl Error {
    /// An input error at a line.
    pub fn input(line: impl Into<Option<u64>>, message: impl Into<String>) -> Error {
        Error::Input { line: line.into(), message: message.into() }
    }

    /// A limit error at a line.
    pub fn limit(line: impl Into<Option<u64>>, message: impl Into<String>) -> Error {
        Error::Limit { line: line.into(), message: message.into() }
    }

    /// The line it happened at, if known.
    #[must_use]
    pub fn line(&self) -> Option<u64> {
        match self {
            Error::Input { line, .. } | Error::Limit { line, .. } => *line,
            _ => None,
        }
    }
}

/// A result with our [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

fn at_line(line: Option<u64>, message: &str) -> String {
    match line {
        Some(line) => format!("line {line}: {message}"),
        None => message.to_owned(),
    }
}

/// Letters to be put in, taken away, changed or swapped with their neighbour to come from one word to another (the distance of
/// Damerau and Levenshtein, in its restricted form).
pub(crate) fn slips(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().take(32).collect(), b.chars().collect());
    let mut rows = vec![(0..=b.len()).collect::<Vec<usize>>()];
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let change = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut least = change.min(rows[i - 1][j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                least = least.min(rows[i - 2][j - 2] + 1);
            }
            row.push(least);
        }
        rows.push(row);
    }
    rows[a.len()][b.len()]
}
