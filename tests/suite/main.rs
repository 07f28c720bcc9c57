//! The integration tests, in one binary (linking is slow). A test goes into the module of its topic; a new topic is a
//! new module here.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test fails by panicking")]

mod bad_input;
mod corpus;
