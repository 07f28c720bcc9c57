//! MP4 by the program `ffmpeg`, if the machine has it: frames go to it through a pipe, and it writes the file. No shell is asked, and nothing but
//! its own words is shown of it.
//!
//! H.264 in 4:2:0 is what players, browsers and slides take; it wants even sides, so that odd ones get a line of the background.

use super::{AnimationOptions, Film};
use crate::error::{Error, Result};
use crate::export::picture::flattened;
use crate::export::unfinished::Writer;
use crate::render::Image;
use std::io::{self, Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::JoinHandle;

/// A found ffmpeg.
pub(super) struct Ffmpeg {
    /// Its encoder, with its settings.
    encoder: &'static [&'static str],
}

/// Encoders of ffmpeg, the best first; a build without patents' licences lacks the first ones. Qualities chosen: no blocks are seen on edges.
const ENCODERS: [&[&str]; 3] =
    [&["libx264", "-preset", "medium", "-crf", "16"], &["libopenh264", "-b:v", "12M"], &["mpeg4", "-q:v", "2"]];

/// Looks for ffmpeg.
pub(super) fn find() -> Result<Ffmpeg> {
    let asked = Command::new("ffmpeg").args(["-hide_banner", "-encoders"]).stdin(Stdio::null()).output();
    let listed = match asked {
        Ok(output) => String::from_utf8_lossy(&output.stdout).into_owned(),
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            return Err(Error::Unsupported(
                "mp4 is made by the program ffmpeg, which is not there: install it (https://ffmpeg.org), or write a .gif or .apng"
                    .to_owned(),
            ));
        }
        Err(error) => {
            return Err(Error::Unsupported(format!("ffmpeg cannot be started: {error}; write a .gif or .apng")));
        }
    };
    let has = |name: &str| listed.lines().any(|line| line.split_whitespace().nth(1) == Some(name));
    let encoder = ENCODERS.into_iter().find(|encoder| has(encoder[0])).ok_or_else(|| {
        Error::Unsupported(
            "this ffmpeg has no encoder for mp4 (libx264, libopenh264, mpeg4); write a .gif or .apng".to_owned(),
        )
    })?;
    Ok(Ffmpeg { encoder })
}

pub(super) struct Mp4 {
    child: Child,
    /// What it says.
    said: Option<JoinHandle<String>>,
    options: AnimationOptions,
    /// Ends with us.
    _writer: Writer,
}

impl Mp4 {
    pub(super) fn new(ffmpeg: &Ffmpeg, options: &AnimationOptions, place: &Path) -> io::Result<Mp4> {
        let [width, height] = even(options.size);
        let mut command = Command::new("ffmpeg");
        command
            .args(["-hide_banner", "-loglevel", "error", "-y", "-f", "rawvideo", "-pixel_format", "rgb24"])
            .args(["-video_size", &format!("{width}x{height}"), "-framerate", &options.fps.to_string()])
            .args(["-i", "pipe:0", "-an", "-vf", "scale=out_color_matrix=bt709:out_range=tv,format=yuv420p"])
            .arg("-c:v")
            .args(ffmpeg.encoder)
            .args(["-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "iec61966-2-1"])
            .args(["-movflags", "+faststart", "-f", "mp4"])
            // A name that begins with a dash would be an option.
            .arg(std::path::absolute(place)?)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        let mut child = command.spawn()?;
        let writer = Writer::new(child.id());
        let said = child.stderr.take().and_then(|mut stderr| {
            let read = move || {
                let mut text = Vec::new();
                // What it says is short; a mad one is not listened to for ever.
                let _ = stderr.by_ref().take(1 << 16).read_to_end(&mut text);
                let _ = io::copy(&mut stderr, &mut io::sink());
                String::from_utf8_lossy(&text).into_owned()
            };
            std::thread::Builder::new().name("ffmpeg".to_owned()).spawn(read).ok()
        });
        Ok(Mp4 { child, said, options: options.clone(), _writer: writer })
    }

    /// Why it ended before it was told to.
    fn reason(&mut self, error: &str) -> io::Error {
        let _ = self.child.kill();
        let _ = self.child.wait();
        let said = self.said.take().and_then(|thread| thread.join().ok()).unwrap_or_default();
        let said = said.trim();
        io::Error::other(format!("ffmpeg: {}", if said.is_empty() { error } else { said }))
    }
}

impl Drop for Mp4 {
    /// A film that is given up leaves no process behind.
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn even((width, height): (u32, u32)) -> [u32; 2] {
    [width, height].map(|side| side.next_multiple_of(2))
}

impl Film for Mp4 {
    fn frame(&mut self, image: &Image) -> io::Result<()> {
        let [width, height] = even(self.options.size).map(|side| side as usize);
        let background = self.options.background;
        let mut rgb: Vec<u8> = super::rgb_of(background).repeat(width * height);
        let (line, own) = (width * 3, image.width as usize);
        for (row, pixels) in rgb.chunks_exact_mut(line).zip(image.rgba.chunks_exact(own * 4)) {
            flattened(pixels, background, &mut row[..own * 3]);
        }
        let written = match &mut self.child.stdin {
            Some(pipe) => pipe.write_all(&rgb),
            None => Err(io::ErrorKind::BrokenPipe.into()),
        };
        written.map_err(|error| self.reason(&error.to_string()))
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        // The end of its input.
        drop(self.child.stdin.take());
        let status = self.child.wait()?;
        if status.success() { Ok(()) } else { Err(self.reason(&format!("it ended with {status}"))) }
    }
}
