// Adds the light of one sample to the sum: premultiplied linear colour, and in alpha how many samples saw a primitive.
// Sums are floats in the bits of an integer target: float targets cannot be drawn to everywhere.
#import "fullscreen.wgsl"
#import "sky.wgsl"
#import "color.wgsl"
#import "unpack.wgsl"

@group(1) @binding(0) var surfaces: texture_2d<u32>;
@group(1) @binding(1) var sum_before: texture_2d<u32>;

@fragment
fn fs_shade(@builtin(position) fragment: vec4<f32>) -> @location(0) vec4<u32> {
    let pixel = vec2<i32>(fragment.xy);
    var sum = vec4<f32>(0.0);
    if one_sample.done > 0u {
        sum = bitcast<vec4<f32>>(textureLoad(sum_before, pixel, 0));
    }
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
            let seen = VisibleSurface(t, unpack_normal(texel.z), linear_from_srgb8(texel.w));
            sum += vec4<f32>(shade_surface(seen, reach_of(ray, t, seen.normal), ray.direction), 1.0);
        }
    }
    return bitcast<vec4<u32>>(sum);
}
