// What every pass shares: the picture's constants, the sample's, and the ray of a pixel.
//
// A test compares the offsets of FrameConstants and SampleConstants with the Rust structs.

// Stands for infinity: WGSL may assume that there is none.
const NO_HIT: f32 = 3.0e38;

// Twin of render::frame::FrameConstants, the same bytes.
struct FrameConstants {
    world_from_view: mat4x4<f32>,
    key: vec4<f32>,
    fill: vec4<f32>,
    up: vec4<f32>,
    ambient: vec4<f32>,
    background: vec4<f32>,
    depth: vec4<f32>,
    fog: vec4<f32>,
    ground_color: vec4<f32>,
    ground: vec4<f32>,
    ground_center: vec4<f32>,
    ground_map: vec4<f32>,
    ground_map_size: vec4<f32>,
    key_in_world: vec4<f32>,
    bounds_min: vec4<f32>,
    bounds_max: vec4<f32>,
    grid: vec4<f32>,
    sky: vec4<f32>,
    outline: vec4<f32>,
    outline_color: vec4<f32>,
}

// Twin of render::gpu::layout::SampleConstants.
struct SampleConstants {
    // Upper left pixel of the target in the full picture.
    origin: vec2<u32>,
    // Pixels of the target that are drawn to.
    size: vec2<u32>,
    // Place of the sample in its pixel.
    offset: vec2<f32>,
    // Samples summed before this one.
    done: u32,
    // The sample's turn among those in which see-through primitives are there (12 bits), the turn by which they hide light (12 bits),
    // and log2 of the number of turns.
    turn: u32,
}

// The highest two bits of a texel's colour in the surface target: 3 where a primitive is seen, 2 where an outline is (with the depth of the
// silhouette in place of the normal), 0 where there is nothing.
const RIM: u32 = 0x80000000u;

@group(0) @binding(0) var<uniform> frame: FrameConstants;
@group(0) @binding(1) var<uniform> one_sample: SampleConstants;

struct Ray {
    origin: vec3<f32>,
    direction: vec3<f32>,
}

fn is_orthographic() -> bool {
    return frame.grid.w > 0.5;
}

// Twin of PixelGrid::plane.
fn plane(point_px: vec2<f32>) -> vec2<f32> {
    return vec2<f32>((point_px.x - frame.grid.y) * frame.grid.x, (frame.grid.z - point_px.y) * frame.grid.x);
}

// Twin of PixelGrid::ray.
fn plane_ray(uv: vec2<f32>) -> Ray {
    if is_orthographic() {
        return Ray(vec3<f32>(uv, 0.0), vec3<f32>(0.0, 0.0, -1.0));
    }
    return Ray(vec3<f32>(0.0), vec3<f32>(uv, -1.0));
}

// The ray through the place `offset` of the pixel that a fragment of the target belongs to.
fn pixel_ray(fragment: vec4<f32>, offset: vec2<f32>) -> Ray {
    let pixel = vec2<f32>(vec2<u32>(fragment.xy) + one_sample.origin);
    return plane_ray(plane(pixel + offset));
}

// A point and a direction in world space.
fn world_point(p: vec3<f32>) -> vec3<f32> {
    let m = frame.world_from_view;
    return m[0].xyz * p.x + m[1].xyz * p.y + m[2].xyz * p.z + m[3].xyz;
}

fn world_vector(v: vec3<f32>) -> vec3<f32> {
    let m = frame.world_from_view;
    return m[0].xyz * v.x + m[1].xyz * v.y + m[2].xyz * v.z;
}
