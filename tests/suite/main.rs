//! The one integration binary: one file a topic, so that linking is paid once.
//!
//! A test goes beside the code if it needs one module, and here if it needs the program or several layers. Its name says the fact.
//! What cannot be tested on a machine prints `SKIP` and the reason.

mod cli;
