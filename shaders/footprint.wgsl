// Which pixels a ball, a stick or a box may cover, and whether anything nearer hides it there.
#import "placed.wgsl"
#import "hidden.wgsl"

// Pixels of the target that something may cover (all of it if that is unknown), and its nearest depth.
struct Footprint {
    low: vec2<f32>,
    high: vec2<f32>,
    nearest: f32,
    // False where all of it is nearer than the near plane.
    seen: bool,
}

// Of an interval of the picture plane: see quad_corner.
fn footprint(low: vec2<f32>, high: vec2<f32>, nearest: f32) -> Footprint {
    let grid = frame.grid;
    let shift = grid.yz + 0.5 - one_sample.offset - vec2<f32>(one_sample.origin);
    let slack = 2.0 * SNAP_SLACK_PX;
    let first = vec2<f32>(low.x, -high.y) / grid.x + shift - slack;
    let last = vec2<f32>(high.x, -low.y) / grid.x + shift + slack;
    return Footprint(first, last, nearest, true);
}

fn everywhere(seen: bool) -> Footprint {
    return Footprint(vec2<f32>(-NO_HIT), vec2<f32>(NO_HIT), frame.depth.z, seen);
}

fn sphere_footprint(ball: Sphere) -> Footprint {
    let reach = ball.radius + outline_width(ball.center, ball.radius);
    let rect = sphere_rect(ball.center, reach, frame.depth.z);
    var print = footprint(rect.center - rect.half, rect.center + rect.half, -ball.center.z - reach);
    print.seen = rect.seen;
    return print;
}

// By balls about its two ends, between which it lies.
fn cylinder_footprint(stick: Cylinder) -> Footprint {
    let a = stick.center - stick.row_y * stick.half_length;
    let b = stick.center + stick.row_y * stick.half_length;
    // Round ends of a line with an outline begin farther out by the line's width.
    let reach = stick.radius + 2.0 * outline_width(stick.center, stick.radius);
    let near = frame.depth.z;
    let rect_a = sphere_rect(a, reach, near);
    let rect_b = sphere_rect(b, reach, near);
    let low = min(rect_a.center - rect_a.half, rect_b.center - rect_b.half);
    let high = max(rect_a.center + rect_a.half, rect_b.center + rect_b.half);
    let nearest = min(-a.z, -b.z) - reach;
    if !rect_a.seen || !rect_b.seen || nearest < near {
        // It may cross the near plane, where its ends say too little.
        return everywhere((rect_a.seen || rect_b.seen) && is_solid(stick));
    }
    var print = footprint(low, high, nearest);
    print.seen = is_solid(stick);
    return print;
}

// The first and the last pixel whose centres lie there; the last before the first if there are none.
fn cells(print: Footprint) -> vec4<i32> {
    let low = max(ceil(print.low - 0.5), vec2<f32>(0.0));
    let high = min(floor(print.high - 0.5), vec2<f32>(one_sample.size) - 1.0);
    return vec4<i32>(vec2<i32>(min(low, vec2<f32>(65536.0))), vec2<i32>(max(high, vec2<f32>(-1.0))));
}

// Whether any pixel's centre lies there and shows nothing nearer.
fn is_seen(print: Footprint) -> bool {
    let at = cells(print);
    if !print.seen || any(at.zw < at.xy) {
        return false;
    }
    // The wide, and what is no number.
    if !all(print.high - print.low < vec2<f32>(256.0)) {
        return true;
    }
    return !is_behind_all(vec2<u32>(at.xy), vec2<u32>(at.zw), nearest_value(print));
}

// A depth that rounding makes no nearer.
fn nearest_value(print: Footprint) -> f32 {
    return depth_value(max(print.nearest - 1e-5 * abs(print.nearest) - 1e-4, frame.depth.z));
}

// A strip of pixels, numbered, that holds a stick that does not cross the near plane: its normal, where its middle lies along that, and
// half its width. It is that of the balls about the ends.
fn strip_of(stick: Cylinder) -> vec4<f32> {
    let near = frame.depth.z;
    let a = stick.center - stick.row_y * stick.half_length;
    let b = stick.center + stick.row_y * stick.half_length;
    let rect_a = sphere_rect(a, stick.radius, near);
    let rect_b = sphere_rect(b, stick.radius, near);
    let grid = frame.grid;
    let shift = grid.yz - one_sample.offset - vec2<f32>(one_sample.origin);
    let from_px = vec2<f32>(rect_a.center.x, -rect_a.center.y) / grid.x;
    let to_px = vec2<f32>(rect_b.center.x, -rect_b.center.y) / grid.x;
    let half = max(max(rect_a.half.x, rect_a.half.y), max(rect_b.half.x, rect_b.half.y));
    let along = to_px - from_px;
    let size = length(along);
    // An ellipse reaches no farther from its middle than √2 of the larger half of its box.
    let half_px = 1.5 * half / grid.x + 4.0 * SNAP_SLACK_PX;
    let normal = select(vec2<f32>(0.0), perp(along) / size, size > 1e-3);
    return vec4<f32>(normal, dot(normal, from_px + shift), half_px);
}
