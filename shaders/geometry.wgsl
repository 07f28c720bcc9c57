// From an instance to the visible surface of one sample: the target's clip space, depth, and the packed texel.
#import "bounds.wgsl"
#import "opacity.wgsl"

// Twin of render::gpu::layout::PlacementConstants.
struct PlacementConstants {
    // Columns of the rigid transform from block to view space.
    x_axis: vec4<f32>,
    y_axis: vec4<f32>,
    z_axis: vec4<f32>,
    translation: vec4<f32>,
    // x: added to the ids of the block, saturating.
    first_id: vec4<u32>,
}

@group(1) @binding(0) var<uniform> placement: PlacementConstants;

fn view_point(p: vec3<f32>) -> vec3<f32> {
    return view_vector(p) + placement.translation.xyz;
}

fn view_vector(v: vec3<f32>) -> vec3<f32> {
    return placement.x_axis.xyz * v.x + placement.y_axis.xyz * v.y + placement.z_axis.xyz * v.z;
}

fn placed_id(id: u32) -> u32 {
    let sum = id + placement.first_id.x;
    return select(sum, 0xffffffffu, sum < id);
}

// Reversed depth: 1 at the near plane. Never 0, which is the cleared buffer's: nothing is cut at the far plane.
fn depth_value(t: f32) -> f32 {
    let near = frame.depth.z;
    if is_orthographic() {
        return clamp((frame.depth.w - t) / (frame.depth.w - near), 1e-7, 1.0);
    }
    return clamp(near / t, 1e-30, 1.0);
}

// Outside of everything: a quad with all corners there draws nothing.
const NOWHERE = vec4<f32>(2.0, 2.0, 0.5, 1.0);

// Rasterisers snap corners to a grid: Vulkan asks for sixteenths of a pixel at least, so that a corner may be off by a
// thirty-second. Twice that, so that no covered sample is lost.
const SNAP_SLACK_PX: f32 = 0.0625;

// A corner of the rectangle in the clip space of the target. The sample's place in the full picture falls onto the
// centre of its pixel's fragment.
fn quad_corner(rect: PlaneRect, corner: u32, nearest_depth: f32) -> vec4<f32> {
    if !rect.seen {
        return NOWHERE;
    }
    let grid = frame.grid;
    let signs = vec2<f32>(select(1.0, -1.0, (corner & 1u) == 0u), select(1.0, -1.0, (corner & 2u) == 0u));
    var half_px = rect.half / grid.x + SNAP_SLACK_PX;
    let shift = grid.yz + 0.5 - one_sample.offset - vec2<f32>(one_sample.origin);
    let center_px = vec2<f32>(rect.center.x, -rect.center.y) / grid.x + shift;
    // The picture's y runs down.
    var along = vec2<f32>(rect.along.x, -rect.along.y);
    var across = vec2<f32>(perp(rect.along).x, -perp(rect.along).y);
    let upright_px = abs(along) * half_px.x + abs(across) * half_px.y;
    let corner_px = center_px + along * (half_px.x * signs.x) + across * (half_px.y * signs.y);
    return target_corner(corner_px, center_px - upright_px, center_px + upright_px, corner, nearest_depth);
}

// A corner of what bounds a primitive, in pixels of the target, and of the upright box around all corners, in clip space.
fn target_corner(at: vec2<f32>, low: vec2<f32>, high: vec2<f32>, corner: u32, nearest_depth: f32) -> vec4<f32> {
    let size_px = vec2<f32>(one_sample.size);
    let is_high = vec2<bool>((corner & 1u) == 1u, (corner & 2u) == 2u);
    var corner_px = at;
    let reach = 8.0 * max(size_px.x, size_px.y);
    let far_out = max(max(abs(low.x), abs(low.y)), max(abs(high.x), abs(high.y)));
    if !(far_out < reach) {
        // Large numbers would be clipped with large errors: the upright box, cut just outside of the target.
        let wanted = select(low, high, is_high);
        corner_px = clamp(wanted, vec2<f32>(-2.0), size_px + 2.0);
        // NaN and infinities show everything.
        let all = select(vec2<f32>(-2.0), size_px + 2.0, is_high);
        corner_px = select(all, corner_px, abs(wanted) < vec2<f32>(NO_HIT));
    }
    let ndc = corner_px / size_px * 2.0 - 1.0;
    let z = depth_value(max(nearest_depth, frame.depth.z));
    return vec4<f32>(ndc.x, -ndc.y, z, 1.0);
}

struct Surface {
    // id, depth, normal, colour in sRGB: 10 bits a channel, red lowest.
    @location(0) texel: vec4<u32>,
    @builtin(frag_depth) depth: f32,
}

// Marks a texel that a primitive covers; the cleared target has 0.
const COVERED: u32 = 0xc0000000u;

fn surface(id: u32, t: f32, normal: vec3<f32>, color: u32) -> Surface {
    return Surface(vec4<u32>(id, bitcast<u32>(t), pack_normal(normal), color | COVERED), depth_value(t));
}

// 8-bit sRGB as the texel holds it: four steps for each.
fn color_from_srgb8(rgb: u32) -> u32 {
    return ((rgb & 255u) | ((rgb & 0xff00u) << 2u) | ((rgb & 0xff0000u) << 4u)) << 2u;
}

// Octahedral, two 16-bit signed parts (Cigolle et al., "A Survey of Efficient Representations for Independent Unit
// Vectors", JCGT 3(2), 2014): off by at most 5e-5.
fn pack_normal(n: vec3<f32>) -> u32 {
    let p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    let signs = select(vec2<f32>(-1.0), vec2<f32>(1.0), p >= vec2<f32>(0.0));
    let folded = (1.0 - abs(p.yx)) * signs;
    return pack2x16snorm(select(p, folded, n.z < 0.0));
}

