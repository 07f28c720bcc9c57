// Light and colour: the twins of src/render/frame.rs and of GroundMap::at. Comments stand there.
#import "common.wgsl"
#import "color.wgsl"

// Twin of render::sky::Reach.
struct Reach {
    open: f32,
    key: f32,
}

struct VisibleSurface {
    depth: f32,
    normal: vec3<f32>,
    albedo: vec3<f32>,
}

fn into_fog(position: vec3<f32>) -> f32 {
    let fog = frame.fog;
    return clamp(fog.x * position.x + fog.y * position.y + (fog.z * position.z + fog.w), 0.0, 1.0);
}

fn shade_surface(point: VisibleSurface, reach: Reach, ray: Ray) -> vec3<f32> {
    let n = point.normal;
    let to_eye = -ray.direction * (1.0 / sqrt(dot(ray.direction, ray.direction)));
    let key = frame.key.xyz;
    let seen = reach.open * (1.0 - frame.sky.w + frame.sky.w * reach.open);
    let open = frame.sky.x + (1.0 - frame.sky.x) * seen;
    let lit = 1.0 - frame.sky.y * (1.0 - reach.key);
    let key_light = frame.key.w * max(dot(n, key), 0.0) * lit;
    let fill_light = frame.fill.w * max(dot(n, frame.fill.xyz), 0.0) * open;
    let facing_up = 0.5 + 0.5 * dot(n, frame.up.xyz);
    let ambient = (frame.ambient.x + (frame.up.w - frame.ambient.x) * facing_up) * open;
    let half_sum = key + to_eye;
    let half_way = half_sum * (1.0 / sqrt(max(dot(half_sum, half_sum), 1e-12)));
    var gloss = select(0.0, max(dot(n, half_way), 0.0), dot(n, key) > 0.0);
    for (var i = 0u; i < u32(frame.ambient.z); i++) {
        gloss *= gloss;
    }
    let highlight = frame.ambient.y * gloss * lit;
    let aside = 1.0 - clamp(dot(n, to_eye), 0.0, 1.0);
    let rim = 1.0 - frame.key_in_world.w * aside * aside;
    let color = point.albedo * ((ambient + (key_light + fill_light)) * rim) + highlight;
    let behind = into_fog(ray.origin + ray.direction * point.depth);
    let fog = frame.background.w * behind * behind;
    return color + (frame.background.xyz - color) * fog;
}

fn shade_outline(position: vec3<f32>) -> vec3<f32> {
    let behind = into_fog(position);
    let fog = frame.background.w * behind * behind;
    return frame.outline_color.xyz + (frame.background.xyz - frame.outline_color.xyz) * fog;
}

fn is_transparent() -> bool {
    return frame.ambient.w > 0.5;
}

fn shade_ground(point_in_world: vec3<f32>, visible: f32, open: f32) -> vec4<f32> {
    let dx = point_in_world.x - frame.ground_center.x;
    let dz = point_in_world.z - frame.ground_center.y;
    let far = clamp((sqrt(dx * dx + dz * dz) - frame.ground.y) * frame.ground.z, 0.0, 1.0);
    let fade = 1.0 - far * far * (3.0 - 2.0 * far);
    let light = (1.0 - frame.ground_center.z * (1.0 - visible)) * (1.0 - frame.ground_center.w * (1.0 - open));
    if is_transparent() {
        return vec4<f32>(0.0, 0.0, 0.0, 1.0 - srgb_from_linear(1.0 - fade * (1.0 - light)));
    }
    let background = frame.background.xyz;
    return vec4<f32>(background + (frame.ground_color.xyz * light - background) * fade, 1.0);
}

fn shade_background() -> vec4<f32> {
    return select(vec4<f32>(frame.background.xyz, 1.0), vec4<f32>(0.0), is_transparent());
}

fn ground_t(origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    if !(frame.ground_color.w > 0.5) || direction.y > -1e-6 || origin.y <= frame.ground.x {
        return NO_HIT;
    }
    let t = (frame.ground.x - origin.y) / direction.y;
    return select(NO_HIT, t, t >= frame.depth.z);
}

// Depth at which a view ray meets the ground.
fn ground_depth(ray: Ray) -> f32 {
    return ground_t(world_point(ray.origin), world_vector(ray.direction));
}
