// From the sum of samples to pixels: what lies behind the primitives, found once a pixel at its centre, then the twin of
// frame::resolve, in three ways to write it.
#import "fullscreen.wgsl"
#import "shade.wgsl"
#import "color.wgsl"

@group(1) @binding(0) var sums: texture_2d<u32>;
@group(1) @binding(1) var ground_light: texture_2d<u32>;
// Of windows only: text in sRGB with straight alpha, a byte a channel; one clear texel where there is none.
@group(1) @binding(2) var text: texture_2d<u32>;

// Twin of GroundMap::at; two floats a texel.
fn ground_map_at(point_in_world: vec3<f32>) -> vec2<f32> {
    let x = (point_in_world.x - frame.ground_map.x) * frame.ground_map.z - 0.5;
    let z = (point_in_world.z - frame.ground_map.y) * frame.ground_map.z - 0.5;
    let size = frame.ground_map_size.xy;
    if !(x >= 0.0 && z >= 0.0 && x <= size.x - 1.0 && z <= size.y - 1.0) {
        return vec2<f32>(1.0);
    }
    let corner = vec2<f32>(floor(x), floor(z));
    let part = vec2<f32>(x, z) - corner;
    let near = mix_lights(ground_texel(corner), ground_texel(corner + vec2<f32>(1.0, 0.0)), part.x);
    let far = mix_lights(ground_texel(corner + vec2<f32>(0.0, 1.0)), ground_texel(corner + vec2<f32>(1.0)), part.x);
    return mix_lights(near, far, part.y);
}

fn mix_lights(a: vec2<f32>, b: vec2<f32>, part: f32) -> vec2<f32> {
    return a + (b - a) * part;
}

fn ground_texel(at: vec2<f32>) -> vec2<f32> {
    let last = vec2<i32>(frame.ground_map_size.xy) - 1;
    return bitcast<vec2<f32>>(textureLoad(ground_light, min(vec2<i32>(at), last), 0).xy);
}

// Whether there is ground: without it nothing is asked for.
override has_ground: bool = true;

// Twin of Shader::backdrop.
fn backdrop(ray: Ray) -> vec4<f32> {
    if !has_ground {
        return shade_background();
    }
    let t = ground_depth(ray);
    if !(t < NO_HIT) {
        return shade_background();
    }
    let point = world_point(ray.origin + ray.direction * t);
    let light = ground_map_at(point);
    return shade_ground(point, light.x, light.y);
}

// Mean of the samples: premultiplied linear colour and alpha. `done` counts all of them here.
fn mean(fragment: vec4<f32>) -> vec4<f32> {
    let samples = f32(one_sample.done);
    let sum = bitcast<vec4<f32>>(textureLoad(sums, vec2<i32>(fragment.xy), 0));
    let behind = backdrop(pixel_ray(fragment, vec2<f32>(0.5)));
    return (sum + behind * (samples - sum.w)) / samples;
}

fn encode(linear: vec3<f32>) -> vec3<f32> {
    let r = quantise(srgb_from_linear(linear.x));
    let g = quantise(srgb_from_linear(linear.y));
    let b = quantise(srgb_from_linear(linear.z));
    return vec3<f32>(r, g, b);
}

// Straight alpha, for pictures.
@fragment
fn fs_resolve(@builtin(position) fragment: vec4<f32>) -> @location(0) vec4<f32> {
    let color = mean(fragment);
    if !(color.w > 0.0) {
        return vec4<f32>(0.0);
    }
    return vec4<f32>(encode(color.xyz / color.w), quantise(color.w));
}

// Opaque, for windows: what is transparent stands on white, text is laid over it in sRGB as in pictures.
fn opaque_srgb(fragment: vec4<f32>) -> vec3<f32> {
    let color = mean(fragment);
    let last = vec2<i32>(textureDimensions(text)) - 1;
    let ink = vec4<f32>(textureLoad(text, min(vec2<i32>(fragment.xy), last), 0)) / 255.0;
    return mix(encode(color.xyz + (1.0 - min(color.w, 1.0))), ink.xyz, ink.w);
}

@fragment
fn fs_present(@builtin(position) fragment: vec4<f32>) -> @location(0) vec4<f32> {
    return vec4<f32>(opaque_srgb(fragment), 1.0);
}

// The same for surfaces that encode sRGB themselves.
@fragment
fn fs_present_linear(@builtin(position) fragment: vec4<f32>) -> @location(0) vec4<f32> {
    let srgb = opaque_srgb(fragment);
    return vec4<f32>(linear_from_srgb(srgb.x), linear_from_srgb(srgb.y), linear_from_srgb(srgb.z), 1.0);
}
