// Adds what one sample finds to the sum before. Sums are floats in the bits of an integer target: float targets cannot be drawn to
// everywhere.
#import "fullscreen.wgsl"
#import "sky.wgsl"
#import "unpack.wgsl"

@group(1) @binding(0) var surfaces: texture_2d<u32>;
@group(1) @binding(1) var sum_before: texture_2d<u32>;

fn sum_so_far(pixel: vec2<i32>) -> vec4<f32> {
    if one_sample.done == 0u {
        return vec4<f32>(0.0);
    }
    return bitcast<vec4<f32>>(textureLoad(sum_before, pixel, 0));
}

// Light: premultiplied linear colour, and in alpha how many samples saw a primitive.
@fragment
fn fs_shade(@builtin(position) fragment: vec4<f32>) -> @location(0) vec4<u32> {
    let pixel = vec2<i32>(fragment.xy);
    var sum = sum_so_far(pixel);
    let texel = textureLoad(surfaces, pixel, 0);
    if texel.w != 0u {
        let ray = pixel_ray(fragment, one_sample.offset);
        let t = bitcast<f32>(texel.y);
        if (texel.w >> 30u) == (RIM >> 30u) {
            // The ground hides a line where it hides the silhouette.
            if bitcast<f32>(texel.z) <= ground_depth(ray) {
                sum += vec4<f32>(shade_outline(t), 1.0);
            }
        } else if t <= ground_depth(ray) {
            let seen = VisibleSurface(t, unpack_normal(texel.z), unpack_color(texel.w));
            sum += vec4<f32>(shade_surface(seen, reach_of(ray, t, seen.normal), ray.direction), 1.0);
        }
    }
    return bitcast<vec4<u32>>(sum);
}

// The sky alone: the weights of the directions that are free, and of all.
@fragment
fn fs_sky(@builtin(position) fragment: vec4<f32>) -> @location(0) vec4<u32> {
    let pixel = vec2<i32>(fragment.xy);
    var sum = sum_so_far(pixel);
    let texel = textureLoad(surfaces, pixel, 0);
    let t = bitcast<f32>(texel.y);
    let ray = pixel_ray(fragment, one_sample.offset);
    if texel.w != 0u && t > frame.depth.z && t <= ground_depth(ray) {
        let n = world_vector(unpack_normal(texel.z));
        sum += vec4<f32>(weights_seen(false, reach_start(ray, t, n), n), 0.0, 0.0);
    }
    return bitcast<vec4<u32>>(sum);
}
