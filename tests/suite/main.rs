//! The integration tests, in one binary (linking is slow). A test goes into the module of its topic; a new topic is a
//! new module here.

mod bad_input;
mod corpus;
