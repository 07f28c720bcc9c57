#![no_main]

// A session, or a picture with one: strict reading, and whatever is read has settings and is read again.
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| ballstick_fuzz::session(bytes));
