use super::*;

fn options(frames: u32, alpha: bool) -> AnimationOptions {
    let texts = vec![("ballstick-session".to_owned(), "é".to_owned())];
    AnimationOptions { size: (40, 21), frames, fps: 12.0, alpha, background: Srgb8::WHITE, texts }
}

/// A ball that goes to the right over nothing, shaded with more colours than a palette has.
fn ball(index: u32) -> Image {
    let (width, height) = (40u32, 21u32);
    let mut rgba = Vec::new();
    for y in 0..height {
        for x in 0..width {
            let (dx, dy) = (x as f32 - 10.0 - index as f32 * 3.0, y as f32 - 10.0);
            let inside = dx * dx + dy * dy < 64.0;
            let shade = |k: f32| (120.0 + k * dx + 4.0 * dy) as u8;
            rgba.extend(if inside { [shade(9.0), shade(-5.0), shade(2.0), 255] } else { [0, 0, 0, 0] });
        }
    }
    Image { width, height, rgba }
}

fn written(format: AnimationFormat, options: &AnimationOptions) -> (tempfile::TempDir, Vec<u8>, Vec<u32>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(format!("film.{}", format.extension()));
    let mut drawn = Vec::new();
    write(&path, format, options, &mut |index| {
        drawn.push(index);
        Ok(ball(index))
    })
    .unwrap();
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1);
    let bytes = std::fs::read(&path).unwrap();
    (folder, bytes, drawn)
}

/// All frames of a GIF as they are seen, put together as the standard says.
fn gif_frames(bytes: &[u8]) -> (Vec<Vec<u8>>, Vec<u16>) {
    let mut decoder = ::gif::DecodeOptions::new();
    decoder.set_color_output(::gif::ColorOutput::RGBA);
    let mut decoder = decoder.read_info(bytes).unwrap();
    let width = usize::from(decoder.width());
    let mut canvas = vec![0u8; width * usize::from(decoder.height()) * 4];
    let (mut seen, mut delays) = (Vec::new(), Vec::new());
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        let (left, top, w) = (usize::from(frame.left), usize::from(frame.top), usize::from(frame.width));
        for (at, pixel) in frame.buffer.chunks_exact(4).enumerate().filter(|(_, pixel)| pixel[3] > 0) {
            let to = ((top + at / w) * width + left + at % w) * 4;
            canvas[to..to + 4].copy_from_slice(pixel);
        }
        seen.push(canvas.clone());
        delays.push(frame.delay);
        if frame.dispose == ::gif::DisposalMethod::Background {
            canvas.fill(0);
        }
    }
    (seen, delays)
}

#[test]
fn a_gif_shows_every_frame_in_its_colours_for_its_time() {
    for alpha in [false, true] {
        let options = options(6, alpha);
        let (_folder, bytes, drawn) = written(AnimationFormat::Gif, &options);
        assert_eq!(drawn.len() as u32, drawn_frames(AnimationFormat::Gif, 6));
        let (frames, delays) = gif_frames(&bytes);
        assert_eq!(frames.len(), 6);
        assert_eq!(delays.iter().sum::<u16>(), 50, "half a second in all: {delays:?}");
        for (index, frame) in frames.iter().enumerate() {
            for (seen, meant) in frame.chunks_exact(4).zip(ball(index as u32).rgba.chunks_exact(4)) {
                let meant = match meant[3] {
                    0 if alpha => [0; 4],
                    0 => [255; 4],
                    _ => [meant[0], meant[1], meant[2], 255],
                };
                let off = seen.iter().zip(meant).map(|(a, b)| a.abs_diff(b)).max().unwrap();
                assert!(seen[3] == meant[3] && off <= 16, "frame {index}: {seen:?} for {meant:?}");
                // The background is exact, without a pattern.
                assert!(meant != [255; 4] || seen == meant);
            }
        }
    }
}

#[test]
fn an_animated_png_is_every_frame_to_the_last_bit() {
    for alpha in [false, true] {
        let (_folder, bytes, drawn) = written(AnimationFormat::Apng, &options(5, alpha));
        assert_eq!(drawn, [0, 1, 2, 3, 4]);
        let mut reader = png::Decoder::new(io::Cursor::new(&bytes)).read_info().unwrap();
        assert_eq!(reader.info().animation_control.unwrap().num_frames, 5);
        assert_eq!(reader.info().utf8_text[0].get_text().unwrap(), "é");
        let n = if alpha { 4 } else { 3 };
        let mut canvas = vec![0u8; 40 * 21 * n];
        for index in 0..5 {
            let mut part = vec![0; canvas.len()];
            reader.next_frame(&mut part).unwrap();
            let control = *reader.info().frame_control().unwrap();
            assert_eq!((control.delay_num, control.delay_den), (1000, 12_000));
            let [x, y, w, h] = [control.x_offset, control.y_offset, control.width, control.height].map(|v| v as usize);
            for row in 0..h {
                let to = ((y + row) * 40 + x) * n;
                canvas[to..to + w * n].copy_from_slice(&part[row * w * n..(row + 1) * w * n]);
            }
            let image = ball(index);
            let mut meant = image.rgba.clone();
            if !alpha {
                meant.resize(40 * 21 * 3, 0);
                crate::export::picture::flattened(&image.rgba, Srgb8::WHITE, &mut meant);
            }
            assert!(canvas == meant, "frame {index}");
        }
    }
}

#[test]
fn a_frame_that_fails_leaves_the_old_file_and_its_own_words() {
    for format in [AnimationFormat::Gif, AnimationFormat::Apng] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("film");
        std::fs::write(&path, "old").unwrap();
        let error = write(&path, format, &options(9, false), &mut |index| {
            if index == 7 { Err(Error::Gpu("lost".to_owned())) } else { Ok(ball(index)) }
        });
        assert_eq!(error.unwrap_err().to_string(), "GPU: lost");
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1);
    }
}

#[test]
fn an_mp4_needs_ffmpeg_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.mp4");
    match write(&path, AnimationFormat::Mp4, &options(5, false), &mut |index| Ok(ball(index))) {
        Ok(()) => assert!(std::fs::read(&path).unwrap()[4..8] == *b"ftyp"),
        Err(error) => assert!(error.to_string().contains("ffmpeg"), "{error}"),
    }
    let many = AnimationOptions { size: (9000, 2), ..options(5, false) };
    assert!(write(&path, AnimationFormat::Mp4, &many, &mut |index| Ok(ball(index))).is_err());
}

#[test]
fn formats_are_known_by_name() {
    assert_eq!(AnimationFormat::from_path(Path::new("a/B.GIF")), Some(AnimationFormat::Gif));
    assert_eq!(AnimationFormat::from_path(Path::new("a.png")), None);
    assert_eq!(changed(3, |at| at == 4 || at == 8, 9), Some([1, 1, 2, 2]));
    assert_eq!(changed(3, |_| false, 9), None);
}
