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

// Whether light from afar is asked for at all, and whether there is ground: what is not there costs every pixel of a frame in motion.
override asks_light: bool = true;
override has_ground: bool = true;

fn is_before_ground(depth: f32, ray: Ray) -> bool {
    return !has_ground || depth <= ground_depth(ray);
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
            if is_before_ground(bitcast<f32>(texel.z), ray) {
                sum += vec4<f32>(shade_outline(ray.origin + ray.direction * t), 1.0);
            }
        } else if is_before_ground(t, ray) {
            let seen = VisibleSurface(t, unpack_normal(texel.z), unpack_color(texel.w));
            var reach = Reach(frame.sky.z, 1.0);
            if asks_light {
                reach = reach_of(ray, t, seen.normal);
            }
            sum += vec4<f32>(shade_surface(seen, reach, ray), 1.0);
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
