#![no_main]

use ballstick::import::Limits;
use ballstick::import::trajectory::Trajectory;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let limits = Limits { atoms: 20_000, ..Limits::default() };
    let Ok(trajectory) = Trajectory::of_bytes(bytes.to_vec(), "", &limits) else { return };
    let frames = trajectory.count_frames(|| true).expect("memory can be read");
    let _ = trajectory.problem();
    for number in (0..frames.min(4)).rev() {
        if let Ok(frame) = trajectory.frame(number) {
            assert_eq!(frame.positions.len(), trajectory.atom_count());
            assert!(frame.positions.relative().iter().all(|position| position.is_finite()));
        }
    }
});
