//! A picture drawn strip by strip into its file, so that its size costs time but no memory.

use super::args::Channel;
use super::picture::{Draw, Pixels};
use super::values::Region;
use crate::error::{Error, Result};
use crate::export::atomic;
use crate::export::picture::{Content, Layer, PictureFile, PictureFormat, PictureOptions, depth_range};
use std::io;
use std::path::Path;
use std::time::Instant;

/// Pixels of a strip of a picture: 64 MiB of colours. Each strip sorts all primitives anew, so fewer are better;
/// up to 4096 × 4096 it is one. Chosen.
const COLOR_PIXELS: u32 = 1 << 24;

/// Pixels of a strip of depth, normals, ids and the sky's part, which take some 30 bytes each while they are found.
const SURFACE_PIXELS: u32 = 1 << 22;

/// Pixels of a strip where memory is to be spared: a row of tiles of a picture of 8192 pixels a row. With light from afar
/// such a strip takes some 10 MB at the most.
pub(super) const SPARED_PIXELS: u32 = 1 << 18;

/// Rows of a tile of the CPU renderer: fewer would be drawn for nothing.
const TILE_ROWS: u32 = 32;

/// What is drawn where.
pub(super) struct Target<'a> {
    pub(super) region: Region,
    pub(super) channel: Channel,
    pub(super) format: PictureFormat,
    pub(super) path: &'a Path,
}

/// Seconds that it took.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Seconds {
    pub(super) render: f64,
    pub(super) encode: f64,
}

/// The parts of a region from the top, each with as many rows as memory allows, in whole tiles.
fn strips(region: Region, pixels: u32) -> Vec<Region> {
    let rows = (pixels / region.width.max(1)).max(TILE_ROWS);
    let rows = rows - rows % TILE_ROWS;
    let starts = (0..region.height).step_by(rows as usize);
    starts.map(|y| Region { y: region.y + y, height: rows.min(region.height - y), ..region }).collect()
}

/// Draws what is loaded into a file. `options` is asked when the first strip is drawn, as only then it is certain who
/// draws; `progress` hears after every strip how much is done, 0 to 1.
pub(super) fn write(
    draw: &mut dyn Draw,
    target: &Target<'_>,
    options: impl FnOnce(&dyn Draw) -> PictureOptions,
    progress: impl Fn(f64),
) -> Result<Seconds> {
    let Target { region, channel, format, path } = *target;
    let started = Instant::now();
    let most = match channel {
        _ if super::apart::is_sparing() => SPARED_PIXELS,
        Channel::Color => COLOR_PIXELS,
        _ => SURFACE_PIXELS,
    };
    let strips = strips(region, most);
    let Some((first, others)) = strips.split_first() else { return Ok(Seconds::default()) };
    let mut painter = Painter { draw, channel, seconds: 0.0 };
    let mut pixels = painter.part(first)?;
    let mut layer = content(&pixels, channel)?.layer();
    if channel == Channel::Depth && format == PictureFormat::Png && !others.is_empty() {
        // The range of all depths comes before the first of them: they are found twice, which is cheap.
        layer = depth_layer(std::iter::once(Ok(pixels)).chain(others.iter().map(|strip| painter.part(strip))))?;
        pixels = painter.part(first)?;
    }
    let options = options(painter.draw);
    let mut failed = None;
    let written = atomic::write(path, |out| {
        let mut file = PictureFile::new((region.width, region.height), layer, format, &options, out)?;
        file.strip(content(&pixels, channel).map_err(io::Error::other)?)?;
        for strip in others {
            progress(f64::from(strip.y - region.y) / f64::from(region.height));
            // A renderer's error is kept as it is while the file is given up.
            pixels = painter.part(strip).map_err(|error| {
                failed = Some(error);
                io::Error::other("the picture could not be drawn")
            })?;
            file.strip(content(&pixels, channel).map_err(io::Error::other)?)?;
        }
        file.finish()
    });
    match failed {
        Some(error) => Err(error),
        None => {
            let render = painter.seconds;
            written.map(|()| Seconds { render, encode: started.elapsed().as_secs_f64() - render })
        }
    }
}

/// Draws parts and counts the time.
struct Painter<'a> {
    draw: &'a mut dyn Draw,
    channel: Channel,
    seconds: f64,
}

impl Painter<'_> {
    fn part(&mut self, strip: &Region) -> Result<Pixels> {
        let started = Instant::now();
        let pixels = self.draw.part(*strip, self.channel);
        self.seconds += started.elapsed().as_secs_f64();
        pixels
    }
}

/// What the channel shows of drawn pixels.
fn content(pixels: &Pixels, channel: Channel) -> Result<Content<'_>> {
    Ok(match (pixels, channel) {
        (Pixels::Image(image), Channel::Color) => Content::Color(image),
        (Pixels::Surface(surface), Channel::Depth) => Content::Depth(surface),
        (Pixels::Surface(surface), Channel::Normal) => Content::Normal(surface),
        (Pixels::Surface(surface), Channel::Id) => Content::Id(surface),
        (Pixels::Sky(sky), Channel::Ao) => Content::Ao(sky),
        _ => return Err(Error::Unsupported("the renderer drew another channel than asked for".to_owned())),
    })
}

/// The range of depths over all strips.
fn depth_layer(strips: impl Iterator<Item = Result<Pixels>>) -> Result<Layer> {
    let mut range: Option<(f32, f32)> = None;
    for strip in strips {
        if let Pixels::Surface(surface) = strip?
            && let Some((near, far)) = depth_range(&surface.depth)
        {
            range = Some(range.map_or((near, far), |(nearest, farthest)| (nearest.min(near), farthest.max(far))));
        }
    }
    let (near, far) = range.unwrap_or((0.0, 0.0));
    Ok(Layer::Depth { near, far })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_cover_the_region_in_whole_tiles_within_memory() {
        for (x, y, width, height) in [
            (0, 0, 1, 1),
            (0, 0, 1920, 1080),
            (7, 9, 16384, 16384),
            (0, 0, 32768, 32768),
            (0, 0, 1, 32768),
            (5, 5, 32763, 1),
        ] {
            let region = Region { x, y, width, height };
            for pixels in [COLOR_PIXELS, SURFACE_PIXELS] {
                let strips = strips(region, pixels);
                let mut next = y;
                for (index, strip) in strips.iter().enumerate() {
                    assert_eq!((strip.x, strip.y, strip.width), (x, next, width));
                    assert!(u64::from(strip.width) * u64::from(strip.height) <= u64::from(pixels), "{strip}");
                    assert!(index + 1 == strips.len() || strip.height.is_multiple_of(32));
                    next += strip.height;
                }
                assert_eq!(next, y + height);
            }
        }
        assert_eq!(strips(Region { x: 0, y: 0, width: 3840, height: 2160 }, COLOR_PIXELS).len(), 1);
        assert_eq!(strips(Region { x: 0, y: 0, width: 16384, height: 16384 }, COLOR_PIXELS).len(), 16);
    }
}
